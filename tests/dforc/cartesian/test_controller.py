"""The Cartesian controller on an ideal arm and on one with lag, sag and friction."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from dforc.arrays import ArrayLike, Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.outer_correction import CorrectionParams
from dforc.cartesian.params import CartesianParams, CouplingParams
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.errors import NotFiniteError
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import Tip, TipTarget
from dforc.limits import JointLimits
from dforc.rotation import angle_between

PERIOD_S = 0.01
ALL = (True,) * 10
Arm = Callable[[Vector], Vector]  # reference of a period -> joint angles at its end
Path = Callable[[float], tuple[Vector, Vector]]  # time -> position, velocity of the target


@pytest.fixture
def controller(tip: Tip, limits: JointLimits) -> CartesianController:
    return CartesianController([tip], limits)


def reach(
    position: Vector, R: Matrix, q: Vector, velocity: ArrayLike = (0.0, 0.0, 0.0)
) -> ReachTarget:
    pose = PoseTarget(position_m=position, rotation=R, velocity_m_s=velocity)
    return ReachTarget(tips=(pose,), q_rad=q)


def posture(solver: InverseKinematics, position: Vector, R: Matrix, q_start: Vector) -> Vector:
    return solver.solve([TipTarget.checked(position, R)], q_start).q_rad


class FrictionArm:
    """Joints that trail their reference, sag, and stick within a band (inner-loop reference)."""

    def __init__(self, q: Vector, seed: int) -> None:
        self.q = q.copy()
        rng = np.random.default_rng(seed)
        self._band = np.radians([0.05] * 3 + [0.5, 0.5, 0.15, 0.15, 0.1, 0.35, 0.35])
        self._lag_s = np.array([0.044] * 3 + [0.06] * 4 + [0.044, 0.1, 0.1])
        loose = np.array([0.0] * 3 + [1.0] * 4 + [0.2] * 3)
        self._sag = np.radians(rng.uniform(-0.3, 0.3, 10) * loose)
        self.push_rad = np.zeros(10)

    def __call__(self, q_ref: Vector) -> Vector:
        for _ in range(10):
            away = q_ref + self._sag + self.push_rad - self.q
            moved = np.sign(away) * np.maximum(np.abs(away) - self._band, 0.0)
            self.q = self.q + moved * 0.001 / self._lag_s
        return self.q


def ideal(q_ref: Vector) -> Vector:
    return q_ref


def follow(
    controller: CartesianController,
    solver: InverseKinematics,
    home: Vector,
    R: Matrix,
    path: Path,
    arm: Arm,
    seconds: float,
) -> list[CartesianOutput]:
    """Run inverse kinematics and controller on a moving target."""
    state, q, q_target = controller.start(home), home, home
    outputs = []
    for tick in range(int(seconds / PERIOD_S)):
        position, velocity = path(tick * PERIOD_S)
        q_target = solver.track([TipTarget.checked(position, R)], q_target).q_rad
        target = reach(position, R, q_target, velocity)
        state, output = controller.step(state, Measurement(q_rad=q, compliant=ALL), target)
        q = arm(output.q_rad)
        outputs.append(output)
    return outputs


def critically_damped(start: Vector, goal: Vector) -> Path:
    """The virtual point's free motion (both poles at -3 1/s)."""

    def path(t: float) -> tuple[Vector, Vector]:
        decay = math.exp(-3.0 * t)
        return goal + (start - goal) * (1.0 + 3.0 * t) * decay, (goal - start) * 9.0 * t * decay

    return path


def test_circle_is_followed_without_cutting_it(
    controller: CartesianController, solver: InverseKinematics, tip: Tip, home: Vector
) -> None:
    """0.1 m/s around a circle of 70 mm; the bar is 3 mm."""
    R, start = tip.pose(home)
    radius_m, speed_m_s = 0.07, 0.1
    centre, rate = start - [0.0, radius_m, 0.0], speed_m_s / radius_m

    def circle(t: float) -> tuple[Vector, Vector]:
        y, z = math.cos(rate * t), math.sin(rate * t)
        return centre + radius_m * np.array([0.0, y, z]), speed_m_s * np.array([0.0, -z, y])

    outputs = follow(controller, solver, home, R, circle, ideal, 4.5)
    for tick, output in enumerate(outputs):
        assert np.linalg.norm(output.tips[0].plan_position_m - circle(tick * PERIOD_S)[0]) < 0.002
        assert np.linalg.norm(output.tips[0].plan_position_m - centre) > radius_m - 0.0005
        assert angle_between(output.tips[0].plan_rotation, R) < 0.005


