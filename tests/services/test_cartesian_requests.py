"""Requests to the Cartesian controller: what moves, what is told, and what is refused."""

import numpy as np
import pytest

from dforc import rotation
from services.config import load_robot
from services.reaching.cartesian_messages import TipVelocity
from services.reaching.limb import limb_joints
from services.reaching.messages import TipOffset, TipPose
from services.robotfile.robot_tables import RobotFile
from tests.services.cartesian_stand import Stand

UP_M = (-0.05, 0.0, 0.05)  # forward and up by 7 cm
TORSO = ("torso_yaw", "torso_roll", "torso_pitch")


@pytest.fixture
def stand(robot: RobotFile) -> Stand:
    return Stand(robot)


@pytest.fixture
def arms() -> Stand:
    return Stand(load_robot("icub:arms"))


def test_a_hand_goes_to_a_pose_and_tells_so(stand: Stand) -> None:
    before = stand.hands()[0]
    reply = stand.go(UP_M)
    assert reply.ok
    assert reply.motion is not None
    assert reply.motion.motion == 1
    ended = stand.wait(1)
    turned, place = stand.hands()[0]
    assert place - before[1] == pytest.approx(UP_M, abs=1e-4)
    assert turned == pytest.approx(before[0], abs=1e-3)
    assert (ended.outcome, ended.progress) == ("reached", 1.0)
    assert stand.kinds(1) == ["motion-onset", "motion-done"]


def test_a_motion_takes_the_time_that_is_asked_for(stand: Stand) -> None:
    stand.go(UP_M, duration_s=1.2)
    begun_s = stand.clock.now_ns() * 1e-9
    stand.wait(1)
    assert stand.clock.now_ns() * 1e-9 - begun_s == pytest.approx(1.2, abs=0.05)


def test_a_hand_goes_to_a_pose_with_twice_the_delay_between_processes(robot: RobotFile) -> None:
    stand = Stand(robot, hop_ticks=2)
    before = stand.hands()[0][1]
    assert stand.go(UP_M).ok
    assert stand.wait(1).outcome == "reached"
    assert stand.hands()[0][1] - before == pytest.approx(UP_M, abs=1e-4)


def test_a_position_leaves_the_orientation_free(stand: Stand) -> None:
    turned, place = stand.hands()[0]
    x, y, z = (place + np.array([-0.1, -0.1, 0.1])).tolist()
    assert stand.ask("go", poses=(TipPose(position_m=(x, y, z)),)).ok
    stand.wait(1)
    after = stand.hands()[0]
    assert after[1] == pytest.approx((x, y, z), abs=1e-3)
    assert np.abs(after[0] - turned).max() > 0.01


def test_both_hands_go_at_once_over_one_waist(arms: Stand) -> None:
    before = arms.hands("both_arms")
    offsets = ((-0.06, 0.0, 0.04), (-0.03, 0.02, 0.06))
    assert arms.go(offsets, "both_arms").ok
    assert arms.wait(1).outcome == "reached"
    for (_, place), (_, start), offset in zip(
        arms.hands("both_arms"), before, offsets, strict=True
    ):
        assert place - start == pytest.approx(offset, abs=1e-3)


def test_a_hand_that_is_free_is_not_asked_for(arms: Stand) -> None:
    left, _ = arms.poses(((-0.05, 0.0, 0.05), (0.0, 0.0, 0.0)), "both_arms")
    assert arms.ask("go", "both_arms", poses=(left, None)).ok
    assert arms.wait(1).outcome == "reached"


def test_a_pose_out_of_reach_is_refused_with_the_distance_and_nothing_moves(stand: Stand) -> None:
    reply = stand.go((-1.0, 0.0, 0.0))
    assert not reply.ok
    assert "out of reach" in reply.reason
    assert reply.answer is not None
    assert reply.answer.position_error_m > 0.5
    stand.run(0.5)
    assert stand.joints.commands == []
    assert stand.caller.events == []


