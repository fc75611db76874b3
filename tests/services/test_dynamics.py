"""The dynamics service: torques, gravity and status of every part, and when it keeps silent."""

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.messages import FtRequest
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_HEALTH,
    DYNAMICS_MODELS,
    DYNAMICS_STATUS,
    FT_CALL,
    IMPEDANCE_OFFSET,
    JOINT_STATE,
    TORQUE_ESTIMATE,
)
from tests.services.whole_body import OFFSET, Stand, torque_streams

RIGHT_ARM = TORQUE_ESTIMATE["right_arm"]


@pytest.fixture(scope="module")
def whole() -> RobotFile:
    return load_robot("icub")


@pytest.fixture
def arm(robot: RobotFile) -> Stand:
    """Torso and right arm, calibrated."""
    stand = Stand(robot)
    stand.calibrate()
    return stand


def test_is_silent_before_the_offset_is_known_and_says_why(robot: RobotFile) -> None:
    stand = Stand(robot)
    stand.run(300)
    assert stand.bench.sent(RIGHT_ARM) == []
    assert stand.bench.last(DYNAMICS_STATUS).state == "waiting"
    assert stand.health("r_arm_ft").flags == ("uncalibrated",)
    silent = dict(stand.bench.last(DYNAMICS_HEALTH).silent)
    assert "r_arm_ft cannot be used" in silent["right_arm"]
    assert "r_arm_ft cannot be used" in silent["torso"]


def test_torques_of_every_part_at_rest_are_what_holds_the_weight(whole: RobotFile) -> None:
    stand = Stand(whole)
    stand.calibrate()
    expected = stand.tau_nm()
    felt = [part for part in stand.body.parts if part.felt]
    assert [part.name for part in felt] == [
        "torso",
        "left_arm",
        "right_arm",
        "left_leg",
        "right_leg",
    ]
    for part in felt:
        estimate = stand.bench.last(part.torque)
        assert estimate.tau_nm == pytest.approx(expected[part.start : part.stop], abs=0.03)
        offset = stand.bench.last(part.offset)
        assert offset.tau_nm == pytest.approx(expected[part.start : part.stop], abs=1e-9)


def test_every_reading_gives_one_torque_with_the_reading_s_arrival(arm: Stand) -> None:
    before = len(arm.bench.sent(RIGHT_ARM))
    arm.run(100)
    sent = arm.bench.sent(RIGHT_ARM)[before:]
    assert [estimate.arrival_ns for estimate in sent] == [e.stamp_ns for e in sent]
    assert len(sent) == 100


def test_a_push_on_the_hand_is_in_torques_and_status(robot: RobotFile) -> None:
    stand = Stand(robot, pushed="r_hand_dh_frame")
    stand.calibrate()
    stand.push_n = np.array([0.0, -20.0, 5.0])
    stand.run(40)
    expected = stand.tau_nm()[3:]
    assert stand.bench.last(RIGHT_ARM).tau_nm == pytest.approx(expected, abs=0.03)
    status = stand.bench.last(DYNAMICS_STATUS)
    assert status.external_force_n == pytest.approx((0.0, -20.0, 5.0), abs=0.1)
    assert status.external_moment_nm == pytest.approx((0.0, 0.0, 0.0), abs=0.03)


def test_motion_at_even_speed_is_no_push(arm: Stand) -> None:
    arm.dq_rad_s = np.full(len(arm.q_rad), 0.5)
    arm.run(60)
    assert arm.bench.last(DYNAMICS_STATUS).external_force_n == pytest.approx((0, 0, 0), abs=0.15)


def test_status_has_the_offset_and_the_torques_of_the_chain(robot: RobotFile, arm: Stand) -> None:
    status = arm.bench.last(DYNAMICS_STATUS)
    assert status.state == "running"
    assert status.offset == pytest.approx(OFFSET, abs=0.01)
    assert len(status.tau_nm) == len(robot.chain)


