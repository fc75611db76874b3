"""Requests to the dynamics service: each does what it says, to what it names and nothing else."""

import math

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    DYNAMICS_STATUS,
    TORQUE_ESTIMATE,
)
from services.wholebody.dynamics_messages import AssumedContact, DynamicsRequest, KnownLoad
from tests.services.whole_body import OFFSET, Stand

LEFT, RIGHT = TORQUE_ESTIMATE["left_arm"], TORQUE_ESTIMATE["right_arm"]
LEVEL_N = 0.02  # what a calibration from noise of 0.02 N in 100 samples stays inside of


@pytest.fixture(scope="module")
def arms() -> RobotFile:
    return load_robot("icub:arms")


@pytest.fixture
def stand(arms: RobotFile) -> Stand:
    stand = Stand(arms)
    stand.calibrate()
    return stand


def test_calibration_changes_only_the_sensors_that_are_named(stand: Stand) -> None:
    before = stand.dynamics.bank.channels[1].offset
    stand.offsets["l_arm_ft"] = stand.offsets["l_arm_ft"] + 0.5
    stand.offsets["r_arm_ft"] = stand.offsets["r_arm_ft"] + 0.5
    assert stand.ask("calibrate", "l_arm_ft").ok
    stand.run(150)
    after = stand.dynamics.bank.channels
    assert after[0].offset == pytest.approx(stand.offsets["l_arm_ft"], abs=LEVEL_N)
    assert (after[1].offset == before).all()


