"""A board that the stack does not emulate is plugged into its bus, pulled, and plugged back."""

import math
from collections.abc import Iterator

import pytest

from hal.wire.motor_periodic import POSITION
from services.config import load_robot
from tests.services.mixed import Mixed, without

PITCH, ROLL = "r_shoulder_pitch", "r_shoulder_roll"
TICK_RAD = math.radians(1 / 11.375)
SHOULDER = ("right_arm", 1)
BACK = ("restarted", "needs calibration")
PROTOCOLS = dict.fromkeys(("bll_dc", "dc4"), "protocol 1.6") | dict.fromkeys(
    ("strain", "imu", "mais", "mtb"), "protocol 1.0"
)


@pytest.fixture
def arm() -> Iterator[Mixed]:
    """A right arm whose shoulder board is on the bench, by one line of a site file."""
    mixed = Mixed(load_robot("icub:right_arm@bench"))
    mixed.open()
    yield mixed
    mixed.close()


@pytest.fixture
def plugged_arm(arm: Mixed) -> Mixed:
    """The same with the board plugged in and its joints calibrated."""
    arm.plug(*SHOULDER)
    arm.until(lambda: arm.report("r_shoulder").state in BACK, 3000)
    arm.ask("calibrate", (PITCH, ROLL))
    arm.tick(100)
    return arm


def test_the_stack_starts_without_the_board_and_says_so(arm: Mixed) -> None:
    report = arm.report("r_shoulder")
    assert (report.state, report.found_type) == ("missing", None)
    assert "does not answer the handshake" in report.reason
    assert arm.report("r_elbow").state == "needs calibration"
    refused = arm.hal.request("calibrate", (PITCH,))
    arm.until(lambda: refused.done, 5000)
    assert not refused.ok


def test_a_plugged_board_is_found_configured_and_idle(arm: Mixed) -> None:
    arm.plug(*SHOULDER)
    arm.until(lambda: arm.report("r_shoulder").state in BACK, 3000)
    arm.tick(100)
    report = arm.report("r_shoulder")
    assert (report.found_type, report.found_firmware) == (4, (0x02, 0x50))
    assert "configured again, its axes are idle" in arm.hal.status().faults[-1]
    assert arm.said == ["handshake accepted, protocol 1.6", "streams started"]
    joint = arm.hal.joint_index(PITCH)
    assert arm.hal.joints.control_mode[joint] == 0
    assert not arm.hal.joints.calibrated[joint]
    assert dict(arm.hal.status().calibration)[PITCH] == "pending"


def test_the_plant_follows_the_position_frames_of_the_plugged_board(plugged_arm: Mixed) -> None:
    arm = plugged_arm
    arm.ask("move", (PITCH,), q_rad=(-0.6,), duration_s=1.5)
    arm.tick(500)
    assert arm.hal_rad(PITCH) == pytest.approx(-0.6, abs=3 * TICK_RAD)
    assert arm.plant_rad(PITCH) == pytest.approx(arm.hal_rad(PITCH), abs=TICK_RAD)
    assert arm.plant_rad(ROLL) == pytest.approx(arm.hal_rad(ROLL), abs=TICK_RAD)
    assert f"{PITCH}: idle -> position" in arm.said


def test_a_pulled_board_is_reported_within_100_ms_and_its_joints_stay(plugged_arm: Mixed) -> None:
    arm = plugged_arm
    before_rad = arm.plant_rad(PITCH)
    arm.pull()
    silent_ms = arm.until(lambda: arm.report("r_shoulder").state == "silent", 500)
    assert silent_ms <= 100
    assert "board r_shoulder (bus 2, address 1) silent for 0." in arm.hal.status().faults[-1]
    assert arm.plant_rad(PITCH) == pytest.approx(before_rad, abs=TICK_RAD)


