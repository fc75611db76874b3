"""Settings and contexts of the Cartesian controller."""

import numpy as np
import pytest

from services.config import load_robot
from services.reaching.cartesian_messages import CartesianReply, CartesianSettings
from services.reaching.messages import TipPose
from services.robotfile.robot_tables import RobotFile
from tests.services.cartesian_stand import IDLE, Stand

UP_M = (-0.05, 0.0, 0.05)
NEAR_M = (0.02, 0.02, 0.02)  # within reach without the waist
TORSO_OFF = (("torso_pitch", False), ("torso_roll", False), ("torso_yaw", False))


@pytest.fixture
def stand(robot: RobotFile) -> Stand:
    return Stand(robot)


@pytest.fixture
def arms() -> Stand:
    return Stand(load_robot("icub:arms"))


def settings_of(reply: CartesianReply) -> CartesianSettings:
    assert reply.ok, reply.reason
    assert reply.settings is not None
    return reply.settings


def test_settings_begin_as_the_robot_file_has_them(stand: Stand) -> None:
    told = settings_of(stand.ask("get"))
    assert all(free for _, free in told.free)
    assert dict(told.rest_rad)["r_elbow"] == pytest.approx(np.radians(50.0))
    assert dict(told.rest_weights)["torso_yaw"] == 1.0
    assert told.trajectory_time_s == 2.0
    assert told.priority == "position"
    assert (told.tracking, told.reference_mode, told.law) == (False, False, "time_to_go")


def test_blocked_joints_are_not_commanded_and_do_not_move(stand: Stand) -> None:
    assert settings_of(stand.set(free=TORSO_OFF)).free[:3] == TORSO_OFF
    assert stand.go(NEAR_M).ok
    assert stand.wait(1).outcome == "reached"
    assert {part for part, _ in stand.joints.commands} == {"right_arm"}


def test_blocked_joints_may_be_in_any_mode(stand: Stand) -> None:
    stand.joints.modes["torso_yaw"] = IDLE
    stand.run(0.05)
    refusal = stand.go(UP_M)
    assert not refusal.ok
    assert "torso_yaw is in idle" in refusal.reason
    assert "ulna joints direct" in refusal.reason
    stand.set(free=TORSO_OFF)
    assert stand.go(NEAR_M).ok
    assert stand.wait(1).outcome == "reached"


def test_a_part_with_one_free_joint_is_commanded_by_that_joint_alone(stand: Stand) -> None:
    stand.set(free=TORSO_OFF[:2])
    stand.go(UP_M)
    stand.wait(1)
    torso = [command for part, command in stand.joints.commands if part == "torso"]
    assert torso
    assert {command.joints for command in torso} == {("torso_yaw",)}


def test_shoulder_joints_are_freed_and_blocked_together(stand: Stand) -> None:
    refusal = stand.set(free=(("r_shoulder_roll", False),))
    assert not refusal.ok
    assert "r_shoulder_pitch, r_shoulder_roll, r_shoulder_yaw" in refusal.reason
    shoulder = tuple((f"r_shoulder_{axis}", False) for axis in ("pitch", "roll", "yaw"))
    assert stand.set(free=shoulder).ok
    assert not stand.set(free=(("r_shoulder_yaw", True),)).ok


def test_a_limb_without_free_joints_does_not_move(stand: Stand) -> None:
    joints = stand.ask("get").joints
    assert stand.set(free=tuple((joint, False) for joint in joints)).ok
    refusal = stand.go(UP_M)
    assert not refusal.ok
    assert "all its joints are blocked" in refusal.reason


def test_limits_can_be_narrowed_but_never_widened(stand: Stand) -> None:
    first = {name: (low, high) for name, low, high in settings_of(stand.ask("get")).limits_rad}
    low, high = first["r_elbow"]
    assert not stand.set(limits_rad=(("r_elbow", low - 0.1, high),)).ok
    assert not stand.set(limits_rad=(("r_elbow", high, low),)).ok
    assert not stand.set(limits_rad=(("r_elbow", np.nan, high),)).ok
    assert stand.set(limits_rad=(("r_elbow", 0.7, 1.0),)).ok
    assert stand.set(limits_rad=(("r_elbow", 0.6, high),)).ok  # back within the robot's


def test_narrowed_limits_hold_on_the_way(stand: Stand) -> None:
    elbow = stand.joints.q_rad["r_elbow"]
    stand.set(limits_rad=(("r_elbow", elbow - 0.05, elbow + 0.05),))
    assert stand.go((-0.1, 0.0, 0.1), nearest=True).ok
    stand.wait(1)
    angles = [c.q_rad[3] for part, c in stand.joints.commands if part == "right_arm"]
    assert max(angles) <= elbow + 0.05 + 1e-6
    assert min(angles) >= elbow - 0.05 - 1e-6