def test_the_old_request_calibrates_and_names_an_unknown_sensor(robot: RobotFile) -> None:
    stand = Stand(robot)
    stand.run(20)
    stand.bench.request(FT_CALL, FtRequest(samples=50))
    stand.run(60)
    assert stand.bench.sent(RIGHT_ARM)
    stand.bench.request(FT_CALL, FtRequest(sensors=("l_arm_ft",)))
    _, reply = stand.bench.replies(FT_CALL)[-1]
    assert not reply.ok
    assert "l_arm_ft" in reply.reason
    assert "r_arm_ft" in reply.reason


def test_old_joint_states_stop_the_torques_and_say_whose(arm: Stand) -> None:
    arm.unheard = {"torso"}
    arm.run(60)
    before = len(arm.bench.sent(RIGHT_ARM))
    arm.run(10)
    assert len(arm.bench.sent(RIGHT_ARM)) == before
    assert arm.silent()["right_arm"] == "joints of torso are not heard or not calibrated"


def test_joints_of_the_wrong_number_or_absurd_ones_are_refused_and_counted(arm: Stand) -> None:
    good = arm.state("torso")
    arm.unheard = {"torso"}
    arm.others = {JOINT_STATE["torso"]: msgspec.structs.replace(good, q_rad=(0.0,))}
    arm.run(1)
    for angle in (np.nan, np.inf, 1e200):
        bad = msgspec.structs.replace(good, q_rad=(0.0, 0.0, angle))
        arm.others = {JOINT_STATE["torso"]: bad}
        arm.run(1)
    arm.run(60)
    assert arm.bench.last(DYNAMICS_STATUS).refused == 4
    assert "right_arm" in arm.silent()


def test_legs_do_not_care_about_the_arms(whole: RobotFile) -> None:
    stand = Stand(whole)
    stand.calibrate()
    stand.unheard = {"left_arm"}
    stand.run(60)
    before = len(stand.bench.sent(TORQUE_ESTIMATE["left_leg"]))
    stand.run(10)
    assert len(stand.bench.sent(TORQUE_ESTIMATE["left_leg"])) == before + 10
    assert sorted(stand.silent()) == ["left_arm", "torso"]


def test_whole_robot_is_told_piece_by_piece(whole: RobotFile) -> None:
    stand = Stand(whole)
    stand.calibrate()
    stand.run(200)
    models = stand.bench.last(DYNAMICS_MODELS)
    assert (models.assumption, models.source, models.mainstay) == ("default", "base", True)
    assert [(sub.unknowns, sub.rank) for sub in models.sub_models] == [(6, 6)] * 7
    assert max(sub.residual_n for sub in models.sub_models) < 1e-9
    assert models.mass_kg == pytest.approx(25.945, abs=0.001)
    weight_n = 9.81 * models.mass_kg
    assert models.base_wrench[:3] == pytest.approx((0.0, 0.0, weight_n), abs=0.2)
    x, y, _ = models.centre_of_mass_m
    assert models.base_wrench[3:5] == pytest.approx((y * weight_n, -x * weight_n), abs=0.1)


def test_parts_without_torque_sensors_are_not_written(whole: RobotFile) -> None:
    stand = Stand(whole)
    names = [stream.name.split("/")[0] for stream in torque_streams(stand.dynamics)]
    assert names == ["torso", "left_arm", "right_arm", "left_leg", "right_leg"]
    assert IMPEDANCE_OFFSET["head"] not in stand.dynamics.writes


def test_what_acceleration_adds_beyond_the_sensor_is_measured(robot: RobotFile) -> None:
    """The estimate takes accelerations as zero, yet the shoulder's torque has most of them."""
    stand = Stand(robot)
    stand.calibrate()
    middle = stand.q_rad
    ddq = np.zeros(len(middle))
    ddq[stand.body.joints.index("r_shoulder_pitch")] = 8.0
    stand.path = lambda _: (middle, np.zeros(len(middle)), ddq)  # the first instant of a swing
    stand.run(5)
    shoulder = stand.body.joints.index("r_shoulder_pitch")
    true = stand.tau_nm()[shoulder]
    at_rest = stand.model.gravity(middle)[shoulder]
    estimate = stand.bench.last(RIGHT_ARM).tau_nm[0]
    assert abs(true - at_rest) > 0.4
    assert abs(true - estimate) < 0.1 * abs(true - at_rest)
