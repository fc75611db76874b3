"""What the controller does with targets and starts that make no sense, or hardly any."""

from dataclasses import replace

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law, ParameterError
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget, SpeedTarget, Target, TipSpeed
from dforc.errors import NotFiniteError, ShapeError
from dforc.ik.problem import Tip
from dforc.limits import JointLimits
from dforc.rotation import angle_between, matrix

PERIOD_S = 0.01
STIFF = (False,) * 10
LAWS = pytest.mark.parametrize("law", list(Law))


@pytest.fixture
def controller(tip: Tip, limits: JointLimits) -> CartesianController:
    return CartesianController([tip], limits, CartesianParams(trajectory_time_s=1.0))


def to(position: Vector, R: Matrix | None, q: Vector) -> ReachTarget:
    return ReachTarget(tips=[PoseTarget(position_m=position, rotation=R)], q_rad=q)


def run(
    controller: CartesianController, q_start: Vector, target: Target | None, periods: int
) -> list[CartesianOutput]:
    state, outputs = controller.start(q_start), []
    for _ in range(periods):
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        outputs.append(output)
    return outputs


@pytest.mark.parametrize("spoil", [0.0 * np.eye(3), 1.01 * np.eye(3), np.diag([1.0, 1.0, -1.0])])
def test_matrix_that_is_no_rotation_is_refused(
    controller: CartesianController, tip: Tip, home: Vector, spoil: Matrix
) -> None:
    R, p = tip.pose(home)
    state = controller.start(home)
    measured = Measurement(q_rad=home, compliant=STIFF)
    with pytest.raises(ShapeError):
        controller.step(state, measured, to(p, R @ spoil, home))
    _, output = controller.step(state, measured, to(p, R, home))
    assert output.q_rad == pytest.approx(home, abs=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_speeds_that_are_not_finite_are_refused(
    controller: CartesianController, home: Vector, bad: float
) -> None:
    state, measured = controller.start(home), Measurement(q_rad=home, compliant=STIFF)
    for tip_speed in (
        TipSpeed(linear_m_s=(0.0, bad, 0.0)),
        TipSpeed(linear_m_s=(0.0, 0.0, 0.0), angular_rad_s=(bad, 0.0, 0.0)),
    ):
        with pytest.raises(NotFiniteError):
            controller.step(state, measured, SpeedTarget(tips=[tip_speed]))


def test_target_at_the_present_pose_moves_nothing_and_is_reached(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    R, p = tip.pose(home)
    outputs = run(controller, home, to(p, R, home), 20)
    assert all(output.in_target for output in outputs)
    assert outputs[0].progress == 1.0
    assert np.abs([output.plan_q_rad - home for output in outputs]).max() < 1e-12


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.6, 0.0, -0.8)])
def test_half_a_turn_goes_one_way_round_to_the_end(
    tip: Tip, axis: tuple[float, float, float]
) -> None:
    """Without limits that would stop the hand: only its wrist's kinematics count."""
    wide = JointLimits.make(np.full(10, -6.0), np.full(10, 6.0))
    params = CartesianParams(trajectory_time_s=2.0, coupling=CouplingParams(speed_limit_rad_s=20.0))
    controller = CartesianController([tip], wide, params)
    q = np.radians([0.0, 0.0, 0.0, -30.0, 40.0, 10.0, 60.0, 10.0, -20.0, 10.0])
    R, p = tip.pose(q)
    R_goal = matrix(np.pi * np.array(axis)) @ R
    outputs = run(controller, q, to(p, R_goal, q), 210)
    angles = [angle_between(output.tips[0].plan_rotation, R_goal) for output in outputs]
    assert angles[0] == pytest.approx(np.pi, abs=1e-6)
    assert max(np.diff(angles)) < 1e-3  # never back
    assert angles[100] == pytest.approx(np.pi / 2.0, abs=0.1)
    assert angles[-1] < 0.02