def test_rest_weights_are_taken_as_they_are(stand: Stand) -> None:
    """A weight of 0.5 is half a weight, not none; 0 pulls nowhere, and to no angle of before."""
    told = settings_of(stand.set(rest_weights=(("r_elbow", 0.5), ("torso_yaw", 0.0))))
    assert dict(told.rest_weights)["r_elbow"] == 0.5
    assert not stand.set(rest_weights=(("r_elbow", -1.0),)).ok
    pose = stand.poses((-0.03, 0.0, 0.0))
    answers = [
        stand.ask("ask", poses=pose, start_rad=(yaw, *([0.0] * 9))).q_rad for yaw in (-0.2, 0.2)
    ]
    assert answers[0] == pytest.approx(answers[1], abs=0.02)  # no pull to where the search began


def test_the_rest_posture_draws_the_joints_that_the_pose_leaves_free(stand: Stand) -> None:
    place = stand.poses((-0.03, 0.0, 0.0))[0].position_m
    answers = []
    for yaw in (-0.3, 0.3):
        stand.set(rest_rad=(("torso_yaw", yaw),))
        answers.append(stand.ask("ask", poses=(TipPose(position_m=place),)).q_rad)
    assert answers[1][2] - answers[0][2] > 0.3


@pytest.mark.parametrize(
    "fields",
    [
        {"trajectory_time_s": 0.09},
        {"trajectory_time_s": float("nan")},
        {"in_target_m": 0.0},
        {"in_target_rad": 2.0},
        {"straightness": 0.0},
        {"law": "bang_bang"},
        {"priority": "speed"},
        {"position_tolerance_m": -1.0},
        {"free": (("nose", False),)},
        {"rest_rad": (("r_elbow", float("inf")),)},
    ],
)
def test_what_does_not_fit_is_refused_and_nothing_changes(
    stand: Stand, fields: dict[str, object]
) -> None:
    before = stand.ask("get").settings
    reply = stand.set(tracking=True, **fields)
    assert not reply.ok
    assert reply.reason
    assert stand.ask("get").settings == before


def test_what_tunes_inverse_kinematics_is_kept_and_told(stand: Stand) -> None:
    told = settings_of(
        stand.set(
            position_tolerance_m=0.002,
            orientation_tolerance_rad=0.01,
            rest_beta=0.05,
            iterations=200,
            solver="sqp",
        )
    )
    assert (told.position_tolerance_m, told.orientation_tolerance_rad) == (0.002, 0.01)
    assert (told.rest_beta, told.iterations, told.solver) == (0.05, 200, "sqp")
    assert stand.go(UP_M).ok
    assert settings_of(stand.set(rest_beta=-1.0)).rest_beta == 0.01  # the robot file's again


def test_the_priority_says_which_part_of_a_pose_out_of_reach_is_kept(stand: Stand) -> None:
    (here,) = stand.poses((0.0, 0.0, 0.0))
    turned = (TipPose(position_m=here.position_m, rotation_rad=(0.0, 0.0, 1.0)),)
    errors = {}
    for priority in ("position", "orientation"):
        stand.set(priority=priority)
        answer = stand.ask("ask", poses=turned).answer
        assert answer is not None
        errors[priority] = (answer.position_error_m, answer.orientation_error_rad)
    assert errors["position"][0] < 1e-3
    assert errors["orientation"][1] < errors["position"][1]
    assert errors["orientation"][0] > errors["position"][0]


def test_trajectory_time_of_a_tenth_of_a_second_is_the_shortest(stand: Stand) -> None:
    assert settings_of(stand.set(trajectory_time_s=0.1)).trajectory_time_s == 0.1


def test_changed_settings_are_told_to_inverse_kinematics(stand: Stand) -> None:
    stand.set(tracking=True)
    stand.set(free=TORSO_OFF)
    stand.run(0.02)
    assert [setup.setup.free[:4] for setup in stand.caller.setups] == [(False, False, False, True)]


def test_settings_that_change_in_motion_stop_it_and_say_so(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.8)
    stand.set(free=TORSO_OFF)
    ended = stand.wait(1)
    assert (ended.outcome, ended.reason) == ("stopped", "the settings of the limb have changed")
    for part in ("torso", "right_arm"):
        speeds = np.array(
            [c.dq_rad_s for p, c in stand.joints.commands if p == part and c.dq_rad_s]
        )
        assert np.abs(np.diff(speeds, axis=0)).max() < 0.1 * np.abs(speeds).max()


def test_times_and_tolerances_that_change_in_motion_do_not_stop_it(stand: Stand) -> None:
    stand.go(UP_M)
    stand.run(0.8)
    stand.set(trajectory_time_s=1.0, in_target_m=0.005)
    assert stand.wait(1).outcome == "reached"


