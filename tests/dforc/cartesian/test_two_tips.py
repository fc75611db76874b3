"""Both hands over one waist."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams
from dforc.cartesian.state import CartesianOutput, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.errors import ShapeError
from dforc.ik.problem import Tip
from dforc.limits import JointLimits

PERIOD_S = 0.01
PARAMS = CartesianParams(trajectory_time_s=1.0, coupling=CouplingParams(speed_limit_rad_s=6.0))
STIFF = (False,) * 17
ARM = (-30.0, 35.0, 5.0, 45.0, 0.0, 0.0, 0.0)

Hands = tuple[tuple[Tip, Tip], JointLimits]


@pytest.fixture
def start() -> Vector:
    return np.radians((0.0, 0.0, 0.0, *ARM, *ARM))


@pytest.fixture
def goal(start: Vector) -> Vector:
    """The waist turns, the left arm goes up, the right one down."""
    change = np.zeros(17)
    change[2] = 0.2
    change[[3, 6, 7]] = -0.3, 0.2, 0.2
    change[[10, 13, 15]] = 0.2, -0.2, -0.1
    return start + change


def poses_of(hands: tuple[Tip, Tip], q: Vector) -> list[PoseTarget]:
    found = [hand.pose(q) for hand in hands]
    return [PoseTarget(position_m=p, rotation=R) for R, p in found]


def run(
    hands: Hands, q_start: Vector, target: ReachTarget, periods: int = 130
) -> list[CartesianOutput]:
    controller = CartesianController(hands[0], hands[1], PARAMS)
    state, outputs = controller.start(q_start), []
    for _ in range(periods):
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, target)
        outputs.append(output)
    return outputs


def off_the_line(path: Matrix, goal: Vector) -> float:
    way, gone = goal - path[0], path - path[0]
    share = gone @ way / (way @ way)
    return float(np.linalg.norm(gone - np.outer(share, way), axis=1).max() / np.linalg.norm(way))


def test_both_hands_go_straight_to_their_poses_and_arrive_together(
    both_hands: Hands, start: Vector, goal: Vector
) -> None:
    hands = both_hands[0]
    target = ReachTarget(tips=poses_of(hands, goal), q_rad=goal)
    outputs = run(both_hands, start, target)
    for i, hand in enumerate(hands):
        path = np.array([output.tips[i].plan_position_m for output in outputs])
        end = hand.pose(goal)[1]
        assert off_the_line(path, end) < 0.01
        share = (path - path[0]) @ (end - path[0]) / ((end - path[0]) @ (end - path[0]))
        assert share[50] == pytest.approx(0.5, abs=0.005)
        assert np.linalg.norm(path[-1] - end) < 1e-4
    assert outputs[-1].in_target
    assert outputs[-1].progress == 1.0
    assert outputs[-1].plan_q_rad == pytest.approx(goal, abs=5e-3)
    assert max(both_hands[1].violation(output.plan_q_rad) for output in outputs) <= 1e-9


def test_one_hand_goes_and_the_other_is_asked_to_stay(
    both_hands: Hands, start: Vector, goal: Vector
) -> None:
    hands = both_hands[0]
    left, right = hands
    moving, staying = poses_of(hands, goal)[0], poses_of(hands, start)[1]
    outputs = run(both_hands, start, ReachTarget(tips=[moving, staying], q_rad=goal))
    stayed = np.array([output.tips[1].plan_position_m for output in outputs])
    assert np.linalg.norm(stayed - right.pose(start)[1], axis=1).max() < 1e-3
    assert np.linalg.norm(outputs[-1].tips[0].plan_position_m - left.pose(goal)[1]) < 1e-3


def test_hand_without_a_target_follows_the_posture_alone(
    both_hands: Hands, start: Vector, goal: Vector
) -> None:
    hands = both_hands[0]
    target = ReachTarget(tips=[None, poses_of(hands, goal)[1]], q_rad=goal)
    outputs = run(both_hands, start, target, 200)
    assert np.isnan(outputs[-1].tips[0].position_error_m)
    assert outputs[-1].position_error_m == outputs[-1].tips[1].position_error_m
    assert outputs[-1].in_target
    assert outputs[-1].plan_q_rad == pytest.approx(goal, abs=2e-3)


def test_hand_that_joins_in_motion_causes_no_jolt(
    both_hands: Hands, start: Vector, goal: Vector
) -> None:
    hands, limits = both_hands
    both = ReachTarget(tips=poses_of(hands, goal), q_rad=goal)
    alone = ReachTarget(tips=[both.tips[0], None], q_rad=goal)
    controller = CartesianController(hands, limits, PARAMS)
    state, speeds = controller.start(start), []
    for period in range(160):
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, output = controller.step(state, measured, alone if period < 50 else both)
        speeds.append(output.dq_rad_s)
    steps = np.abs(np.diff(speeds, axis=0)).max(axis=1)
    assert steps[48:53].max() < 0.05 * np.abs(speeds).max()
    assert output.position_error_m < 1e-3


def test_target_for_one_tip_is_refused_by_two(both_hands: Hands, start: Vector) -> None:
    with pytest.raises(ShapeError):
        run(both_hands, start, ReachTarget(tips=poses_of(both_hands[0], start)[:1], q_rad=start), 1)
