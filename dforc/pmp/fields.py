"""The two functions of PMP that are not springs: joint limits (eq. 9) and time base (eq. 10)."""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.compiled import compiled

NEAREST_TO_LIMIT = 0.9999  # of lambda: S stays finite, at 9.9


@compiled
def limit_field(q_rad: Vector, lower_rad: Vector, upper_rad: Vector) -> Vector:
    """S(q) of eq. 9 (n,): positive at the lower limit, negative at the upper one, 0 half way.

    S = log((1 - l) / (1 + l)) with l = 2 (q - q_min) / (q_max - q_min) - 1. The printed l lacks the
    factor 2: it would push to one side only, and not at all at the upper limit.
    """
    S = np.empty(len(q_rad))
    for i in range(len(q_rad)):
        place = 2.0 * (q_rad[i] - lower_rad[i]) / (upper_rad[i] - lower_rad[i]) - 1.0
        place = min(max(place, -NEAREST_TO_LIMIT), NEAREST_TO_LIMIT)
        S[i] = math.log((1.0 - place) / (1.0 + place))
    return S


@compiled
def time_base(time_s: float, duration_s: float, epsilon: float) -> float:
    """Gamma of eq. 10 [1/s]: 0 before the start and from `duration_s` on.

    Along an eigenvector of K J A J' with the eigenvalue l it leaves (epsilon / (1 + epsilon))^l of
    the error: next to nothing where l >= 1, and much of it where l is small.
    """
    s = time_s / duration_s
    if not 0.0 < s < 1.0:
        return 0.0
    progress = s * s * s * (10.0 + s * (6.0 * s - 15.0))
    rate = 30.0 * s * s * (1.0 - s) ** 2 / duration_s
    return rate / (1.0 + epsilon - progress)
