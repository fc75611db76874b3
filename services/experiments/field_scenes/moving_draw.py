"""A ball to follow, and a ball that comes down across its way, both seen with noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PERIOD_S = 0.01
MOVES_S, LASTS_S = 6.0, 12.0  # minimum jerk, then still
LENGTH_M = (0.3, 0.4)  # of the target's way: 0.1 m/s at its fastest, on average
RISE_M = 0.05  # of that way, at most up or down
OBSTACLE_M = 0.05  # radius
MEETS_SHARE = (0.3, 0.7)  # of the target's way, where the obstacle crosses it
# When it does, after the target was there: some time until the point of the paper's field passes,
# which is (D / K) 2 s behind. With 0 it would meet the target, and the paper's point hardly ever.
LATE_S = (0.0, 2.0)
UNSURE_S = 0.3  # sigma of that
BESIDE_M = 0.02  # sigma of how far beside the way
NOISE_M = 0.01  # sigma, each axis, on both


@dataclass(frozen=True, eq=False)
class MovingScene:
    """Places (k, 3) at every period, true and as seen; the point starts where the target does."""

    target_m: Array
    obstacle_m: Array
    seen_target_m: Array
    seen_obstacle_m: Array


def moving_scene(
    rng: np.random.Generator, speed_m_s: float, noise_m: float = NOISE_M
) -> MovingScene:
    """One run with an obstacle that falls at some speed."""
    count = round(LASTS_S / PERIOD_S)
    t = np.linspace(0.0, PERIOD_S * count, count + 1)
    heading = rng.uniform(0.0, 2.0 * np.pi)
    way = rng.uniform(*LENGTH_M) * np.array([np.cos(heading), np.sin(heading), 0.0])
    way[2] = rng.uniform(-RISE_M, RISE_M)
    target = minimum_jerk(t / MOVES_S)[:, None] * way
    share = rng.uniform(*MEETS_SHARE)
    meets_s = float(np.interp(share, minimum_jerk(t / MOVES_S), t))
    meets_s += rng.uniform(*LATE_S) + rng.normal(0.0, UNSURE_S)
    place = share * way + np.array([*rng.normal(0.0, BESIDE_M, 2), 0.0])
    obstacle = place - np.array([0.0, 0.0, speed_m_s]) * (t - meets_s)[:, None]
    return MovingScene(
        target_m=target,
        obstacle_m=obstacle,
        seen_target_m=target + rng.normal(0.0, noise_m, target.shape),
        seen_obstacle_m=obstacle + rng.normal(0.0, noise_m, obstacle.shape),
    )


def minimum_jerk(share: Array) -> Array:
    """Part of the way after a share of the time."""
    s = np.clip(share, 0.0, 1.0)
    part: Array = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return part
