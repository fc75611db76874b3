"""When a motion is over, how far it has come, and what an arm in its target does not follow."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.ik.problem import Tip
from dforc.limits import JointLimits
from dforc.rotation import matrix

PERIOD_S = 0.01
STIFF = (False,) * 10
PARAMS = CartesianParams(trajectory_time_s=1.0, coupling=CouplingParams(speed_limit_rad_s=6.0))


@pytest.fixture
def controller(tip: Tip, limits: JointLimits) -> CartesianController:
    return CartesianController([tip], limits, PARAMS)


def to(tip: Tip, q: Vector, shift: Vector | None = None, R: Matrix | None = None) -> ReachTarget:
    R_there, p = tip.pose(q)
    p = p if shift is None else p + shift
    turned = R_there if R is None else R @ R_there
    return ReachTarget(tips=[PoseTarget(position_m=p, rotation=turned)], q_rad=q)


def elbow_bent(home: Vector) -> Vector:
    q = home.copy()
    q[6] += 0.3
    return q


def test_progress_is_the_share_of_the_way_in_joint_space(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    goal = elbow_bent(home)
    state, progress = controller.start(home), []
    for _ in range(110):
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, to(tip, goal))
        progress.append(output.progress)
    s = np.arange(1, 101) * PERIOD_S
    assert progress[:100] == pytest.approx(10 * s**3 - 15 * s**4 + 6 * s**5, abs=0.01)
    assert (np.diff(progress) >= -1e-3).all()
    assert progress[-1] == 1.0


def test_progress_begins_anew_with_the_next_goal_and_ends_where_the_plan_is_stopped(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    goal = elbow_bent(home)
    state, progress = controller.start(home), []
    for period in range(220):
        target = to(tip, goal) if period < 110 else to(tip, home) if period < 160 else None
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        progress.append(output.progress)
    assert progress[109] == 1.0
    assert progress[110] < 0.01
    assert progress[159] == pytest.approx(0.5, abs=0.03)
    assert progress[-1] == pytest.approx(0.5 + 0.5 * 0.4 * 1.875, abs=0.05)  # the way of the stop
    assert progress[-1] == progress[-2]


def test_arrival_is_told_at_the_tolerance_and_taken_back_only_well_outside(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    """Tolerance 3 mm: in below 3, out above 4.5."""
    told, state = [], controller.start(home)
    target = to(tip, home)
    J = tip.jacobian(home)
    for off_m in (0.005, 0.0035, 0.0028, 0.0035, 0.0043, 0.0047, 0.0043, 0.0029):
        beside = np.linalg.pinv(J[:3]) @ np.array([off_m, 0.0, 0.0])
        measured = Measurement(q_rad=home + beside, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        told.append(output.in_target)
    assert told == [False, False, True, True, True, False, False, True]


def test_moving_target_is_never_reached_until_it_stands(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    R, p = tip.pose(home)
    state, told = controller.start(home), []
    for period in range(100):
        t = min(period, 60) * PERIOD_S
        velocity = np.array([0.0, 0.0, 0.05]) if period < 60 else np.zeros(3)
        pose = PoseTarget(
            position_m=p + 0.05 * t * np.array([0.0, 0.0, 1.0]), rotation=R, velocity_m_s=velocity
        )
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(
            state, measured, ReachTarget(tips=[pose], q_rad=state.q_plan)
        )
        told.append(output.in_target)
    assert not any(told[:60])
    assert told[-1]


def settle(
    controller: CartesianController, home: Vector, targets: list[ReachTarget]
) -> list[CartesianOutput]:
    state, outputs = controller.start(home), []
    for target in targets:
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        outputs.append(output)
    return outputs


def test_arm_in_its_target_does_not_follow_a_target_that_trembles(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    rng = np.random.default_rng(2)
    steady = [to(tip, home)] * 5
    shaken = []
    for _ in range(100):
        shift = rng.uniform(-1.0, 1.0, 3) * 1e-4
        turn = matrix(rng.uniform(-1.0, 1.0, 3) * 5e-4)
        target = to(tip, home, shift, turn)
        q = home + rng.uniform(-1.0, 1.0, 10) * 2e-3
        shaken.append(ReachTarget(tips=target.tips, q_rad=q))
    outputs = settle(controller, home, steady + shaken)
    assert np.abs([output.dq_rad_s for output in outputs]).max() < 1e-9
    assert outputs[-1].in_target


def test_smallest_step_of_a_target_that_is_no_trembling_is_followed(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    step = np.array([0.0, 0.0, 4e-4])
    outputs = settle(controller, home, [to(tip, home)] * 5 + [to(tip, home, step)] * 120)
    end = tip.pose(outputs[-1].plan_q_rad)[1]
    assert end - tip.pose(home)[1] == pytest.approx(step, abs=2e-5)


def test_position_alone_may_be_asked_for(
    controller: CartesianController, tip: Tip, home: Vector
) -> None:
    goal = elbow_bent(home)
    pose = PoseTarget(position_m=tip.pose(goal)[1], rotation=None)
    outputs = settle(controller, home, [ReachTarget(tips=[pose], q_rad=goal)] * 120)
    assert outputs[-1].in_target
    assert np.isnan(outputs[-1].orientation_error_rad)
    assert outputs[-1].plan_q_rad == pytest.approx(goal, abs=1e-3)
    path = np.array([output.tips[0].plan_position_m for output in outputs])
    way, gone = path[-1] - path[0], path - path[0]
    share = gone @ way / (way @ way)
    across = np.linalg.norm(gone - np.outer(share, way), axis=1).max()
    assert across < 0.002 * np.linalg.norm(way)
