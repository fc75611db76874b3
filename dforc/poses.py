"""When goals of hands count as others, and no longer as the same ones that have moved on."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.rotation import angle_between


class PoseGoal(Protocol):
    """Where a hand is to be, base frame."""

    @property
    def position_m(self) -> Vector | None:
        """Its place (3,)."""

    @property
    def rotation(self) -> Matrix | None:
        """Its orientation (3, 3)."""


def is_beyond(
    before: Sequence[PoseGoal | None],
    now: Sequence[PoseGoal | None],
    far_m: float,
    far_rad: float,
) -> bool:
    """Whether goals, one per hand, differ by more than that, or in kind."""
    if len(before) != len(now):
        return True
    return any(_differ(a, b, far_m, far_rad) for a, b in zip(before, now, strict=True))


def _differ(a: PoseGoal | None, b: PoseGoal | None, far_m: float, far_rad: float) -> bool:
    if a is None or b is None:
        return a is not b
    if a.position_m is None or b.position_m is None:
        if a.position_m is not b.position_m:
            return True
    elif float(np.linalg.norm(a.position_m - b.position_m)) > far_m:
        return True
    if a.rotation is None or b.rotation is None:
        return a.rotation is not b.rotation
    return angle_between(a.rotation, b.rotation) > far_rad