def test_jump_of_the_target_gives_a_straight_minimum_jerk_move(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
) -> None:
    R, start = tip.pose(home)
    goal = start + np.array([-0.06, 0.10, 0.12])
    q_goal = posture(solver, goal, R, home)
    params = CartesianParams(trajectory_time_s=1.0, coupling=CouplingParams(speed_limit_rad_s=6.0))
    controller = CartesianController([tip], limits, params)
    state, q = controller.start(home), home
    target = reach(goal, R, q_goal)
    way, length = goal - start, float(np.linalg.norm(goal - start))
    for tick in range(150):
        state, output = controller.step(state, Measurement(q_rad=q, compliant=ALL), target)
        q = output.plan_q_rad
        share = float((output.tips[0].plan_position_m - start) @ way) / length**2
        s = min(tick * PERIOD_S, 1.0)
        assert share == pytest.approx(10 * s**3 - 15 * s**4 + 6 * s**5, abs=0.01)
        assert np.linalg.norm(output.tips[0].plan_position_m - start - share * way) < 0.02 * length
    assert np.linalg.norm(output.tips[0].plan_position_m - goal) < 2e-4


def test_retargeting_changes_no_speed_abruptly(
    controller: CartesianController, solver: InverseKinematics, tip: Tip, home: Vector
) -> None:
    R, start = tip.pose(home)
    goals = start + np.array([[-0.05, 0.0, 0.1], [0.02, -0.1, 0.03]])
    state, q, speeds = controller.start(home), home, []
    for goal in goals:
        q_goal = posture(solver, goal, R, home)
        target = reach(goal, R, q_goal)
        for _ in range(25):  # half of the trajectory time
            state, output = controller.step(state, Measurement(q_rad=q, compliant=ALL), target)
            q = output.q_rad
            speeds.append(output.dq_rad_s)
    changes = np.abs(np.diff(np.array(speeds), axis=0)).max(axis=1)
    assert changes[23:27].max() < 0.15 * np.abs(speeds).max()  # 10 ms of a 0.5 s move


@pytest.mark.parametrize("seed", range(3))
def test_correction_takes_out_lag_sag_and_friction(
    solver: InverseKinematics,
    tip: Tip,
    limits: JointLimits,
    home: Vector,
    seed: int,
) -> None:
    # Without the band of rest, which is made for the ticks of an encoder; this arm has none.
    params = CartesianParams(correction=CorrectionParams(settle_rad=0.0, wake_rad=0.0))
    controller = CartesianController([tip], limits, params)
    R, start = tip.pose(home)
    goal = start + np.array([-0.05, -0.1, 0.1])
    path = critically_damped(start, goal)
    outputs = follow(controller, solver, home, R, path, FrictionArm(home, seed), 5.0)
    assert max(output.position_error_m for output in outputs[-100:]) < 1e-3
    assert max(output.orientation_error_rad for output in outputs[-100:]) < math.radians(0.5)


def test_band_of_rest_costs_less_than_two_millimetres(
    controller: CartesianController, solver: InverseKinematics, tip: Tip, home: Vector
) -> None:
    R, start = tip.pose(home)
    path = critically_damped(start, start + np.array([-0.05, -0.1, 0.1]))
    outputs = follow(controller, solver, home, R, path, FrictionArm(home, 0), 5.0)
    assert max(output.position_error_m for output in outputs[-100:]) < 2e-3
    at_rest = [output.q_rad for output in outputs[-50:]]
    assert np.ptp(at_rest, axis=0).max() < 1e-3


def test_without_the_correction_friction_stays(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
) -> None:
    params = CartesianParams(correction=CorrectionParams(gain_per_s=0.0))
    controller = CartesianController([tip], limits, params)
    R, start = tip.pose(home)
    path = critically_damped(start, start + np.array([-0.05, -0.1, 0.1]))
    outputs = follow(controller, solver, home, R, path, FrictionArm(home, 0), 5.0)
    assert outputs[-1].position_error_m > 1.5e-3