@LAWS
def test_all_joints_blocked_hold_still_for_every_target(
    controller: CartesianController, tip: Tip, home: Vector, law: Law
) -> None:
    R, p = tip.pose(home)
    params = replace(controller.params, law=law)
    stuck = controller.changed(free=(False,) * 10, params=params)
    for target in (
        to(p + 0.1, R, home),
        SpeedTarget(tips=[TipSpeed(linear_m_s=(0.1, 0.0, 0.0))]),
    ):
        outputs = run(stuck, home, target, 60)
        assert np.abs(outputs[-1].plan_q_rad - home).max() < 1e-9
        assert not outputs[-1].in_target
        assert outputs[-1].at_rest


@LAWS
def test_start_outside_the_limits_does_not_jump_and_comes_back_within_a_second(
    controller: CartesianController, tip: Tip, limits: JointLimits, home: Vector, law: Law
) -> None:
    """The elbow 4 degrees beyond its end, and shoulder roll and yaw beyond a row."""
    outside = home.copy()
    outside[6] = limits.lower_rad[6] - np.radians(4.0)
    outside[4] = np.radians(26.4188 - 2.0)
    assert limits.violation(outside) > np.radians(3.9)
    changed = controller.changed(params=replace(controller.params, law=law))
    R, p = tip.pose(home)
    for target in (None, to(p, R, home), SpeedTarget(tips=[TipSpeed(linear_m_s=(0.0, 0.0, 0.02))])):
        outputs = run(changed, outside, target, 150)
        assert outputs[0].q_rad == pytest.approx(outside, abs=2e-3)
        assert limits.violation(outputs[-1].plan_q_rad) < 1e-7
        steps = np.abs(np.diff([output.plan_q_rad for output in outputs], axis=0)).max()
        assert steps < 0.03


def test_references_never_leave_the_ranges_further_than_the_start_did(
    controller: CartesianController, limits: JointLimits, home: Vector
) -> None:
    outside = home.copy()
    outside[6] = limits.lower_rad[6] - np.radians(4.0)
    for output in run(controller, outside, None, 150):
        assert (output.q_rad >= np.minimum(limits.lower_rad, outside) - 1e-9).all()
        assert (output.q_rad <= np.maximum(limits.upper_rad, outside) + 1e-9).all()


def test_pose_out_of_reach_is_approached_without_leaving_limits_or_trembling(
    controller: CartesianController, tip: Tip, limits: JointLimits, home: Vector
) -> None:
    """The posture given is the best there is; the hand comes to rest."""
    R, p = tip.pose(home)
    outputs = run(controller, home, to(p + np.array([-0.8, 0.0, 0.3]), R, home), 600)
    for output in outputs:
        assert limits.violation(output.plan_q_rad) <= 1e-8
    ends = np.array([output.plan_q_rad for output in outputs[-50:]])
    assert np.ptp(ends, axis=0).max() < np.radians(0.5)
    assert not outputs[-1].in_target


@pytest.mark.parametrize(
    "params",
    [
        CartesianParams(trajectory_time_s=0.0),
        CartesianParams(trajectory_time_s=np.nan),
        CartesianParams(stop_time_s=-1.0),
        CartesianParams(period_s=0.0),
        CartesianParams(coupling=CouplingParams(gamma=0.0)),
        CartesianParams(coupling=CouplingParams(gamma=np.inf)),
    ],
)
def test_tuning_that_is_none_is_refused(
    tip: Tip, limits: JointLimits, params: CartesianParams
) -> None:
    with pytest.raises(ParameterError):
        CartesianController([tip], limits, params)


def test_wrong_numbers_of_joints_and_tips_are_refused(
    controller: CartesianController, tip: Tip, limits: JointLimits, home: Vector
) -> None:
    R, p = tip.pose(home)
    with pytest.raises(ShapeError):
        CartesianController([], limits)
    with pytest.raises(ShapeError):
        CartesianController([tip], limits, free=[True] * 9)
    with pytest.raises(ShapeError):
        controller.start(home[:9])
    state, measured = controller.start(home), Measurement(q_rad=home, compliant=STIFF)
    with pytest.raises(ShapeError):
        controller.step(state, measured, to(p, R, home[:9]))
    with pytest.raises(ShapeError):
        controller.step(state, measured, SpeedTarget(tips=[]))
