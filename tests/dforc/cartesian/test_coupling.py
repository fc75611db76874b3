"""The coupling of joint and task speeds: optimality, guard and limits, by both laws."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.coupling import GAMMA, SHARES, Coupling
from dforc.cartesian.params import CouplingParams, ParameterError
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

PERIOD_S = 0.01
FREE = np.ones(10)
ALL = np.ones((1, 6))


def speeds(
    coupling: Coupling,
    limits: JointLimits,
    q: Vector,
    J: Matrix,
    v_joint: Vector,
    v_task: Vector,
    free: Vector = FREE,
) -> tuple[Vector, bool]:
    """By the time-to-go law, from rest."""
    bounds = np.array(limits.lower), np.array(limits.upper)
    J = np.ascontiguousarray(J)
    rest = np.zeros(10)
    return coupling.speeds(
        q, J, v_joint, rest, v_task.reshape(1, 6), ALL, free, 1.0, bounds, PERIOD_S
    )


def unhurried(speed_limit_rad_s: float, **others: float) -> CouplingParams:
    return CouplingParams(
        speed_limit_rad_s=speed_limit_rad_s, acceleration_limit_rad_s2=1e9, **others
    )


def test_reference_speeds_minimise_the_weighted_sum_of_both_misses(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    gamma = 20.0
    coupling = Coupling(limits, CouplingParams(gamma=gamma))
    rng = np.random.default_rng(0)
    J = model.tip_jacobian(home)
    v_joint, v_task = rng.normal(size=10) * 0.1, rng.normal(size=6) * 0.05
    dq = coupling.reference_speeds(home, J, v_joint, v_task.reshape(1, 6), ALL, FREE)
    gradient = (dq - v_joint) / (gamma * coupling.guard(home)) + J.T @ (J @ dq - v_task)
    assert gradient == pytest.approx(np.zeros(10), abs=1e-12)


def test_speeds_minimise_misses_weighed_across_and_along_the_way_and_in_turning(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, unhurried(50.0))
    rng = np.random.default_rng(0)
    J = model.tip_jacobian(home)
    v_joint, v_task = rng.normal(size=10) * 0.1, rng.normal(size=6) * 0.05
    dq, limited = speeds(coupling, limits, home, J, v_joint, v_task)
    across, along, turning = GAMMA * np.array(SHARES)
    unit = v_task[:3] / np.sqrt(v_task[:3] @ v_task[:3] + 1e-6)
    weights = np.zeros((6, 6))
    weights[:3, :3] = across * np.eye(3) + (along - across) * np.outer(unit, unit)
    weights[3:, 3:] = turning * np.eye(3)
    assert not limited
    assert (dq - v_joint) + J.T @ weights @ (J @ dq - v_task) == pytest.approx(
        np.zeros(10), abs=1e-7
    )


def test_large_gamma_gives_the_task_its_speed(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, CouplingParams(gamma=1e7, acceleration_limit_rad_s2=1e9))
    J, v_task = model.tip_jacobian(home), np.array([0.05, -0.02, 0.03, 0.0, 0.1, 0.0])
    dq, _ = speeds(coupling, limits, home, J, np.zeros(10), v_task)
    assert J @ dq == pytest.approx(v_task, abs=1e-5)


def test_guard_is_closed_in_the_outer_fortieth_and_a_tanh_over_the_next(
    limits: JointLimits,
) -> None:
    coupling = Coupling(limits, CouplingParams())
    middle = 0.5 * (limits.lower_rad + limits.upper_rad)
    fortieth = 0.025 * (limits.upper_rad - limits.lower_rad)
    assert coupling.guard(middle) == pytest.approx(np.ones(10))
    assert coupling.guard(limits.upper_rad - fortieth) == pytest.approx(np.zeros(10))
    assert coupling.guard(limits.lower_rad + 1.5 * fortieth) == pytest.approx(np.full(10, 0.5))
    off = 0.5 * (np.tanh(10.0 * 0.1) + 1.0)
    assert coupling.guard(limits.upper_rad - 1.6 * fortieth) == pytest.approx(np.full(10, off))
    assert coupling.guard(limits.upper_rad - 2.0 * fortieth) == pytest.approx(np.ones(10))


def test_no_speed_carries_a_joint_or_a_row_across_its_limit(
    model: RobotModel, limits: JointLimits, postures: list[Vector]
) -> None:
    coupling = Coupling(limits, unhurried(50.0, braking_rad_s2=1e9))
    rng = np.random.default_rng(1)
    met = 0
    for q in postures:
        v_joint, v_task = rng.normal(size=10) * 20.0, rng.normal(size=6) * 5.0
        dq, limited = speeds(coupling, limits, q, model.tip_jacobian(q), v_joint, v_task)
        assert limits.violation(q + PERIOD_S * dq) <= 1e-9
        met += limited
    assert met > 10


def test_speed_limit_holds_for_every_joint(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, unhurried(0.5))
    v_task = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    dq, limited = speeds(coupling, limits, home, model.tip_jacobian(home), np.zeros(10), v_task)
    assert limited
    assert float(np.abs(dq).max()) == pytest.approx(0.5)


def test_a_joint_may_have_a_speed_limit_of_its_own(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    own = (5.0,) * 6 + (0.1,) + (5.0,) * 3
    params = CouplingParams(speed_limit_rad_s=own, acceleration_limit_rad_s2=1e9)
    v_task = np.array([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    dq, _ = speeds(
        Coupling(limits, params), limits, home, model.tip_jacobian(home), np.zeros(10), v_task
    )
    assert abs(dq[6]) == pytest.approx(0.1)
    assert float(np.abs(dq).max()) > 0.2


def test_speed_changes_no_faster_than_the_acceleration_limit(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, CouplingParams(acceleration_limit_rad_s2=8.0))
    v_task = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    dq, limited = speeds(coupling, limits, home, model.tip_jacobian(home), np.zeros(10), v_task)
    assert limited
    assert float(np.abs(dq).max()) == pytest.approx(8.0 * PERIOD_S)


def test_joint_may_come_near_its_limit_only_as_fast_as_it_can_brake(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    """At d from the end the speed is below sqrt(2 a d)."""
    params = unhurried(50.0, braking_rad_s2=2.0)
    q = home.copy()
    q[6] = limits.upper_rad[6] - 0.04
    wish = np.zeros(10)
    wish[6] = 5.0
    none = np.zeros((1, 6))
    dq, limited = Coupling(limits, params).speeds(
        q,
        np.ascontiguousarray(model.tip_jacobian(q)),
        wish,
        np.zeros(10),
        none,
        none,
        FREE,
        1.0,
        (np.array(limits.lower), np.array(limits.upper)),
        PERIOD_S,
    )
    assert limited
    assert dq[6] == pytest.approx(np.sqrt(2.0 * 2.0 * 0.04), rel=0.03)
    assert dq[6] < np.sqrt(2.0 * 2.0 * 0.04)


def test_blocked_joint_keeps_its_own_speed_and_the_others_serve_the_task(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    coupling = Coupling(limits, unhurried(50.0, gamma=1e6))
    free = FREE.copy()
    free[0] = free[5] = 0.0
    v_joint = np.zeros(10)
    v_joint[5] = 0.2
    J, v_task = model.tip_jacobian(home), np.array([0.05, -0.02, 0.03, 0.0, 0.1, 0.0])
    dq, _ = speeds(coupling, limits, home, J, v_joint, v_task, free)
    assert dq[[0, 5]] == pytest.approx([0.0, 0.2], abs=1e-8)
    assert J @ dq == pytest.approx(v_task, abs=1e-3)


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, (1.0, 2.0)])
def test_speed_limits_that_are_none_are_refused(
    limits: JointLimits, limit: float | tuple[float, ...]
) -> None:
    with pytest.raises(ParameterError):
        Coupling(limits, CouplingParams(speed_limit_rad_s=limit))
