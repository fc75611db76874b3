"""Everybody on the four sets of single poses, and the bars that ours is held to."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from services.experiments.ik.arm import Arm, Array
from services.experiments.ik.contenders import Contender
from services.experiments.ik.measure import KEPT_RAD, Run, Worth, percent, search, worth
from services.experiments.ik.sets import (
    Say,
    Sizes,
    Targets,
    orientation_out,
    position_out,
    reachable,
)
from services.experiments.rows import Row, at_least, at_most

OURS = "ours (SQP)"
REFERENCE = "reference: IPOPT, eq.11"
TRAC = "TRAC-IK (wall)"
COLD, NEAR, ORIENTATION, POSITION = "cold", "near", "orientation", "position"

GOOD_PERCENT = 99.8
ANGLE_MEDIAN_DEG, ANGLE_P90_DEG = 0.05, 0.5
DISTANCE_P90_MM, DISTANCE_MOST_MM = 0.1, 1.0


@dataclass(frozen=True, eq=False)
class Sample:
    """One set, everybody's answers, and what they are worth."""

    name: str
    targets: Targets
    runs: dict[str, Run]
    worths: dict[str, Worth]

    def excess(self, name: str) -> Array:
        """Angle or distance beyond the smallest one; infinite without an answer."""
        w = self.worths[name]
        found = w.angle_rad - self.targets.best
        if self.name == POSITION:
            found = w.distance_m - self.targets.best
        return np.asarray(found)


Make = Callable[[Arm, int, Sizes, Say], Targets]
SETS: dict[str, Make] = {
    COLD: reachable,
    NEAR: reachable,
    ORIENTATION: orientation_out,
    POSITION: position_out,
}


def sample(
    name: str, arm: Arm, contenders: Sequence[Contender], seed: int, sizes: Sizes, say: Say
) -> Sample:
    """Solve one set, from the rest posture (`near`: from close to an answer)."""
    targets = SETS[name](arm, seed, sizes, say)
    say(f"{arm.name}, seed {seed}: {name}, {len(targets)} poses ...")
    starts = targets.near if name == NEAR else np.tile(arm.rest, (len(targets), 1))
    runs = search(contenders, targets, starts)
    worths = {who: worth(arm, targets.position, targets.rotation, run) for who, run in runs.items()}
    return Sample(name, targets, runs, worths)


def at(values: Array, share: float) -> float:
    """The smallest of the numbers, which may be infinite, that so many percent do not exceed."""
    return float(np.percentile(values, share, method="inverted_cdf"))


def bars(found: Sample, label: str = "") -> list[Row]:
    """What our answers to one set are held to, times apart."""
    name = found.name
    what = f"{label}{len(found.targets)} poses, {name}"
    if name == ORIENTATION:
        return _orientation_bars(found, f"{what} out of reach")
    if name == POSITION:
        return _position_bars(found, f"{what} out of reach")
    ours = found.worths[OURS]
    good = ours.feasible() & ours.optimal(found.targets.best)
    return [
        at_least(f"{what}: 1 mm, all limits kept", percent(ours.feasible()), "%", GOOD_PERCENT),
        at_least(f"{what}: and the best objective", percent(good), "%", GOOD_PERCENT),
    ]


def _orientation_bars(found: Sample, what: str) -> list[Row]:
    ours = found.worths[OURS].feasible()
    excess = np.degrees(np.where(ours, found.excess(OURS), np.inf))
    return [
        at_least(f"{what}: 1 mm, all limits kept", percent(ours), "%", 100.0),
        at_most(f"{what}: excess angle, median", at(excess, 50), "deg", ANGLE_MEDIAN_DEG),
        at_most(f"{what}: excess angle, p90", at(excess, 90), "deg", ANGLE_P90_DEG),
    ]


def _position_bars(found: Sample, what: str) -> list[Row]:
    excess = 1e3 * found.excess(OURS)
    kept = found.worths[OURS].outside_rad <= KEPT_RAD
    return [
        at_least(f"{what}: said so", percent(found.runs[OURS].said == 0.0), "%", 100.0),
        at_least(f"{what}: all limits kept", percent(kept), "%", 100.0),
        at_most(f"{what}: excess distance, p90", at(excess, 90), "mm", DISTANCE_P90_MM),
        at_most(f"{what}: excess distance, largest", at(excess, 100), "mm", DISTANCE_MOST_MM),
    ]
