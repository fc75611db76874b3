"""What a motion of the hand is worth: against the straight line, minimum jerk, and its target.

A minimum-jerk motion along the straight line, of the onset and the duration that fit best, is what
shape and jerk of a motion are measured by.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.signal import butter, filtfilt
from scipy.spatial import KDTree
from scipy.stats import t as student_t

from dforc.arrays import Matrix, Vector

REACHED = 0.98  # of the way
COARSE = 12
FITTED_POINTS = 250  # of a profile at most
OPTIMAL_JERK = 720.0  # integral of the squared jerk of a minimum-jerk motion, times T^5 / L^2
CONFIDENCE = 0.95
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
    onset_s: float  # of the minimum-jerk motion, since the goal jumped
    fitted_s: float  # its duration
    since_jump_s: float  # duration of the one that fits best among those that begin at the jump
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
    positions_m: Matrix,
    start_m: Vector,
    goal_m: Vector,
    period_s: float,
    *,
    smoothed_hz: float | None = None,
) -> MoveFigures:
    """Figures of one move.

    Args:
        positions_m: (k, 3), the first at the instant when the goal jumped.
        start_m: (3,) where the hand was at rest.
        goal_m: (3,).
        period_s: between two positions.
        smoothed_hz: corner of a filter before the jerk is taken, against what a drive's ticks and
            friction add to a motion; None: without.
    """
    way = goal_m - start_m
    distance = max(float(np.linalg.norm(way)), SHORTEST_WAY_M)
    unit = way / distance
    gone = positions_m - start_m
    along: Vector = gone @ unit / distance
    across = np.linalg.norm(gone - np.outer(gone @ unit, unit), axis=1)
    at_s = np.arange(len(along), dtype=np.float64) * period_s
    onset_s, fitted_s = _fitted(at_s, along, latest_s=0.5 * float(at_s[-1]))
    ideal = minimum_jerk((at_s - onset_s) / fitted_s)
    t98_s = reached_s(along, period_s)
    within = at_s <= max(onset_s + fitted_s, min(t98_s, float(at_s[-1])))
    speeds = np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    peak_s = (float(np.argmax(speeds)) + 0.5) * period_s
    smooth = positions_m if smoothed_hz is None else smoothed(positions_m, period_s, smoothed_hz)
    return MoveFigures(
        distance_m=distance,
        perpendicular=float(across.max()) / distance,
        deviation=float(np.linalg.norm(gone - np.outer(ideal, way), axis=1).max()) / distance,
        profile_rms=float(np.sqrt(np.square(along - ideal)[within].mean())),
        overshoot=max(0.0, float(along.max()) - 1.0),
        t98_s=t98_s,
        peak_share=peak_s / t98_s,
        onset_s=onset_s,
        fitted_s=fitted_s,
        since_jump_s=_fitted(at_s, along, latest_s=0.0)[1],
        jerk=squared_jerk(smooth, period_s) * fitted_s**5 / (OPTIMAL_JERK * distance**2),
    )


def reached_s(along: Vector, period_s: float, share: float = REACHED) -> float:
    """When a share of the way is behind the hand for the first time, between two instants."""
    reached = np.flatnonzero(along >= share)
    if not len(reached):
        return math.inf
    last = int(reached[0])
    if last == 0:
        return 0.0
    before, after = float(along[last - 1]), float(along[last])
    return period_s * (last - (after - share) / (after - before))


def smoothed(positions_m: Matrix, period_s: float, corner_hz: float) -> Matrix:
    """Positions (k, 3) through a filter of second order, there and back: nothing is shifted."""
    b, a = butter(2, 2.0 * corner_hz * period_s)
    return np.asarray(filtfilt(b, a, positions_m, axis=0), dtype=np.float64)


def squared_jerk(positions_m: Matrix, period_s: float) -> float:
    """Integral of the squared jerk (m^2/s^5) from rest on, with a jump at the onset if any."""
    from_rest = np.concatenate([np.repeat(positions_m[:1], 3, axis=0), positions_m])
    return float(np.square(np.diff(from_rest, 3, axis=0)).sum()) / period_s**5


def _fitted(at_s: Vector, along: Vector, *, latest_s: float) -> tuple[float, float]:
    """Onset and duration of the minimum-jerk motion next to a profile (least squares)."""
    every = 1 + len(at_s) // FITTED_POINTS
    at_s, along = at_s[::every], along[::every]
    last = float(at_s[-1])

    def misfit(guess: Vector) -> float:
        return float(np.square(minimum_jerk((at_s - guess[0]) / guess[1]) - along).sum())

    onsets = np.linspace(0.0, latest_s, COARSE) if latest_s else np.zeros(1)
    coarse = [np.array([a, b]) for a in onsets for b in np.linspace(last / COARSE, last, COARSE)]
    bounds = [(0.0, latest_s), (0.01 * last, last)]
    best = minimize(misfit, min(coarse, key=misfit), method="Nelder-Mead", bounds=bounds).x
    return float(best[0]), float(best[1])


def distances_to_curve(positions_m: Matrix, curve_m: Matrix) -> Vector:
    """Distance (m) of each position from the nearest point of a curve (c, 3)."""
    nearest, _ = KDTree(curve_m).query(positions_m)
    return np.asarray(nearest, dtype=np.float64)


def estimate(values: list[float]) -> Estimate:
    """Mean of repetitions, and how sure it is (Student's t)."""
    count = len(values)
    if not count or not all(math.isfinite(value) for value in values):
        return Estimate(mean=math.inf if count else math.nan, half_width=0.0, count=count)
    if count == 1:
        return Estimate(mean=values[0], half_width=0.0, count=1)
    spread = float(np.std(values, ddof=1)) / math.sqrt(count)
    quantile = float(student_t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1))
    return Estimate(mean=float(np.mean(values)), half_width=quantile * spread, count=count)