def test_the_law_of_the_reference_controller_is_slower_and_bends(stand: Stand) -> None:
    def way(law: str) -> tuple[float, float]:
        stand.set(law=law, trajectory_time_s=1.0)
        reply = stand.go((-0.08, 0.0, 0.08))
        assert reply.motion is not None
        begun_ns, places = stand.clock.now_ns(), []
        while stand.ended(reply.motion.motion) is None:
            stand.run(0.02)
            places.append(stand.hands()[0][1])
        line = np.array(places) - places[0]
        ahead = line[-1] / np.linalg.norm(line[-1])
        aside = np.linalg.norm(line - np.outer(line @ ahead, ahead), axis=1).max()
        took_s = (stand.clock.now_ns() - begun_ns) * 1e-9
        back = stand.go((0.08, 0.0, -0.08))
        assert back.motion is not None
        stand.wait(back.motion.motion)
        return took_s, float(aside)

    exact, reference = way("time_to_go"), way("reference")
    assert exact[0] < reference[0]
    assert exact[1] < 0.002 < reference[1]


def test_tracking_keeps_the_pose_when_a_blocked_joint_is_moved(stand: Stand) -> None:
    stand.set(free=TORSO_OFF, tracking=True)
    target = stand.poses(NEAR_M)
    assert stand.ask("go", poses=target).ok
    stand.wait(1)
    stand.run(0.03)
    assert stand.status.mode == "tracking"
    for _ in range(50):
        stand.joints.q_rad["torso_yaw"] += 0.001
        stand.run(0.02)
    stand.run(1.0)
    assert stand.hands()[0][1] == pytest.approx(target[0].position_m, abs=2e-3)
    assert stand.ask("stop").ok
    stand.run(1.0)
    assert stand.status.mode == "idle"


def test_what_the_blocked_waist_cannot_reach_is_refused_with_the_advice_to_free_it(
    stand: Stand,
) -> None:
    stand.set(free=TORSO_OFF)
    refusal = stand.go(UP_M)
    assert not refusal.ok
    assert "reachable with the waist" in refusal.reason


def test_joints_that_tremble_do_not_make_set_points_tremble(stand: Stand) -> None:
    stand.set(tracking=True)
    stand.go(UP_M)
    stand.wait(1)
    stand.run(0.1)
    count = len(stand.joints.commands)
    for sign in (1, -1) * 50:
        stand.joints.q_rad["r_elbow"] += sign * 0.002
        stand.run(0.01)
    angles = [c.q_rad for part, c in stand.joints.commands[count:] if part == "right_arm"]
    assert len(angles) > 90
    assert np.ptp(np.array(angles), axis=0).max() < 1e-4  # the elbow: by 2e-3


def test_without_tracking_nothing_is_commanded_after_the_motion(stand: Stand) -> None:
    stand.go(UP_M)
    stand.wait(1)
    stand.run(0.05)
    count = len(stand.joints.commands)
    stand.run(1.0)
    assert len(stand.joints.commands) == count
    assert stand.status.mode == "idle"


def test_in_reference_mode_the_pose_is_that_of_the_set_points(stand: Stand) -> None:
    stand.go(UP_M)
    stand.wait(1)
    reached = stand.hands()[0][1]
    stand.joints.q_rad["r_elbow"] -= 0.02  # gives way under a load
    stand.run(0.05)
    measured = stand.ask("pose").poses[0].position_m
    stand.set(reference_mode=True)
    assert stand.ask("pose").poses[0].position_m == pytest.approx(reached, abs=1e-4)
    assert measured == pytest.approx(stand.hands()[0][1])


def test_contexts_keep_settings_and_give_them_back(stand: Stand) -> None:
    stand.set(free=TORSO_OFF, trajectory_time_s=0.7)
    number = stand.ask("store").context
    assert number == 1
    stand.ask("restore", context=0)
    assert settings_of(stand.ask("get")).trajectory_time_s == 2.0
    assert stand.ask("restore", context=number).ok
    told = settings_of(stand.ask("get"))
    assert told.free[:3] == TORSO_OFF
    assert told.trajectory_time_s == 0.7
    assert stand.ask("delete", context=number).ok
    assert not stand.ask("restore", context=number).ok
    assert not stand.ask("delete", context=0).ok
    assert stand.ask("store").context == 2  # numbers never come again


def test_a_context_of_one_limb_is_not_that_of_another(arms: Stand) -> None:
    arms.set(trajectory_time_s=0.7)
    number = arms.ask("store").context
    assert not arms.ask("restore", "left_arm", context=number).ok
    assert arms.set("left_arm", trajectory_time_s=0.9).ok
    assert settings_of(arms.ask("get")).trajectory_time_s == 0.7


def test_settings_of_auto_are_those_of_every_arm(arms: Stand) -> None:
    assert arms.set("auto", trajectory_time_s=0.9).ok
    for limb in ("left_arm", "right_arm"):
        assert settings_of(arms.ask("get", limb)).trajectory_time_s == 0.9
    assert settings_of(arms.ask("get", "both_arms")).trajectory_time_s == 2.0
    assert not arms.set("auto", free=(("r_elbow", False),)).ok


def test_a_hundred_contexts_are_enough(stand: Stand) -> None:
    replies = [stand.ask("store").ok for _ in range(101)]
    assert replies == [True] * 100 + [False]
