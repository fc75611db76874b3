"""The coupling of joint and task speeds: optimality, guard and limits."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.cartesian.coupling import Coupling, CouplingParams
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

PERIOD_S = 0.01


def test_speeds_minimise_the_weighted_sum_of_both_misses(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    gamma = 20.0
    coupling = Coupling(limits, CouplingParams(gamma=gamma))
    rng = np.random.default_rng(0)
    J = model.tip_jacobian(home)
    v_joint, v_task = rng.normal(size=10) * 0.1, rng.normal(size=6) * 0.05
    dq, limited = coupling.speeds(home, J, v_joint, v_task, PERIOD_S)
    gradient = (dq - v_joint) / (gamma * coupling.guard(home)) + J.T @ (J @ dq - v_task)
    assert not limited
    assert gradient == pytest.approx(np.zeros(10), abs=1e-12)


def test_large_gamma_gives_the_task_its_speed(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, CouplingParams(gamma=1e6))
    J, v_task = model.tip_jacobian(home), np.array([0.05, -0.02, 0.03, 0.0, 0.1, 0.0])
    dq, _ = coupling.speeds(home, J, np.zeros(10), v_task, PERIOD_S)
    assert J @ dq == pytest.approx(v_task, abs=1e-5)


def test_guard_fades_a_joint_out_at_both_ends(limits: JointLimits) -> None:
    coupling = Coupling(limits, CouplingParams(guard_ratio=0.1))
    middle = 0.5 * (limits.lower_rad + limits.upper_rad)
    width = 0.1 * (limits.upper_rad - limits.lower_rad)
    assert coupling.guard(middle) == pytest.approx(np.ones(10))
    assert coupling.guard(limits.upper_rad - 0.5 * width) == pytest.approx(np.zeros(10))
    assert coupling.guard(limits.lower_rad + 0.75 * width) == pytest.approx(np.full(10, 0.5))


def test_no_speed_carries_a_joint_or_a_row_across_its_limit(
    model: RobotModel, limits: JointLimits, postures: list[Vector]
) -> None:
    coupling = Coupling(limits, CouplingParams(speed_limit_rad_s=50.0, braking_time_s=0.0))
    rng = np.random.default_rng(1)
    met = 0
    for q in postures:
        v_joint, v_task = rng.normal(size=10) * 20.0, rng.normal(size=6) * 5.0
        dq, limited = coupling.speeds(q, model.tip_jacobian(q), v_joint, v_task, PERIOD_S)
        assert limits.violation(q + PERIOD_S * dq) <= 1e-9
        met += limited
    assert met > 10


def test_speed_limit_holds_for_every_joint(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, CouplingParams(speed_limit_rad_s=0.5))
    v_task = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    dq, limited = coupling.speeds(home, model.tip_jacobian(home), np.zeros(10), v_task, PERIOD_S)
    assert limited
    assert float(np.abs(dq).max()) == pytest.approx(0.5)