def test_calibration_while_the_arm_moves_slowly_finds_the_same_offset(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.run(20)
    stand.dq_rad_s = np.full(len(stand.q_rad), 0.3)
    assert stand.ask("calibrate", samples=500).ok
    stand.run(520)
    assert stand.dynamics.bank.channels[0].offset == pytest.approx(OFFSET, abs=LEVEL_N)


def test_calibration_waits_while_the_arm_moves_fast(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.run(20)
    stand.dq_rad_s = np.full(len(stand.q_rad), 0.6)
    assert stand.ask("calibrate").ok
    stand.run(200)
    assert stand.health("l_arm_ft").samples == 0
    stand.dq_rad_s = np.zeros(len(stand.q_rad))
    stand.run(200)
    assert stand.health("l_arm_ft").ok


def test_torques_go_on_during_a_calibration(stand: Stand) -> None:
    before = len(stand.bench.sent(LEFT))
    assert stand.ask("calibrate", samples=1000).ok
    stand.run(300)
    assert len(stand.bench.sent(LEFT)) == before + 300
    assert stand.bench.last(DYNAMICS_STATUS).state == "calibrating"
    health = stand.health("l_arm_ft")
    assert (health.task, health.wanted) == ("calibrating", 1000)
    assert 200 <= health.samples <= 300


def test_calibration_is_refused_in_contact_and_names_the_remedy(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="r_hand_dh_frame")
    stand.calibrate()
    stand.push_n = np.array([0.0, 10.0, 0.0])
    stand.run(200)
    before = stand.dynamics.bank.channels[1].offset
    reply = stand.ask("calibrate", "r_arm_ft")
    assert not reply.ok
    assert "r_arm_ft: something touches the limb" in reply.reason
    assert "reset" in reply.reason
    assert (stand.dynamics.bank.channels[1].offset == before).all()
    assert stand.ask("calibrate", "l_arm_ft").ok


def test_calibration_is_refused_in_contact_where_none_is_assumed(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="r_hand_dh_frame")
    stand.calibrate()
    left = DynamicsRequest(
        action="assume", value="custom", contacts=(AssumedContact(frame="l_hand"),)
    )
    assert stand.request(left).ok
    stand.push_n = np.array([0.0, 20.0, 0.0])
    stand.run(400)
    reply = stand.ask("calibrate", "r_arm_ft")
    assert not reply.ok
    assert "r_arm_ft: something touches the limb" in reply.reason


def test_calibration_is_given_up_when_a_touch_comes(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="r_hand_dh_frame")
    stand.calibrate()
    before = stand.dynamics.bank.channels[1].offset
    assert stand.ask("calibrate", "r_arm_ft", samples=1000).ok
    stand.push_n = np.array([0.0, 10.0, 0.0])
    stand.run(300)
    assert stand.health("r_arm_ft").task == ""
    assert "given up: something touches the limb" in stand.health("r_arm_ft").reason
    assert (stand.dynamics.bank.channels[1].offset == before).all()


def test_first_calibration_is_given_up_when_readings_differ_too_much(arms: RobotFile) -> None:
    stand = Stand(arms, pushed="r_hand_dh_frame")
    stand.run(20)
    assert stand.ask("calibrate", samples=200).ok
    stand.run(100)
    stand.push_n = np.array([0.0, 10.0, 0.0])
    stand.run(200)
    assert "given up: readings differ by" in stand.health("r_arm_ft").reason
    assert not stand.health("r_arm_ft").ok
    assert stand.health("l_arm_ft").ok


def test_calibration_is_refused_without_joints_or_readings(arms: RobotFile) -> None:
    stand = Stand(arms)
    stand.unheard = {"left_arm"}
    stand.faults = {"r_arm_ft": None}
    stand.run(20)
    for sensor, why in (("l_arm_ft", "joints of left_arm are not"), ("r_arm_ft", "(missing)")):
        reply = stand.ask("calibrate", sensor)
        assert not reply.ok
        assert sensor in reply.reason
        assert why in reply.reason


def test_calibration_is_given_up_when_the_sensor_falls_silent() -> None:
    """The only sensor: nothing but joint states starts a step then."""
    stand = Stand(load_robot("icub:right_arm"))
    stand.calibrate()
    before = stand.dynamics.bank.channels[0].offset
    stand.offsets["r_arm_ft"] = stand.offsets["r_arm_ft"] + 0.5
    assert stand.ask("calibrate", "r_arm_ft", samples=500).ok
    stand.run(50)
    stand.faults = {"r_arm_ft": None}
    stand.run(450)
    assert stand.health("r_arm_ft").task == "calibrating"
    stand.run(200)
    assert stand.health("r_arm_ft").task == ""
    assert stand.health("r_arm_ft").reason == (
        "calibration given up: no good readings for 0.5 s (missing)"
    )
    stand.faults = {}
    stand.run(600)
    assert (stand.dynamics.bank.channels[0].offset == before).all()


def test_calibration_is_given_up_when_the_arm_moves_fast_for_ten_seconds(
    arms: RobotFile,
) -> None:
    stand = Stand(arms)
    stand.run(20)
    stand.dq_rad_s = np.full(len(stand.q_rad), 0.5)
    assert stand.ask("calibrate", "r_arm_ft").ok
    stand.run(9_900)
    assert stand.health("r_arm_ft").task == "calibrating"
    stand.run(250)
    assert "given up: a joint moves at 0.50 rad/s" in stand.health("r_arm_ft").reason


@pytest.mark.parametrize("samples", [0, 1_000_000])
def test_a_calibration_of_absurd_length_is_refused(stand: Stand, samples: int) -> None:
    reply = stand.ask("calibrate", samples=samples)
    assert not reply.ok
    assert str(samples) in reply.reason


def test_reset_forgets_the_named_sensor_and_silences_its_limb(stand: Stand) -> None:
    assert stand.ask("reset", "r_arm_ft").ok
    before = len(stand.bench.sent(LEFT)), len(stand.bench.sent(RIGHT))
    stand.run(100)
    assert (len(stand.bench.sent(LEFT)), len(stand.bench.sent(RIGHT))) == (
        before[0] + 100,
        before[1],
    )
    assert stand.health("r_arm_ft").flags == ("uncalibrated",)
    assert stand.health("l_arm_ft").ok


@pytest.mark.parametrize(
    ("action", "value", "named"),
    [
        ("calibrate", "", "no sensor 'nose'"),
        ("reset", "", "no sensor 'nose'"),
        ("identify", "start", "no sensor 'nose'"),
    ],
)
def test_an_unknown_sensor_is_refused_with_the_known_ones(
    stand: Stand, action: str, value: str, named: str
) -> None:
    reply = stand.ask(action, "nose", value=value)
    assert not reply.ok
    assert named in reply.reason
    assert "l_arm_ft, r_arm_ft" in reply.reason


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (DynamicsRequest(action="dance"), "calibrate, reset, assume, source, identify"),
        (DynamicsRequest(action="assume", value="flying"), "default, standing, crawling, custom"),
        (DynamicsRequest(action="assume", value="crawling"), "needs an IMU"),
        (DynamicsRequest(action="source", value="moon"), "there are: base"),
        (DynamicsRequest(action="identify", value="now"), "start, solve, discard"),
        (DynamicsRequest(action="identify", value="solve"), "no sweep is under way"),
        (DynamicsRequest(action="assume", value="custom"), "custom needs a contact"),
        (
            DynamicsRequest(
                action="assume", value="custom", contacts=(AssumedContact(frame="tail"),)
            ),
            "no link or frame 'tail'",
        ),
        (
            DynamicsRequest(
                action="assume",
                value="default",
                known=(KnownLoad(frame="tail", wrench=(0.0,) * 6),),
            ),
            "no link or frame 'tail'",
        ),
        (
            DynamicsRequest(
                action="assume",
                value="default",
                known=(KnownLoad(frame="l_hand", wrench=(math.nan, *(0.0,) * 5)),),
            ),
            "known wrench at l_hand: expected 6 finite numbers",
        ),
        (
            DynamicsRequest(
                action="assume",
                value="custom",
                contacts=(AssumedContact(frame="l_hand", kind="kiss"),),
            ),
            "wrench",
        ),
        (
            DynamicsRequest(
                action="assume",
                value="custom",
                contacts=(AssumedContact(frame="l_hand", kind="direction"),),
            ),
            "direction",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_what_can(
    stand: Stand, request_: DynamicsRequest, reason: str
) -> None:
    reply = stand.request(request_)
    assert not reply.ok
    assert reason in reply.reason
    stand.run(10)
    assert stand.silent() == {}


def test_gains_of_the_robot_file_hold_from_the_start_and_after_a_reset(arms: RobotFile) -> None:
    gain = np.diag([0.6, 1.4, 1.1, 0.9, 1.2, 0.8])
    sensor = msgspec.structs.replace(arms.sensors["l_arm_ft"], gain=tuple(gain.ravel().tolist()))
    known = msgspec.structs.replace(arms, sensors={**arms.sensors, "l_arm_ft": sensor})
    stand = Stand(known)
    stand.gains = {"l_arm_ft": gain}
    stand.calibrate()
    assert stand.dynamics.bank.channels[0].offset == pytest.approx(OFFSET, abs=LEVEL_N)
    assert stand.ask("reset").ok
    stand.calibrate()
    stand.run(20)
    assert stand.health("l_arm_ft").gain == tuple(gain.ravel().tolist())
    assert stand.health("r_arm_ft").gain == ()
    part = next(part for part in stand.body.parts if part.name == "left_arm")
    estimate = stand.bench.last(LEFT).tau_nm
    assert estimate[:5] == pytest.approx(stand.tau_nm()[part.start : part.start + 5], abs=0.03)