def test_nearest_goes_as_near_as_can_be_and_arrives(stand: Stand) -> None:
    reply = stand.go((-1.0, 0.0, 0.0), nearest=True)
    assert reply.ok
    assert reply.answer is not None
    target = stand.hands()[0][1] + [-1.0, 0.0, 0.0]
    ended = stand.wait(1)
    assert ended.outcome == "reached"
    away_m = np.linalg.norm(stand.hands()[0][1] - target)
    assert away_m == pytest.approx(reply.answer.position_error_m, abs=2e-3)
    assert ended.out_of_reach.startswith("nearest position is ")


def test_a_motion_to_an_orientation_out_of_reach_says_how_far_it_stays_off(stand: Stand) -> None:
    pose = TipPose(position_m=(-0.3, 0.2, 0.1), rotation_rad=(0.0, 0.0, 3.1))
    reply = stand.ask("go", poses=(pose,))
    assert reply.ok
    assert reply.answer is not None
    off_deg = np.degrees(reply.answer.orientation_error_rad)
    ended = stand.wait(1)
    assert ended.outcome == "reached"
    assert ended.out_of_reach == f"orientation is {off_deg:.1f} deg off"
    asked, (turned, _) = rotation.matrix(np.array([0.0, 0.0, 3.1])), stand.hands()[0]
    assert np.degrees(rotation.angle_between(asked, turned)) == pytest.approx(off_deg, abs=1.5)
    assert off_deg > 5.0


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"poses": ()}, "0 poses for 1 tips"),
        ({"poses": (None,)}, "neither position nor orientation"),
        ({"poses": (TipPose(position_m=(np.nan, 0.0, 0.0)),)}, "no place to go to"),
        ({"poses": (TipPose(position_m=(1e9, 0.0, 0.0)),)}, "no place to go to"),
        ({"poses": (TipPose(rotation_rad=(np.inf, 0.0, 0.0)),)}, "not finite"),
        ({"poses": (TipPose(rotation_rad=(1.0, 0.0)),)}, "3 numbers"),
        ({"poses": (TipPose(position_m=(-0.3, 0.2, 0.1)),), "duration_s": 0.05}, "0.1 to 60 s"),
    ],
)
def test_what_is_no_pose_is_refused(stand: Stand, fields: dict[str, object], reason: str) -> None:
    reply = stand.ask("go", **fields)
    assert not reply.ok
    assert reason in reply.reason
    assert stand.joints.commands == []


def test_a_limb_that_is_none_is_refused_with_those_there_are(arms: Stand) -> None:
    reply = arms.ask("pose", "nose")
    assert not reply.ok
    assert "left_arm, right_arm, both_arms, auto" in reply.reason


def test_poses_are_told_of_every_hand_and_of_joints(arms: Stand) -> None:
    left, right = arms.hands("both_arms")
    reply = arms.ask("pose", "both_arms")
    assert reply.poses[0].position_m == pytest.approx(left[1])
    assert reply.poses[1].position_m == pytest.approx(right[1])
    assert reply.joints == limb_joints(arms.robot, "both_arms")
    waist = arms.ask("pose", axis="torso_yaw").poses[0]
    assert arms.ask("pose", axis="0").poses[0] != waist
    assert not arms.ask("pose", axis="10").ok


def test_the_pose_of_the_last_joint_and_of_the_hand_are_one_rigid_body(stand: Stand) -> None:
    last = limb_joints(stand.robot, "right_arm")[-1]

    def between() -> float:
        joint, hand = stand.ask("pose", axis=last).poses[0], stand.ask("pose").poses[0]
        assert joint.position_m is not None
        assert hand.position_m is not None
        return float(np.linalg.norm(np.array(joint.position_m) - hand.position_m))

    before = between()
    stand.go(UP_M)
    stand.wait(1)
    assert before > 0.01
    assert between() == pytest.approx(before, abs=1e-6)


def test_a_pose_that_is_not_known_is_refused_and_never_zero(stand: Stand) -> None:
    stand.joints.invalid.add("torso")
    stand.run(0.1)
    reply = stand.ask("pose")
    assert not reply.ok
    assert "ulna joints calibrate" in reply.reason
    assert reply.poses == ()
    assert not stand.ask("go", poses=(TipPose(position_m=(0.0, 0.0, 0.0)),)).ok
    assert not stand.ask("ask", poses=(TipPose(position_m=(-0.3, 0.2, 0.1)),)).ok


