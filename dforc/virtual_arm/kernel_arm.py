"""What the virtual arm wants of its hands and what its surroundings ask for, for numba."""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled

UNMOVED_M = 1e-6  # per rad: a distance that the limb does not change

Indices = NDArray[np.int64]


@compiled
def hand_speed(
    left: Vector,
    speed: Vector,
    goal_speed: Vector,
    stiffness: float,
    damping: float,
    fastest: float,
    share: float,
    period_s: float,
    wanted: Vector,
) -> None:
    """Eq. 3 for unit mass, its speed limited: wanted = dx + dt D (v - dx), v = (K/D) left + dx_t.

    A goal that is faster than the hand may be is followed as fast as it may.

    Args:
        left: from the hand to the goal (3,) [m], or a rotation vector [rad].
        speed: of the hand before (3,).
        goal_speed: of the goal (3,).
        stiffness: K.
        damping: D.
        fastest: limit of |v|.
        share: of the speed that is wanted now.
        period_s: of a step.
        wanted: the hand's next speed (3,).
    """
    scale = stiffness / damping
    size = 0.0
    for i in range(3):
        wanted[i] = scale * left[i] + goal_speed[i]
        size += wanted[i] * wanted[i]
    size = math.sqrt(size)
    kept = share * fastest / size if size > fastest else share
    gain = min(1.0, period_s * damping)
    for i in range(3):
        wanted[i] = speed[i] + gain * (kept * wanted[i] - speed[i])


@compiled
def surfaces(
    distances: Vector,
    drifts: Vector,
    gradients: Matrix,
    which: Indices,
    count: int,
    columns: Indices,
    others_dq: Vector,
    margin: float,
    self_margin: float,
    approach: float,
    withdraw: float,
    period_s: float,
    limb_gradients: Matrix,
    floors: Vector,
    pushes: Vector,
) -> tuple[int, float]:
    """Least speed of every distance, and its derivative by the limb's joints.

    Index of the smallest distance, and the least that is left of any beyond its margin.

    A distance may shrink by a share of what is left of it beyond the margin, and grows out of it:
    that part is its push.
    The speeds of obstacles (drifts) and of joints that are not the limb's count.
    """
    nearest, shortest, least = -1, np.inf, np.inf
    rate_in = min(approach, 1.0 / period_s)
    for k in range(count):
        kept = margin if which[k, 1] >= 0 else self_margin
        left = distances[k] - kept
        drift = drifts[k]
        for j in range(len(others_dq)):
            drift += gradients[k, j] * others_dq[j]
        moved = 0.0
        for j in range(len(columns)):
            limb_gradients[k, j] = gradients[k, columns[j]]
            moved += abs(gradients[k, columns[j]])
            drift -= gradients[k, columns[j]] * others_dq[columns[j]]
        rate = -rate_in * left if left >= 0.0 else -withdraw * left
        floors[k], pushes[k] = rate - drift, max(0.0, rate)
        if moved <= UNMOVED_M:
            floors[k], pushes[k] = -np.inf, 0.0
        least = min(least, left)
        if distances[k] < shortest:
            nearest, shortest = k, distances[k]
    return nearest, least
