"""Figure 6: the green ball goes to the side in front of the robot, the red one comes down."""

import numpy as np
from numpy.typing import NDArray

from services.experiments.field_scenes.moving_draw import (
    MOVES_S,
    NOISE_M,
    PERIOD_S,
    MovingScene,
    minimum_jerk,
)

Array = NDArray[np.float64]

LASTS_S = 10.0
# Base frame of the iCub: x backwards, y to the robot's right, z up. All in reach of the right hand.
FROM_M = np.array([-0.27, 0.28, 0.02])
TO_M = np.array([-0.30, 0.03, 0.07])
SPREAD_M = 0.01  # sigma of both ends
MEETS_SHARE = (0.4, 0.6)  # of the way, where the red ball crosses it
FALLS_M_S = (0.05, 0.1)
# The ball crosses between the target's passing and that of the paper's point, which lags 2 s: slow
# enough to be in the way of both.
LATE_S = (0.5, 1.5)
BESIDE_M = 0.01


def fig6_scene(rng: np.random.Generator) -> MovingScene:
    """One run, noise included."""
    count = round(LASTS_S / PERIOD_S)
    t = np.linspace(0.0, PERIOD_S * count, count + 1)
    start, end = FROM_M + rng.normal(0.0, SPREAD_M, 3), TO_M + rng.normal(0.0, SPREAD_M, 3)
    target = start + minimum_jerk(t / MOVES_S)[:, None] * (end - start)
    share = rng.uniform(*MEETS_SHARE)
    meets_s = float(np.interp(share, minimum_jerk(t / MOVES_S), t)) + rng.uniform(*LATE_S)
    place = start + share * (end - start) + rng.normal(0.0, BESIDE_M, 3)
    speed = rng.uniform(*FALLS_M_S)
    obstacle = place - np.array([0.0, 0.0, speed]) * (t - meets_s)[:, None]
    return MovingScene(
        target_m=target,
        obstacle_m=obstacle,
        seen_target_m=target + rng.normal(0.0, NOISE_M, target.shape),
        seen_obstacle_m=obstacle + rng.normal(0.0, NOISE_M, obstacle.shape),
    )
