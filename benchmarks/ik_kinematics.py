"""The kinematics that judge the answers, against the project's own."""

import numpy as np

from benchmarks.ik_setting import Setting
from services.experiments.ik.arm import Arm, both_arms, robot_arm
from services.experiments.ik.contenders import problem_of
from services.experiments.rows import Row, at_most

POSTURES = 300
SAME = 1e-12


def rows(setting: Setting) -> list[Row]:
    """Largest difference of poses [m, matrix elements] and of limits [rad]."""
    rng = np.random.default_rng(setting.seed)
    return [_row(arm, rng) for arm in (setting.arm, robot_arm(), both_arms())]


def _row(arm: Arm, rng: np.random.Generator) -> Row:
    problem, worst = problem_of(arm), 0.0
    for q in arm.postures(rng, POSTURES):
        for tip in range(len(arm.tips)):
            R, p = problem.tips[tip].pose(q)
            own_R, own_p = arm.pose(q, tip)
            worst = max(worst, float(np.abs(R - own_R).max()), float(np.abs(p - own_p).max()))
        outside = problem.limits.violation(q) - arm.violation(q)
        worst = max(worst, abs(outside))
    return at_most(f"kinematics and limits, ours less the judge's, {arm.name}", worst, "", SAME)
