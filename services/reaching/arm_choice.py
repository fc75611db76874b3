"""Which of two hands goes to a pose: the nearer one; the one before unless it is clearly not."""

import math
from collections.abc import Mapping

from dforc.arrays import ArrayLike

ADVANTAGE_M = 0.05  # that the other hand must have: between the two nothing flaps


def nearer_arm(target_m: ArrayLike, hands_m: Mapping[str, ArrayLike], before: str = "") -> str:
    """Name of the arm whose hand is nearest.

    Args:
        target_m: where to (3,).
        hands_m: hand positions (3,) by arm; at least one.
        before: the arm that was chosen last; it stays so unless another one is nearer by 5 cm.
    """
    distances = {arm: math.dist(target_m, hand_m) for arm, hand_m in hands_m.items()}
    nearest = min(distances, key=distances.__getitem__)
    if before in distances and distances[nearest] > distances[before] - ADVANTAGE_M:
        return before
    return nearest