def test_nothing_is_desired_before_the_first_motion(arms: Stand) -> None:
    assert not arms.ask("desired").ok
    arms.go(UP_M)
    desired = arms.ask("desired")
    arms.wait(1)
    assert desired.poses[0].position_m == pytest.approx(arms.hands()[0][1], abs=1e-4)
    assert not arms.ask("desired", "left_arm").ok


def test_asking_for_a_pose_moves_nothing_and_starts_where_it_is_told(stand: Stand) -> None:
    target = stand.poses(UP_M)
    reply = stand.ask("ask", poses=target)
    assert reply.ok
    assert reply.answer is not None
    assert reply.answer.status == "converged"
    assert reply.poses[0].position_m == pytest.approx(target[0].position_m, abs=2e-3)
    other = stand.ask("ask", poses=target, start_rad=(0.1,) * 10)
    assert other.answer is not None
    assert other.answer.distance_rad != reply.answer.distance_rad
    assert not stand.ask("ask", poses=target, start_rad=(0.1,)).ok
    assert stand.joints.commands == []


def test_speeds_of_the_plan_are_told_in_motion_and_zero_at_rest(stand: Stand) -> None:
    assert stand.ask("plan").dq_rad_s == (0.0,) * 10
    stand.go(UP_M, duration_s=1.0)
    stand.run(0.5)
    speeds = stand.ask("plan")
    assert max(abs(dq) for dq in speeds.dq_rad_s) > 0.05
    # minimum jerk: 1.875 times the mean speed in the middle
    assert speeds.velocities[0].linear_m_s == pytest.approx(np.array(UP_M) * 1.875, abs=0.01)


def test_a_velocity_moves_the_hand_and_ends_by_itself(stand: Stand) -> None:
    start = stand.hands()[0][1]
    velocity = TipVelocity(linear_m_s=(0.0, 0.0, 0.05))
    assert stand.ask("velocity", velocities=(velocity,), duration_s=1.0).ok
    stand.run(0.9)
    assert stand.status.mode == "velocity"
    assert stand.ask("plan").velocities[0].linear_m_s == pytest.approx((0, 0, 0.05), abs=1e-3)
    stand.run(1.0)
    assert stand.status.mode == "idle"
    assert stand.hands()[0][1] - start == pytest.approx((0.0, 0.0, 0.05), abs=0.01)


def test_a_velocity_and_a_pose_exclude_each_other(stand: Stand) -> None:
    stand.set(trajectory_time_s=3.0)
    stand.go(UP_M)
    stand.ask("velocity", velocities=(TipVelocity(linear_m_s=(0.0, 0.0, 0.05)),))
    assert stand.wait(1).outcome == "replaced"
    stand.run(0.03)
    assert stand.status.mode == "velocity"
    assert stand.go((-0.02, 0.0, 0.0)).ok
    assert stand.wait(2).outcome == "reached"


@pytest.mark.parametrize(
    "fields",
    [
        {"velocities": ()},
        {"velocities": (TipVelocity(linear_m_s=(np.nan, 0.0, 0.0)),)},
        {"velocities": (TipVelocity(),), "duration_s": 11.0},
        {"velocities": (TipVelocity(),), "duration_s": -1.0},
    ],
)
def test_what_is_no_velocity_is_refused(stand: Stand, fields: dict[str, object]) -> None:
    assert not stand.ask("velocity", **fields).ok
    assert stand.joints.commands == []


def test_a_stop_brings_the_hand_to_rest_and_the_motion_to_its_end(stand: Stand) -> None:
    start = stand.hands()[0][1]
    stand.go(UP_M)
    stand.run(0.8)
    assert stand.ask("stop").ok
    ended = stand.wait(1)
    assert (ended.outcome, ended.reason) == ("stopped", "by request")
    stand.run(0.03)
    rest = stand.hands()[0][1]
    commands = len(stand.joints.commands)
    stand.run(0.5)
    assert len(stand.joints.commands) == commands
    assert 0.005 < np.linalg.norm(rest - start) < 0.06


