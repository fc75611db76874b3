"""Searches that are cut short: the posture they began from comes back, and they say so."""

import numpy as np

from benchmarks.ik_setting import Setting
from dforc.ik.inverse_kinematics import IkResult, IkStatus
from dforc.ik.problem import TipTarget
from services.experiments.ik.arm import TOLERANCE_M, Arm, Array
from services.experiments.ik.measure import KEPT_RAD, ROUNDING, percent
from services.experiments.rows import Row, at_least

POSES = 100
BUDGETS = (1, 2, 5, 10, 20)


def rows(setting: Setting) -> list[Row]:
    """Every budget, searching and tracking."""
    arm, ik = setting.arm, setting.ours().ik
    rng = np.random.default_rng([setting.seed, 7])
    count = POSES // 5 if setting.short else POSES
    found: list[Row] = []
    for way in ("search", "track"):
        honest, late = [], 0
        for start, q in zip(arm.postures(rng, count), arm.postures(rng, count), strict=True):
            R, p = arm.pose(q)
            target = [TipTarget.checked(p, R)]
            for budget in BUDGETS:
                if way == "search":
                    result = ik.solve(target, start, budget=budget)
                else:
                    result = ik.track(target, start, budget=budget)
                honest.append(_is_honest(arm, result, start, p))
                late += result.status is IkStatus.OUT_OF_TIME
        what = f"{way} with budgets {', '.join(map(str, BUDGETS))}"
        found += [
            Row(f"{what}: out of time", 100.0 * late / len(honest), "%"),
            at_least(
                f"{what}: start returned and said so, or an answer",
                percent(np.array(honest)),
                "%",
                100.0,
            ),
        ]
    return found


def _is_honest(arm: Arm, result: IkResult, start: Array, p: Array) -> bool:
    """Nothing half done: the start, an answer, or a nearest posture; all inside the limits."""
    q = np.array(result.q_rad)
    if arm.violation(q) > KEPT_RAD:
        return False
    if result.status is IkStatus.OUT_OF_TIME:
        return bool(np.array_equal(q, start)) and result.reason != ""
    reached = arm.distance_m(q, p) <= ROUNDING * TOLERANCE_M
    return reached == (result.status is IkStatus.CONVERGED)
