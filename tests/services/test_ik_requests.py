"""The IK service answers requests: poses, and everything that is no request."""

import math

import numpy as np
import pytest

from dforc import rotation
from services.config import load_robot
from services.core.testing import Bench
from services.reaching.limb import limb_limits, limb_model
from services.reaching.messages import (
    IkRequest,
    LimbSetup,
    PoseTarget,
    SetupInUse,
    TipOffset,
    TipPose,
)
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    IK_CALL,
    IK_SOLUTION,
    IK_STATUS,
    VIRTUAL_POINT,
)
from tests.services.asking import (
    ARM_ALONE,
    BENT,
    HERE,
    HOME_DEG,
    HOME_RAD,
    answer_to,
    ask,
    at,
    heartbeat,
    pose_of,
    standing,
)
from tests.services.postures import point


@pytest.fixture
def bench(robot: RobotFile) -> Bench:
    return standing(robot)


def test_a_reachable_pose_is_reached_within_all_limits(robot: RobotFile, bench: Bench) -> None:
    pose = pose_of(robot, BENT)
    reply = ask(bench, IkRequest(poses=(pose,)))
    assert reply.joints == robot.chain
    assert reply.start_rad == pytest.approx(HOME_RAD)
    (answer,) = reply.answers
    assert (answer.status, answer.reason) == ("converged", "")
    _, p = limb_model(robot).tip_pose(np.array(answer.q_rad))
    assert p == pytest.approx(limb_model(robot).tip_pose(np.radians(BENT))[1], abs=2e-4)
    assert answer.orientation_error_rad < math.radians(1.0)
    assert limb_limits(robot).violation(np.array(answer.q_rad)) <= 1e-9
    moved = np.abs(np.array(answer.q_rad) - HOME_RAD).max()
    assert answer.distance_rad == pytest.approx(moved)


@pytest.mark.parametrize("solver", ["sqp", "ipopt", "fatrop"])
def test_every_solver_gives_the_same_posture(robot: RobotFile, bench: Bench, solver: str) -> None:
    setup = LimbSetup(limb="", solver=solver)
    answer = answer_to(bench, IkRequest(poses=(pose_of(robot, BENT),), setup=setup))
    assert answer.status == "converged"
    plain = answer_to(bench, IkRequest(poses=(pose_of(robot, BENT),)))
    assert np.degrees(answer.q_rad) == pytest.approx(np.degrees(plain.q_rad), abs=0.5)


def test_the_pose_where_the_hand_is_already_is_converged(robot: RobotFile, bench: Bench) -> None:
    answer = answer_to(bench, IkRequest(poses=(pose_of(robot, HOME_DEG),)))
    assert answer.status == "converged"
    assert answer.position_error_m < 2e-4
    assert answer.orientation_error_rad < math.radians(1.0)


def test_half_a_turn_away_is_answered(robot: RobotFile, bench: Bench) -> None:
    turned, (x, y, z) = limb_model(robot).tip_pose(np.array(HOME_RAD))
    half = rotation.rotation_vector(turned @ rotation.matrix((0.0, math.pi, 0.0)))
    pose = PoseTarget(tips=(TipPose(position_m=(x, y, z), rotation_rad=tuple(half.tolist())),))
    answer = answer_to(bench, IkRequest(poses=(pose,)))
    assert answer.status == "converged"  # position is the condition
    assert answer.position_error_m < 2e-4
    assert "deg off" in answer.reason


def test_out_of_reach_gives_the_nearest_and_the_reason(robot: RobotFile, bench: Bench) -> None:
    answer = answer_to(bench, IkRequest(poses=(at(-1.5, 0.2, 0.3),)))
    assert answer.status == "infeasible"
    assert answer.reason.startswith("nearest position is")
    assert 0.5 < answer.position_error_m < 1.5
    assert limb_limits(robot).violation(np.array(answer.q_rad)) <= 1e-9


def test_all_joints_blocked_stays_where_it_is(robot: RobotFile, bench: Bench) -> None:
    setup = LimbSetup(limb="", free=(False,) * 10)
    there = IkRequest(poses=(pose_of(robot, HOME_DEG),), setup=setup)
    assert answer_to(bench, there).status == "converged"
    away = IkRequest(poses=(pose_of(robot, BENT),), setup=setup)
    answer = answer_to(bench, away)
    assert answer.status == "infeasible"
    assert answer.q_rad == pytest.approx(HOME_RAD, abs=1e-12)


