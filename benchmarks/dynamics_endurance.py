"""Random ticks with a faulty sensor in one limb: no NaN ever comes out, other limbs stay the same.

Every tick is estimated twice, with all readings good and with one spoilt, and compared bit by bit
in everything that the spoilt sensor has no part in.
"""

from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.dynamics_scenes import LIMBS, robot
from benchmarks.newton_euler import Array
from dforc.errors import NotFiniteError
from dforc.estimation.assumption import standing
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.estimation.tree_model import TreeModel
from services.experiments.rows import Row, at_most

TICKS, SHORT_TICKS = 1_000_000, 20_000
BLOCK = 4096
SATURATED_N = 2000.0
NOT_A_NUMBER, INFINITE, LOST, SATURATED, FROZEN = range(5)
FAULTS = ("NaN", "infinite", "lost", "saturated", "frozen")

Say = Callable[[str], None]


class Endurance:
    """One estimator under faults, and what was counted."""

    def __init__(self, *, compiled: bool | None = None) -> None:
        made = robot("iCubLisboa01", LIMBS)
        self._estimator = WholeBodyEstimator(made.tree, standing(), compiled=compiled)
        self._n = made.tree.n
        self._apart = [_apart_from(made.tree, sensor) for sensor in range(len(LIMBS))]
        self._frozen = np.zeros((len(LIMBS), 6))
        self.seen: Counter[str] = Counter()

    def run(self, ticks: int, say: Say = lambda _: None) -> None:
        """So many random ticks."""
        rng = np.random.default_rng(30)
        for begin in range(0, ticks, BLOCK):
            count = min(BLOCK, ticks - begin)
            motions = rng.uniform(-2.0, 2.0, (count, 3, self._n))
            readings = rng.normal(0.0, 30.0, (count, len(LIMBS), 6))
            sensors = rng.integers(len(LIMBS), size=count)
            faults = rng.integers(len(FAULTS), size=count)
            for i in range(count):
                self._tick(motions[i], readings[i], int(sensors[i]), int(faults[i]))
            say(f"{begin + count} of {ticks} ticks")

    def _tick(self, motion: Array, readings: Array, sensor: int, fault: int) -> None:
        self.seen["ticks"] += 1
        q, dq, ddq = motion
        good = self._estimator.estimate(q, dq, ddq, readings)
        spoilt, valid = readings.copy(), np.ones(len(LIMBS), dtype=np.bool_)
        if fault == NOT_A_NUMBER:
            spoilt[sensor, self.seen["ticks"] % 6] = np.nan
        elif fault == INFINITE:
            spoilt[sensor] = np.inf
        elif fault == LOST:
            spoilt[sensor], valid[sensor] = np.nan, False
        elif fault == SATURATED:
            spoilt[sensor] = SATURATED_N
        else:
            spoilt[sensor] = self._frozen[sensor]
        self._frozen[sensor] = readings[sensor]
        try:
            found = self._estimator.estimate(q, dq, ddq, spoilt, valid)
        except NotFiniteError:
            self.seen["refused"] += 1
            valid[sensor] = False
            found = self._estimator.estimate(q, dq, ddq, spoilt, valid)
        self._compare(good, found, sensor)
        if fault in (NOT_A_NUMBER, INFINITE):
            self.seen["not finite"] += 1

    def _compare(self, good: BodyEstimate, found: BodyEstimate, sensor: int) -> None:
        if not np.isfinite(found.numbers).all():
            self.seen["NaN out"] += 1
        joints = self._apart[sensor]
        others = [limb for limb in range(len(LIMBS)) if limb != sensor]
        same = np.array_equal(good.tau_nm[joints], found.tau_nm[joints])
        same &= np.array_equal(good.contact_wrenches[others], found.contact_wrenches[others])
        self.seen["other limbs changed"] += not same


def _apart_from(tree: TreeModel, sensor: int) -> NDArray[np.intp]:
    """Joints that neither carry a sensor nor hang on it."""
    body = tree.sensor_body[sensor]
    beyond = {body}
    for other in range(body + 1, tree.bodies):
        if int(tree.parent[other]) in beyond:
            beyond.add(other)
    hangs = np.array([int(joint_body) in beyond for joint_body in tree.body_of_joint])
    return np.flatnonzero((tree.carries[:, body] == 0.0) & ~hangs)


def rows(*, short: bool, say: Say = lambda _: None) -> list[Row]:
    """What must never happen, and what must always happen."""
    endurance = Endurance()
    endurance.run(SHORT_TICKS if short else TICKS, say)
    seen = endurance.seen
    return [
        Row("endurance: random ticks with a fault", float(seen["ticks"])),
        at_most("endurance: NaN or infinity out", seen["NaN out"], "ticks", 0),
        at_most(
            "endurance: other limbs not bit-identical", seen["other limbs changed"], "ticks", 0
        ),
        at_most(
            "endurance: bad readings that were not refused",
            seen["not finite"] - seen["refused"],
            "ticks",
            0,
        ),
    ]