def test_streams_of_the_other_boards_go_on_while_one_is_pulled_and_plugged(
    plugged_arm: Mixed,
) -> None:
    arm = plugged_arm
    ear = arm.open_bus("vcan2")
    elbow, strain = POSITION.frame(2, 0, 0)[0], 0x3DB  # second frame of STRAIN 13
    heard = {elbow: 0, strain: 0}

    def listen(milliseconds: int) -> None:
        for _ in range(milliseconds):
            arm.tick()
            for can_id, _, _ in ear.receive_frames():
                if can_id in heard:
                    heard[can_id] += 1

    arm.pull()
    listen(500)
    arm.plug(*SHOULDER)
    listen(1500)
    ear.shutdown()
    assert heard[strain] == pytest.approx(2000, abs=2)
    assert heard[elbow] == pytest.approx(500, abs=2)


def test_a_board_plugged_back_needs_calibration_and_the_others_do_not(plugged_arm: Mixed) -> None:
    arm = plugged_arm
    arm.ask("calibrate", ("r_elbow",))
    arm.pull()
    arm.until(lambda: arm.report("r_shoulder").state == "silent", 200)
    arm.plug(*SHOULDER)
    arm.until(lambda: arm.report("r_shoulder").state in BACK, 3000)
    calibrated = dict(zip(arm.hal.joints.names, arm.hal.joints.calibrated, strict=True))
    assert (calibrated[PITCH], calibrated[ROLL], calibrated["r_elbow"]) == (False, False, True)
    arm.ask("calibrate", (PITCH, ROLL))
    assert arm.report("r_shoulder").state == "ok"


def test_a_board_with_another_firmware_is_named_and_its_successor_taken(arm: Mixed) -> None:
    arm.plug(*SHOULDER, firmware="2.57")
    arm.until(lambda: arm.report("r_shoulder").state == "wrong", 3000)
    assert "has firmware 2.57 build" in arm.report("r_shoulder").reason
    assert "the robot file says 2.50" in arm.report("r_shoulder").reason
    arm.pull()
    arm.plug(*SHOULDER)
    arm.until(lambda: arm.report("r_shoulder").state in BACK, 3000)


@pytest.mark.parametrize(
    ("reference", "board", "silent_ms"),
    [
        ("icub:right_arm", "r_forearm", 100),  # dc4
        ("icub:right_arm", "r_arm_strain", 100),
        ("icub:head", "neck", 100),  # bll_dc
        ("icub:head", "head_imu", 200),
        ("icub:right_hand", "r_mais", 200),
        ("icub:torso_skin", "torso_skin_1", 200),  # mtb
    ],
)
def test_every_type_of_board_can_be_plugged_and_pulled(
    reference: str, board: str, silent_ms: int
) -> None:
    robot = Mixed(without(reference, board))
    robot.open()
    assert robot.report(board).state == "missing"
    table = robot.file.boards[board]
    robot.plug(table.bus, table.address)
    robot.until(lambda: robot.report(board).state in ("ok", *BACK), 3000)
    assert robot.said == ["handshake accepted, " + PROTOCOLS[table.type], "streams started"]
    robot.tick(200)
    robot.pull()
    assert robot.until(lambda: robot.report(board).state == "silent", 500) <= silent_ms
    robot.close()


def test_a_plugged_force_torque_board_weighs_the_arm_beyond_it() -> None:
    arm = Mixed(without("icub:right_arm", "r_arm_strain"))
    arm.open()
    sensor = arm.hal.description.sensors[0].name
    assert arm.hal.take_samples(sensor) == []
    arm.plug("right_arm", 13)
    arm.until(lambda: arm.report("r_arm_strain").state == "ok", 3000)
    arm.hal.take_samples(sensor)
    arm.tick(100)
    samples = arm.hal.take_samples(sensor)
    assert len(samples) == pytest.approx(100, abs=2)
    weights_n = [math.hypot(*sample.force_n) for sample in samples]
    assert 10.0 < min(weights_n) <= max(weights_n) < 25.0  # 1.7 kg, and up to 2 N of offset
    assert max(weights_n) - min(weights_n) < 1.0
    arm.close()
