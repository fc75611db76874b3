"""Events of the Cartesian controller, and how motions end that do not arrive."""

import math

import pytest

from services.config import load_robot
from services.core.service import Outputs
from services.messages import CartesianStatus, VirtualPoint
from services.robotfile.robot_tables import RobotFile
from services.streams import VIRTUAL_POINT
from tests.services.cartesian_stand import FAULT, IDLE, Stand

UP_M = (-0.05, 0.0, 0.05)


@pytest.fixture
def stand(robot: RobotFile) -> Stand:
    return Stand(robot, writes=(VIRTUAL_POINT,))


@pytest.fixture
def arms() -> Stand:
    return Stand(load_robot("icub:arms"), writes=(VIRTUAL_POINT,))


def test_checkpoints_are_told_once_each_in_their_order(stand: Stand) -> None:
    for checkpoint in (0.75, 0.25, 0.0, 1.0):
        assert stand.ask("watch", checkpoint=checkpoint).ok
    stand.go(UP_M)
    stand.wait(1)
    passed = [e.checkpoint for e in stand.caller.events if e.kind == "motion-ongoing"]
    assert passed == [0.0, 0.25, 0.75, 1.0]
    assert stand.kinds(1)[0] == "motion-onset"
    assert stand.kinds(1)[-1] == "motion-done"


def test_a_checkpoint_is_told_where_the_joints_are_so_far(stand: Stand) -> None:
    stand.ask("watch", checkpoint=0.5)
    stand.go(UP_M, duration_s=1.0)
    start_s = stand.clock.now_ns() * 1e-9
    stand.wait(1)
    (half,) = [e for e in stand.caller.events if e.kind == "motion-ongoing"]
    # half of a minimum-jerk way is made at half its time
    assert half.stamp_ns * 1e-9 - start_s == pytest.approx(0.5, abs=0.05)
    assert half.motion.progress == pytest.approx(0.5, abs=0.03)


def test_what_nobody_watches_any_more_is_not_told(stand: Stand) -> None:
    for _ in range(2):
        stand.ask("watch", checkpoint=0.5)
    assert stand.ask("unwatch", checkpoint=0.5).ok
    stand.go(UP_M)
    stand.wait(1)
    assert stand.kinds(1).count("motion-ongoing") == 1
    assert stand.ask("unwatch", checkpoint=0.5).ok
    assert not stand.ask("unwatch", checkpoint=0.5).ok
    stand.go((0.05, 0.0, -0.05))
    stand.wait(2)
    assert stand.kinds(2) == ["motion-onset", "motion-done"]


@pytest.mark.parametrize("checkpoint", [-0.1, 1.1, math.nan])
def test_what_is_no_checkpoint_is_refused(stand: Stand, checkpoint: float) -> None:
    assert not stand.ask("watch", checkpoint=checkpoint).ok


def test_no_more_checkpoints_than_a_controller_can_bear(stand: Stand) -> None:
    replies = [stand.ask("watch", checkpoint=i / 100).ok for i in range(65)]
    assert replies == [True] * 64 + [False]


def test_a_motion_can_be_asked_after_while_it_lasts_and_when_it_is_over(stand: Stand) -> None:
    assert stand.ask("done").motion is not None
    stand.go(UP_M, duration_s=1.0)
    stand.run(0.5)
    under_way = stand.ask("done").motion
    assert under_way is not None
    assert not under_way.done
    assert 0.3 < under_way.progress < 0.7
    stand.wait(1)
    stand.go((0.0, 0.0, 0.01))
    stand.wait(2)
    first = stand.ask("done", motion=1).motion
    assert first is not None
    assert (first.done, first.outcome) == (True, "reached")
    assert not stand.ask("done", motion=99).ok


def test_the_end_of_the_controller_ends_the_motion_and_is_told(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.3)
    stand.executor.close()
    stand.run(0.003)
    kinds = [(event.kind, event.motion.outcome) for event in stand.caller.events]
    assert kinds == [("motion-onset", ""), ("motion-done", "closed"), ("closing", "closed")]


@pytest.mark.parametrize(("mode", "name"), [(IDLE, "idle"), (FAULT, "hardware fault")])
def test_a_joint_that_leaves_position_direct_mode_ends_the_motion_at_once(
    stand: Stand, mode: int, name: str
) -> None:
    stand.go(UP_M)
    stand.run(0.5)
    stand.joints.modes["r_elbow"] = mode
    ended = stand.wait(1, timeout_s=0.05)
    assert ended.outcome == "lost"
    assert f"r_elbow is in {name}" in ended.reason
    stand.run(0.03)
    count = len(stand.joints.commands)
    stand.run(0.5)
    assert len(stand.joints.commands) == count
    assert stand.status.mode == "idle"
    assert "r_elbow" in stand.status.reason
    refusal = stand.go(UP_M)
    assert not refusal.ok
    assert "r_elbow" in refusal.reason