def test_pushed_arm_stays_compliant_and_comes_back(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    R, p = tip.pose(home)
    target = reach(p, R, home)
    state, arm = controller.start(home), FrictionArm(home, 0)
    output = None
    for tick in range(900):
        pushed = 300 <= tick < 600
        arm.push_rad = np.array([0.0] * 4 + [0.15] + [0.0] * 5) * pushed
        measured = Measurement(q_rad=arm.q, compliant=ALL, external_force_n=20.0 if pushed else 0.1)
        state, output = controller.step(state, measured, target)
        arm(output.q_rad)
        assert output.gated == pushed
        if tick == 599:
            assert output.position_error_m > 0.03  # did not push back
    assert output is not None
    assert output.position_error_m < 1e-3


def test_plan_keeps_limits_and_rows_and_the_reference_the_limits(
    controller: CartesianController,
    solver: InverseKinematics,
    tip: Tip,
    limits: JointLimits,
    home: Vector,
    postures: list[Vector],
) -> None:
    for goal_posture in postures[:6]:
        R, goal = tip.pose(goal_posture)
        q_goal = posture(solver, goal, R, home)
        target = reach(goal, R, q_goal)
        state, arm = controller.start(home), FrictionArm(home, 1)
        for _ in range(200):
            state, output = controller.step(state, Measurement(q_rad=arm.q, compliant=ALL), target)
            arm(output.q_rad)
            assert (output.q_rad >= limits.lower_rad - 1e-9).all()
            assert (output.q_rad <= limits.upper_rad + 1e-9).all()
            assert limits.violation(output.plan_q_rad) <= 1e-8


def test_start_is_the_reference_and_nothing_moves_without_a_target(
    controller: CartesianController, home: Vector
) -> None:
    state = controller.start(home)
    for _ in range(20):
        state, output = controller.step(state, Measurement(q_rad=home, compliant=ALL), None)
    assert output.held
    assert output.q_rad == pytest.approx(home, abs=1e-12)
    assert output.dq_rad_s == pytest.approx(np.zeros(10), abs=1e-12)


def test_lost_target_stops_the_plan_smoothly_and_for_good(
    controller: CartesianController, solver: InverseKinematics, tip: Tip, home: Vector
) -> None:
    R, start = tip.pose(home)
    goal = start + np.array([-0.05, 0.0, 0.12])
    q_goal = posture(solver, goal, R, home)
    target = reach(goal, R, q_goal)
    state, q, speeds = controller.start(home), home, []
    for tick in range(200):
        given = target if tick < 25 else None
        state, output = controller.step(state, Measurement(q_rad=q, compliant=ALL), given)
        q = output.plan_q_rad
        speeds.append(output.dq_rad_s)
    changes = np.abs(np.diff(np.array(speeds), axis=0)).max(axis=1)
    assert changes[25:].max() < 0.15 * np.abs(speeds).max()
    assert np.abs(speeds[-1]).max() < 1e-3
    assert (
        np.linalg.norm(output.tips[0].plan_position_m - goal) > 0.01
    )  # it did not go on to the goal


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_refused_and_the_state_can_go_on(
    controller: CartesianController, tip: Tip, home: Vector, bad: float
) -> None:
    R, p = tip.pose(home)
    state = controller.start(home)
    good = reach(p, R, home)
    spoilt = home.copy()
    spoilt[0] = bad
    for measured, target in (
        (Measurement(q_rad=spoilt, compliant=ALL), good),
        (Measurement(q_rad=home, compliant=ALL, external_force_n=bad), good),
        (
            Measurement(q_rad=home, compliant=ALL),
            reach(p * bad, R, home),
        ),
        (
            Measurement(q_rad=home, compliant=ALL),
            reach(p, R * bad, home),
        ),
        (
            Measurement(q_rad=home, compliant=ALL),
            reach(p, R, spoilt),
        ),
        (
            Measurement(q_rad=home, compliant=ALL),
            reach(p, R, home, (0.0, 0.0, bad)),
        ),
    ):
        with pytest.raises(NotFiniteError):
            controller.step(state, measured, target)
    _, output = controller.step(state, Measurement(q_rad=home, compliant=ALL), good)
    assert output.q_rad == pytest.approx(home, abs=1e-9)


def test_reference_leads_the_plan_by_the_lag_of_the_boards(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
) -> None:
    params = CartesianParams(lead_s=0.05, correction=CorrectionParams(gain_per_s=0.0))
    controller = CartesianController([tip], limits, params)
    R, start = tip.pose(home)
    path = critically_damped(start, start + np.array([-0.03, 0.0, 0.06]))
    for output in follow(controller, solver, home, R, path, ideal, 1.0):
        lead = output.q_rad - output.plan_q_rad
        assert lead == pytest.approx(0.05 * output.dq_rad_s, abs=1e-12)