def test_seven_joints_that_do_not_suffice_are_told_that_the_waist_would_help(
    robot: RobotFile, bench: Bench
) -> None:
    leaning = (25.0, 0.0, -20.0, -60.0, 40.0, 0.0, 30.0, 0.0, 0.0, 0.0)
    pose = pose_of(robot, leaning)
    answer = answer_to(bench, IkRequest(poses=(pose,), setup=LimbSetup(limb="", free=ARM_ALONE)))
    assert answer.status == "infeasible"
    assert answer.reason.endswith("; reachable with the waist")
    assert answer.q_rad[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert answer_to(bench, IkRequest(poses=(pose,))).status == "converged"


def test_an_orientation_that_only_the_waist_gives_is_told_too(
    robot: RobotFile, bench: Bench
) -> None:
    tilted = (0.0, 25.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 20.0)
    pose = pose_of(robot, tilted)
    answer = answer_to(bench, IkRequest(poses=(pose,), setup=LimbSetup(limb="", free=ARM_ALONE)))
    assert "deg off; reachable with the waist" in answer.reason


def test_what_no_joint_helps_is_said(bench: Bench) -> None:
    request = IkRequest(poses=(at(-1.5, 0.2, 0.3),), setup=LimbSetup(limb="", free=ARM_ALONE))
    assert answer_to(bench, request).reason.endswith("; not reachable with all joints either")
    silent = IkRequest(poses=request.poses, setup=request.setup, suggest=False)
    assert answer_to(bench, silent).reason.startswith("nearest position is")
    assert ";" not in answer_to(bench, silent).reason


def test_blocked_joints_that_are_no_waist_are_named(robot: RobotFile, bench: Bench) -> None:
    free = tuple(name.startswith(("r_shoulder", "r_wrist")) for name in robot.chain)
    straight = (0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 20.0, 0.0, 0.0, 0.0)
    answer = answer_to(
        bench, IkRequest(poses=(pose_of(robot, straight),), setup=LimbSetup(limb="", free=free))
    )
    helpers = "; reachable with torso_pitch, torso_roll, torso_yaw, r_elbow"
    assert answer.reason.endswith(helpers)


@pytest.mark.parametrize("scale", [1.0, 7.0, 0.001])
def test_an_axis_of_any_length_is_an_axis(robot: RobotFile, bench: Bench, scale: float) -> None:
    (tip,) = pose_of(robot, HOME_DEG).tips
    assert tip is not None
    assert tip.rotation_rad is not None
    angle = math.hypot(*tip.rotation_rad)
    axis = tuple(scale * part / angle for part in tip.rotation_rad)
    pose = PoseTarget(tips=(TipPose(position_m=tip.position_m, rotation_rad=(*axis, angle)),))
    answer = answer_to(bench, IkRequest(poses=(pose,)))
    assert (answer.status, answer.reason) == ("converged", "")


def test_a_zero_axis_turns_by_nothing(bench: Bench) -> None:
    for rotation_rad in ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)):
        pose = PoseTarget(tips=(TipPose(rotation_rad=rotation_rad),))
        assert ask(bench, IkRequest(poses=(pose,))).ok


def test_a_start_outside_the_limits_is_brought_inside(robot: RobotFile, bench: Bench) -> None:
    wild = (3.0, -3.0, 3.0, 1.0, -1.0, 0.5, 3.0, 2.0, 2.0, -2.0)
    reply = ask(bench, IkRequest(poses=(HERE,), start_rad=wild))
    assert reply.ok
    assert limb_limits(robot).violation(np.array(reply.start_rad)) <= 1e-9
    assert reply.answers[0].status == "converged"


def test_a_rest_posture_outside_the_limits_only_pulls(robot: RobotFile, bench: Bench) -> None:
    setup = LimbSetup(limb="", rest_rad=(5.0,) * 10)
    answer = answer_to(bench, IkRequest(poses=(HERE,), setup=setup))
    assert answer.status == "converged"
    assert limb_limits(robot).violation(np.array(answer.q_rad)) <= 1e-9


def test_a_deadline_is_kept_by_counting(robot: RobotFile, bench: Bench) -> None:
    request = IkRequest(poses=(pose_of(robot, BENT),), deadline_ms=0.02)  # two iterations
    answer = answer_to(bench, request)
    assert (answer.status, answer.iterations) == ("out_of_time", 2)
    assert answer.q_rad == pytest.approx(HOME_RAD)
    assert ask(bench, request).statistics.missed == 2


def test_a_warm_search_starts_from_the_answer_before(robot: RobotFile, bench: Bench) -> None:
    poses = (pose_of(robot, BENT),) * 2
    warm = ask(bench, IkRequest(poses=poses))
    assert warm.answers[1].distance_rad < math.radians(1.0)
    cold = ask(bench, IkRequest(poses=poses, warm=False))
    assert cold.answers[1] == cold.answers[0]


def test_orientation_first_where_the_setup_says_so(robot: RobotFile, bench: Bench) -> None:
    (tip,) = pose_of(robot, HOME_DEG).tips
    assert tip is not None
    far = PoseTarget(tips=(TipPose(position_m=(-1.5, 0.2, 0.3), rotation_rad=tip.rotation_rad),))
    setup = LimbSetup(limb="", priority="orientation")
    answer = answer_to(bench, IkRequest(poses=(far,), setup=setup))
    assert answer.status == "converged"
    assert answer.orientation_error_rad < 2e-3
    assert answer.position_error_m > 0.5


