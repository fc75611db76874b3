"""What one run of a controller comes to, as figures by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.rotation import angle_between
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.course import PERIOD_S, Course
from services.experiments.cartesian.metrics import (
    Estimate,
    distances_to_curve,
    estimate,
    judge_move,
)

SETTLED_S = 0.5  # at the end of a dwell, in which the hand is taken to stand
RUN_IN_S = 3.0  # of a curve, which every controller begins from rest
CROSSED_DEG = 0.01
SMOOTHED_HZ = {"boards": 5.0}  # before the jerk is taken; see judge_move

MM, DEG, PERCENT = 1e3, 180.0 / np.pi, 1e2


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """One column of the results."""

    key: str
    heading: str  # of the table
    unit: str
    meaning: str
    first: bool = True  # also shown where there is little room


MOVES = (
    Metric(key="error_mm", heading="error", unit="mm", meaning="position error at rest"),
    Metric(key="error_deg", heading="error", unit="deg", meaning="orientation error at rest"),
    Metric(key="perpendicular", heading="off line", unit="%", meaning="off the straight line"),
    Metric(
        key="deviation",
        heading="off m.j.",
        unit="%",
        meaning="off the minimum-jerk motion",
        first=False,
    ),
    Metric(
        key="profile",
        heading="profile",
        unit="%",
        meaning="RMS off the minimum-jerk profile",
        first=False,
    ),
    Metric(key="t98_s", heading="98 %", unit="s", meaning="98 % of the way after"),
    Metric(
        key="peak",
        heading="peak at",
        unit="t98",
        meaning="fastest at this share of that",
        first=False,
    ),
    Metric(key="jerk", heading="jerk", unit="opt.", meaning="squared jerk over minimum jerk's"),
)
CURVE = (
    Metric(key="tracking_mm", heading="error", unit="mm", meaning="RMS position error"),
    Metric(key="tracking_deg", heading="error", unit="deg", meaning="RMS orientation error"),
    Metric(key="curve_mm", heading="off curve", unit="mm", meaning="mean distance off the curve"),
)
CROSSED = (
    Metric(key="crossed", heading="crossed", unit="%", meaning="of the time beyond a limit"),
    Metric(key="row_deg", heading="by", unit="deg", meaning="shoulder or elbow row crossed by"),
)
BESIDE = (  # in the report alone
    Metric(key="range_deg", heading="range", unit="deg", meaning="joint range exceeded by"),
    Metric(key="asked_deg", heading="asked", unit="deg", meaning="limits crossed by the reference"),
)
KEPT = ("row_deg", "range_deg", "asked_deg")


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """A controller along a course on one arm."""

    controller: str
    plant: str
    seed: int
    arm: Arm
    course: Course
    references_rad: Matrix  # (k, n)
    angles_rad: Matrix  # (k + 1, n): true, at the begin of each period and at the end of the last

    @cached_property
    def hand(self) -> tuple[Matrix, Matrix]:
        """Positions (k + 1, 3) and rotations (k + 1, 3, 3)."""
        poses = [self.arm.tip.pose(q) for q in self.angles_rad]
        return np.array([p for _, p in poses]), np.array([R for R, _ in poses])


def shown_metrics(course: Course) -> tuple[Metric, ...]:
    """Columns of a course's table."""
    return (*(MOVES if course.moves else CURVE), *CROSSED)


def metrics_of(course: Course) -> tuple[Metric, ...]:
    """What a run along a course is judged by."""
    return (*shown_metrics(course), *BESIDE)


def judged(run: Run) -> dict[str, float]:
    """Every figure of a run, by the keys of its metrics."""
    positions, rotations = run.hand
    if run.course.moves:
        smoothed_hz = SMOOTHED_HZ.get(run.plant)
        return {**_moves(run.course, positions, rotations, smoothed_hz), **_limits(run)}
    return {**_curve(run.course, positions, rotations), **_limits(run)}


def summed_up(runs: Sequence[Mapping[str, float]]) -> dict[str, Estimate]:
    """Mean and confidence of each figure over the repetitions."""
    return {key: estimate([run[key] for run in runs]) for key in runs[0]} if runs else {}


def _moves(
    course: Course, positions: Matrix, rotations: Matrix, smoothed_hz: float | None
) -> dict[str, float]:
    """Means over the moves of a run."""
    ends = [*course.moves[1:], course.periods]
    standing = round(SETTLED_S / PERIOD_S)
    start = positions[0]
    moves, off_m, off_rad = [], [], []
    for begin, end in zip(course.moves, ends, strict=True):
        goal = course.position_m[begin]
        hand = positions[begin : end + 1]
        moves.append(judge_move(hand, start, goal, PERIOD_S, smoothed_hz=smoothed_hz))
        last = slice(end + 1 - standing, end + 1)
        off_m.append(float(np.linalg.norm(positions[last] - goal, axis=1).mean()))
        off_rad.append(_mean_angle(rotations[last], course.rotation[begin]))
        start = positions[end]

    def mean(values: Sequence[float]) -> float:
        return float(np.mean(values))

    return {
        "error_mm": mean(off_m) * MM,
        "error_deg": mean(off_rad) * DEG,
        "perpendicular": mean([move.perpendicular for move in moves]) * PERCENT,
        "deviation": mean([move.deviation for move in moves]) * PERCENT,
        "profile": mean([move.profile_rms for move in moves]) * PERCENT,
        "t98_s": mean([move.t98_s for move in moves]),
        "peak": mean([move.peak_share for move in moves]),
        "jerk": mean([move.jerk for move in moves]),
    }


def _curve(course: Course, positions: Matrix, rotations: Matrix) -> dict[str, float]:
    judged_from = round(RUN_IN_S / PERIOD_S)
    during = slice(judged_from, course.periods)
    off: Vector = np.linalg.norm(positions[during] - course.position_m[during], axis=1)
    turned = [
        angle_between(R, wanted)
        for R, wanted in zip(rotations[during], course.rotation[during], strict=True)
    ]
    return {
        "tracking_mm": float(np.sqrt(np.square(off).mean())) * MM,
        "tracking_deg": float(np.sqrt(np.square(turned).mean())) * DEG,
        "curve_mm": float(distances_to_curve(positions[during], course.position_m).mean()) * MM,
    }


def _limits(run: Run) -> dict[str, float]:
    """Beyond the robot's own limits, which are wider than a planner's."""
    n = run.arm.hard_limits.n
    outside = _outside_deg(run, run.angles_rad)
    return {
        "range_deg": max(0.0, float(outside[:, :n].max())),
        "row_deg": max(0.0, float(outside[:, n:].max(initial=0.0))),
        "crossed": float((outside.max(axis=1) > CROSSED_DEG).mean()) * PERCENT,
        "asked_deg": max(0.0, float(_outside_deg(run, run.references_rad).max())),
    }


def _outside_deg(run: Run, angles_rad: Matrix) -> Matrix:
    limits = run.arm.hard_limits
    values = angles_rad @ limits.C.T
    outside: Matrix = DEG * np.maximum(limits.lower - values, values - limits.upper)
    return outside


def _mean_angle(rotations: Matrix, wanted: Matrix) -> float:
    return float(np.mean([angle_between(R, wanted) for R in rotations]))
