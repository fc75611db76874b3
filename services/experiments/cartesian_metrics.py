"""What a motion of the hand is worth: against the straight line, minimum jerk, and its target.

A minimum-jerk motion along the straight line, of the duration (and, behind a lag, the onset) that
fits best, is what shape and jerk of a motion are measured by.
"""

import math
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.rotation import angle_between

REACHED = 0.98  # of the way
REFINEMENTS = 12
GRID = 25
OPTIMAL_JERK = 720.0  # integral of the squared jerk of a minimum-jerk motion, times T^5 / L^2
NORMAL_95 = 1.96
SHORTEST_WAY_M = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveFigures:
    """One move from pose to pose. Shares are of the distance from start to goal."""

    distance_m: float
    perpendicular: float  # largest distance from the straight line
    deviation: float  # largest distance from the minimum-jerk motion
    profile_rms: float  # of the share of the way, against the minimum-jerk motion's
    overshoot: float  # beyond the goal, along the line
    t98_s: float  # since the goal jumped; inf when never
    peak_share: float  # when the hand is fastest, over t98
    fitted_s: float  # duration of the minimum-jerk motion
    jerk: float  # integral of the squared jerk over the minimum-jerk motion's


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A mean and the half width of its 95 % confidence interval; 0 where nothing varies."""

    mean: float
    half_width: float
    count: int


def minimum_jerk(share_of_time: Vector) -> Vector:
    """Share of the way of a minimum-jerk motion, 0 before its begin and 1 after its end."""
    s = np.clip(share_of_time, 0.0, 1.0)
    way: Vector = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return way


def judge_move(
    positions_m: Matrix, start_m: Vector, goal_m: Vector, period_s: float
) -> MoveFigures:
    """Figures of one move.

    Args:
        positions_m: (k, 3), the first at the instant when the goal jumped.
        start_m: (3,) where the hand was at rest.
        goal_m: (3,).
        period_s: between two positions.
    """
    way = goal_m - start_m
    distance = max(float(np.linalg.norm(way)), SHORTEST_WAY_M)
    unit = way / distance
    gone = positions_m - start_m
    along: Vector = gone @ unit / distance
    across = np.linalg.norm(gone - np.outer(gone @ unit, unit), axis=1)
    at_s = np.arange(len(along), dtype=np.float64) * period_s
    onset_s, fitted_s = _fitted(at_s, along)
    ideal = minimum_jerk((at_s - onset_s) / fitted_s)
    reached = np.flatnonzero(along >= REACHED)
    t98_s = float(at_s[reached[0]]) if len(reached) else math.inf
    within = at_s <= max(onset_s + fitted_s, min(t98_s, float(at_s[-1])))
    speeds = np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    peak_s = (float(np.argmax(speeds)) + 0.5) * period_s
    return MoveFigures(
        distance_m=distance,
        perpendicular=float(across.max()) / distance,
        deviation=float(np.linalg.norm(gone - np.outer(ideal, way), axis=1).max()) / distance,
        profile_rms=float(np.sqrt(np.square(along - ideal)[within].mean())),
        overshoot=max(0.0, float(along.max()) - 1.0),
        t98_s=t98_s,
        peak_share=peak_s / t98_s,
        fitted_s=fitted_s,
        jerk=squared_jerk(positions_m, period_s) * fitted_s**5 / (OPTIMAL_JERK * distance**2),
    )


def squared_jerk(positions_m: Matrix, period_s: float) -> float:
    """Integral of the squared jerk (m^2/s^5) from rest on, with a jump at the onset if any."""
    from_rest = np.concatenate([np.repeat(positions_m[:1], 3, axis=0), positions_m])
    return float(np.square(np.diff(from_rest, 3, axis=0)).sum()) / period_s**5


def _fitted(at_s: Vector, along: Vector) -> tuple[float, float]:
    """Onset and duration of the minimum-jerk motion next to a profile (least squares)."""
    last = float(at_s[-1])
    least, most = np.array([0.0, 0.01 * last]), np.array([0.5 * last, last])
    low, high = least, most
    best = low
    for _ in range(REFINEMENTS):
        onsets, durations = np.linspace(low[0], high[0], GRID), np.linspace(low[1], high[1], GRID)
        shares = (at_s - onsets[:, None, None]) / durations[None, :, None]
        misfit = np.square(minimum_jerk(shares) - along).sum(axis=2)
        i, j = np.unravel_index(int(np.argmin(misfit)), misfit.shape)
        best = np.array([onsets[i], durations[j]])
        room = (high - low) / (0.25 * GRID)
        low, high = np.maximum(best - room, least), np.minimum(best + room, most)
    return float(best[0]), float(best[1])


def tracking_errors(
    positions_m: Matrix, rotations: Matrix, targets_m: Matrix, rotation: Matrix
) -> tuple[Vector, Vector]:
    """Distance (m) and angle (rad) of the hand (k, ...) from its target at every instant."""
    distances: Vector = np.linalg.norm(positions_m - targets_m, axis=1)
    angles = np.array([angle_between(R, rotation) for R in rotations])
    return distances, angles


def distances_to_curve(positions_m: Matrix, curve_m: Matrix) -> Vector:
    """Distance (m) of each position from the nearest point of a closed curve (c, 3)."""
    away = positions_m[:, None, :] - curve_m[None, :, :]
    nearest: Vector = np.sqrt(np.square(away).sum(axis=2).min(axis=1))
    return nearest


def estimate(values: list[float]) -> Estimate:
    """Mean of repetitions, and how sure it is (normal approximation)."""
    finite = [value for value in values if math.isfinite(value)]
    if not finite or len(finite) < len(values):
        return Estimate(mean=math.inf if values else math.nan, half_width=0.0, count=len(values))
    mean = float(np.mean(finite))
    spread = float(np.std(finite, ddof=1)) if len(finite) > 1 else 0.0
    half = NORMAL_95 * spread / math.sqrt(len(finite))
    return Estimate(mean=mean, half_width=half, count=len(finite))