def test_a_stop_of_a_slow_motion_is_no_jump_either(stand: Stand) -> None:
    stand.go(UP_M, duration_s=15.0)
    stand.run(7.0)
    stand.ask("stop")
    stand.wait(1)
    stand.run(0.03)
    speeds = [c.dq_rad_s for part, c in stand.joints.commands if part == "right_arm"]
    steps = np.abs(np.diff(np.array([*speeds, (0.0,) * 7]), axis=0)).max()
    assert steps < 0.1 * np.abs(np.array(speeds)).max()


def test_an_answer_older_than_a_stop_is_dropped(stand: Stand) -> None:
    first = stand.send("go", poses=stand.poses(UP_M))
    assert stand.ask("stop").ok
    assert stand.reply(first).reason == "a stop came before the motion began"
    stand.run(0.5)
    assert stand.joints.commands == []


def test_of_two_requests_at_once_the_newer_one_counts(stand: Stand) -> None:
    far, near = stand.poses(UP_M), stand.poses((-0.02, 0.0, 0.0))
    first = stand.send("go", poses=far)
    assert stand.ask("go", poses=near).ok
    assert not stand.reply(first).ok
    stand.wait(1)
    assert stand.hands()[0][1] == pytest.approx(near[0].position_m, abs=1e-3)


def test_a_new_target_in_motion_goes_on_without_a_step_in_speed(stand: Stand) -> None:
    stand.go(UP_M, duration_s=1.0)
    stand.run(0.5)
    target = stand.poses((0.0, 0.05, 0.05))
    stand.ask("go", poses=target, duration_s=1.0)
    assert stand.wait(1).outcome == "replaced"
    assert stand.wait(2).outcome == "reached"
    speeds = np.array(
        [command.dq_rad_s for part, command in stand.joints.commands if part == "right_arm"]
    )
    assert np.abs(np.diff(speeds, axis=0)).max() < 0.1 * np.abs(speeds).max()
    assert stand.hands()[0][1] == pytest.approx(target[0].position_m, abs=1e-3)


def test_a_motion_starts_where_the_set_points_are(stand: Stand) -> None:
    stand.go(UP_M)
    stand.wait(1)
    elbow = stand.joints.q_rad["r_elbow"]
    stand.joints.q_rad["r_elbow"] -= 0.01  # a spring gives way
    stand.joints.stuck.add("r_elbow")
    stand.run(0.1)
    count = len(stand.joints.commands)
    stand.go((0.0, 0.0, 0.0))
    stand.run(0.05)
    first = next(c for part, c in stand.joints.commands[count:] if part == "right_arm")
    assert first.q_rad[3] == pytest.approx(elbow, abs=1e-4)


def test_information_lists_limbs_joints_and_what_can_be_asked(arms: Stand) -> None:
    info = arms.ask("info").info
    assert info is not None
    assert [limb.name for limb in info.limbs] == ["left_arm", "right_arm", "both_arms"]
    both = info.limbs[2]
    assert both.tips == ("left_arm", "right_arm")
    assert len(both.joints) == 17
    assert ("r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw") in both.together
    assert {"go", "ask", "pose", "stop", "watch"} <= set(info.actions)
    assert not arms.ask("dance").ok


def test_a_tip_frame_goes_to_the_pose_in_the_place_of_the_hand(stand: Stand) -> None:
    hand_rotation, hand_m = stand.hands()[0]
    tool = TipOffset(position_m=(0.0, 0.0, 0.1))
    assert stand.set(tip_offsets=(tool,)).ok
    tip = stand.ask("pose").poses[0]
    assert tip.position_m == pytest.approx(hand_m + hand_rotation @ [0.0, 0.0, 0.1])
    x, y, z = hand_m.tolist()
    assert stand.ask("go", poses=(TipPose(position_m=(x, y, z), rotation_rad=tip.rotation_rad),)).ok
    stand.wait(1)
    turned, place = stand.hands()[0]
    assert place + turned @ [0.0, 0.0, 0.1] == pytest.approx(hand_m, abs=1e-3)
    assert stand.set(tip_offsets=(TipOffset(),)).ok
    assert stand.ask("pose").poses[0].position_m == pytest.approx(place)
    assert not stand.set(tip_offsets=(tool, tool)).ok