def test_a_tip_offset_is_what_is_placed(robot: RobotFile, bench: Bench) -> None:
    setup = LimbSetup(limb="", tip_offsets=(TipOffset(position_m=(0.05, 0.0, 0.0)),))
    answer = answer_to(bench, IkRequest(poses=(HERE,), setup=setup))
    R, p = limb_model(robot).tip_pose(np.array(answer.q_rad))
    assert p + 0.05 * R[:, 0] == pytest.approx((-0.3, 0.2, 0.05), abs=2e-4)


def test_without_a_setup_of_its_own_a_request_keeps_to_the_one_in_use(bench: Bench) -> None:
    in_use = LimbSetup(limb="", free=ARM_ALONE)
    bench.put(CARTESIAN_SETUP, SetupInUse(stamp_ns=0, setup=in_use))
    answer = answer_to(bench, IkRequest(poses=(HERE,)))
    assert answer.q_rad[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    free = answer_to(bench, IkRequest(poses=(HERE,), setup=LimbSetup(limb="")))
    assert max(abs(q) for q in free.q_rad[:3]) > 1e-4


def test_both_arms_are_asked_for_two_poses_at_once() -> None:
    arms = load_robot("icub:arms")
    bench = standing(arms)
    pair = PoseTarget(
        tips=(TipPose(position_m=(-0.3, -0.15, 0.1)), TipPose(position_m=(-0.32, 0.2, 0.05)))
    )
    alone = PoseTarget(tips=(None, TipPose(position_m=(-0.32, 0.2, 0.05))))
    reply = ask(bench, IkRequest(poses=(pair, alone), limb="both_arms"))
    assert len(reply.joints) == 17
    assert [answer.status for answer in reply.answers] == ["converged", "converged"]
    assert [error is None for error in reply.answers[0].tip_errors] == [False, False]
    assert [error is None for error in reply.answers[1].tip_errors] == [True, False]


def test_many_poses_wait_while_points_are_followed(robot: RobotFile, bench: Bench) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), 1))
    poses = tuple(at(-0.3, 0.2, 0.05 + 1e-5 * i) for i in range(300))
    bench.request(IK_CALL, IkRequest(poses=poses))
    for i in range(2, 400):
        bench.advance(0.01)
        bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0), i))
        if bench.replies(IK_CALL):
            break
    ((_, reply),) = bench.replies(IK_CALL)
    assert len(reply.answers) == 300
    assert reply.taken_ms == pytest.approx(10.0 * (i - 1))
    assert i > 15  # no step solved more than some twenty of them
    assert len(bench.sent(IK_SOLUTION)) == i
    waiting = [report.waiting for report in bench.sent(IK_STATUS)]
    assert waiting[1:] == sorted(waiting[1:], reverse=True)
    assert 0 < waiting[1] < 300


def test_poses_wait_for_the_heartbeat_while_nothing_is_followed(bench: Bench) -> None:
    bench.put(CARTESIAN_STATUS, heartbeat())
    poses = tuple(at(-0.3, 0.2, 0.05 + 1e-5 * i) for i in range(2000))
    bench.request(IK_CALL, IkRequest(poses=poses, warm=False))
    assert bench.replies(IK_CALL) == []
    for _ in range(100):
        bench.advance(0.02)
        bench.put(CARTESIAN_STATUS, heartbeat())
    ((_, reply),) = bench.replies(IK_CALL)
    assert len(reply.answers) == 2000


def test_requests_are_answered_in_the_order_of_their_arrival(bench: Bench) -> None:
    bench.put(CARTESIAN_STATUS, heartbeat())
    poses = tuple(at(-0.3, 0.2, 0.05 + 1e-5 * i) for i in range(2000))
    first = bench.request(IK_CALL, IkRequest(poses=poses, warm=False))
    second = bench.request(IK_CALL, IkRequest(poses=(HERE,)))
    for _ in range(100):
        bench.put(CARTESIAN_STATUS, heartbeat())
    assert [token for token, _ in bench.replies(IK_CALL)] == [first, second]


def test_poses_that_there_is_no_time_for_are_left_out(bench: Bench) -> None:
    bench.put(CARTESIAN_STATUS, heartbeat())
    poses = tuple(at(-0.3, 0.2, 0.05 + 1e-5 * i) for i in range(2000))
    bench.request(IK_CALL, IkRequest(poses=poses))
    bench.advance(9.1)
    bench.put(CARTESIAN_STATUS, heartbeat())
    ((_, reply),) = bench.replies(IK_CALL)
    assert not reply.ok
    assert 0 < len(reply.answers) < 2000
    assert reply.reason == f"time for {len(reply.answers)} of 2000 poses only"
    assert reply.taken_ms == pytest.approx(9100.0)
    assert ask(bench, IkRequest(poses=(HERE,), start_rad=HOME_RAD)).ok
