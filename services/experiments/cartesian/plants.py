"""Arms of the Cartesian experiment that need no boards: a perfect one, and one that lags."""

from collections import deque

import numpy as np

from dforc.arrays import Matrix, Vector

LAG_S, DELAY_S = 0.060, 0.020
LAG_SPREAD = 0.2  # of the lag, to either side, from joint to joint and seed to seed
STEP_S = 0.001


def ideal(references_rad: Matrix) -> Matrix:
    """Joint angles (k, n) of an arm that is where its references are."""
    return references_rad.copy()


def lagged(references_rad: Matrix, period_s: float, seed: int) -> Matrix:
    """Joint angles (k, n) at the end of each period behind a delay and a first-order lag.

    Each joint has a lag of its own, drawn by the seed; all have the delay.
    """
    draw = np.random.default_rng(seed)
    start: Vector = references_rad[0]
    lag_s = LAG_S * draw.uniform(1.0 - LAG_SPREAD, 1.0 + LAG_SPREAD, len(start))
    steps = round(period_s / STEP_S)
    share = -np.expm1(-STEP_S / lag_s)
    waiting = deque([start] * round(DELAY_S / STEP_S))
    q, angles = start.copy(), []
    for reference in references_rad:
        for _ in range(steps):
            waiting.append(reference)
            q = q + share * (waiting.popleft() - q)
        angles.append(q)
    return np.array(angles)