def test_joints_that_are_heard_no_more_end_the_motion_within_half_a_second(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.5)
    stand.joints.silent.add("right_arm")
    ended = stand.wait(1, timeout_s=0.6)
    assert ended.outcome == "lost"
    assert "no joint states of right_arm" in ended.reason


def test_a_short_gap_in_the_joint_states_does_not_end_the_motion(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.5)
    stand.joints.silent.add("right_arm")
    stand.run(0.3)
    stand.joints.silent.clear()
    assert stand.wait(1).outcome == "reached"


def test_joints_that_are_not_valid_end_the_motion(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.5)
    stand.joints.invalid.add("torso")
    ended = stand.wait(1, timeout_s=0.6)
    assert "torso has joints that are not calibrated or not heard" in ended.reason


def test_a_hand_that_cannot_arrive_is_missed_and_nobody_waits_for_ever(stand: Stand) -> None:
    stand.joints.stuck.update(("r_elbow", "r_shoulder_pitch"))
    stand.go(UP_M, duration_s=1.0)
    ended = stand.wait(1, timeout_s=6.0)
    assert ended.outcome == "missed"
    assert "mm" in ended.reason
    assert ended.position_error_m > 0.01


def test_a_request_that_inverse_kinematics_does_not_answer_is_refused_in_time(
    stand: Stand,
) -> None:
    stand.set(solver="abacus")
    refusal = stand.go(UP_M)
    assert not refusal.ok
    assert "abacus" in refusal.reason


def stream_of_points(stand: Stand) -> None:
    """A point at the hand, every 10 ms from now on."""
    (pose,) = stand.poses((-0.03, 0.0, 0.0))
    assert pose.position_m is not None
    assert pose.rotation_rad is not None
    a, b, c = pose.rotation_rad
    position_m, count = pose.position_m, [0]

    def send(now_ns: int, outputs: Outputs) -> None:
        if now_ns % 10_000_000 == 0:
            count[0] += 1
            outputs.put(
                VIRTUAL_POINT,
                VirtualPoint(
                    stamp_ns=now_ns,
                    sequence=count[0],
                    position_m=position_m,
                    velocity_m_s=(0.0, 0.0, 0.0),
                    rotation_rad=(a, b, c),
                ),
            )

    stand.caller.stream = send


def mode_after(stand: Stand, seconds: float) -> str:
    stand.run(seconds)
    status: CartesianStatus = stand.status
    return status.mode


def test_a_request_takes_over_from_a_stream_until_the_stream_has_paused(stand: Stand) -> None:
    stream_of_points(stand)
    assert mode_after(stand, 0.5) == "field"
    assert stand.go(UP_M).ok
    assert mode_after(stand, 0.1) == "pose"
    assert stand.wait(1).outcome == "reached"
    assert mode_after(stand, 0.3) == "idle"  # the points go on, and are ignored
    assert stand.status.ignored > 200
    stand.caller.stream = None
    stand.run(0.15)
    stream_of_points(stand)
    assert mode_after(stand, 0.1) == "field"


def test_a_new_stream_takes_over_from_a_motion(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.5)
    stream_of_points(stand)
    assert stand.wait(1).outcome == "taken over"
    assert mode_after(stand, 0.05) == "field"


def test_a_refused_request_leaves_the_stream_alone(stand: Stand) -> None:
    stream_of_points(stand)
    stand.run(0.3)
    assert not stand.go((-1.0, 0.0, 0.0)).ok
    assert mode_after(stand, 0.1) == "field"


def test_a_stop_ends_the_following_of_a_stream(stand: Stand) -> None:
    stream_of_points(stand)
    stand.run(0.3)
    assert stand.ask("stop").ok
    assert mode_after(stand, 1.0) == "idle"


def test_a_stream_stops_the_other_limb_before_its_own_moves(arms: Stand) -> None:
    arms.go(UP_M, "left_arm")
    arms.run(0.8)
    stream_of_points(arms)  # of the main job's limb, the right arm
    assert arms.wait(1).outcome == "taken over"
    assert mode_after(arms, 0.3) == "field"
    assert arms.status.limb == "right_arm"
