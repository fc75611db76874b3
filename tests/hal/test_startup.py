"""Opening: what is sent, in which order and at which pace; boards that do not fit."""

from itertools import groupby

import pytest

from hal.errors import DescriptionError
from hal.robot import Robot
from hal.wire.motor import COMMANDS
from tests.hal.arm import BUS, DESCRIPTION
from tests.hal.scripted import Script, ScriptedBus, frame


@pytest.fixture
def script() -> Script:
    return Script()


def test_silences_every_board_before_anything_else(script: Script) -> None:
    sent = script.tick(20)

    assert sent == ["001 4900000000", "003 4900000000", "20D 0701"]
    assert script.robot.phase == "opening"


def test_throws_away_what_arrives_while_the_buses_are_drained(script: Script) -> None:
    script.tick(20)

    assert script.robot.joints.heard_ns == [0, 0, 0, 0]
    assert script.robot.status().frames_dropped == 0
    assert script.robot.status().frames_received > 20


def test_ends_idle_with_every_joint_heard(script: Script) -> None:
    script.open()

    status = script.robot.status()
    assert (status.phase, status.calibrated, status.faults) == ("idle", False, ())
    assert min(script.robot.joints.heard_ns) > 0


def test_sends_at_most_one_setting_or_four_questions_per_address_and_millisecond(
    script: Script,
) -> None:
    most = 0
    while script.robot.phase != "idle":
        for address, frames in groupby(sorted(script.tick()), key=lambda sent: sent[:3]):
            rows = [COMMANDS[int(sent[4:6], 16) & 0x7F] for sent in frames if address != "20D"]
            asks = all(row.reply_layout is not None for row in rows)
            most = max(most, len(rows))
            assert asks or len(rows) == 1

    assert most == 4


def test_configures_the_shoulder_pitch_in_the_order_of_the_icub_pc(script: Script) -> None:
    sent: list[str] = []
    while script.robot.phase != "idle":
        sent += [one for one in script.tick() if one.startswith("001")]

    assert sent[1] == "001 5B0106"
    assert sent[2:29] == [
        "001 7400",  # stiff
        "001 F400",
        "001 1E007D",  # kp 32000
        "001 203200",  # kd 50
        "001 223C00",  # ki 60
        "001 242003",  # ilim 800
        "001 260000",  # offset
        "001 280D00",  # shift 13
        "001 2A2003",  # tlim 800
        "001 5D03000000",  # position stiction
        "001 4EB4FF000000000E",  # torque PID, example 9
        "001 5000002003000000",  # torque limits: offset, PWM, integral
        "001 611C480700000000",  # bemf 18460, shift 7
        "001 6313000E00000000",  # kff 19, shift 14
        "001 5F00000000",  # torque stiction
        "001 7603",  # 3 Hz filter
        "001 340C000000000000",  # torque from address 12, channel 0
        "001 579000332A000000",  # impedance, example 20
        "001 409F030000",  # min 927
        "001 424F080000",  # max 2127
        "001 44AF00",  # 60 deg/s, stored
        "001 48581B0000",  # 7000 mA, example 11
        "001 4A0800",  # velocity shift, example 12
        "001 566400",  # velocity time-out
        "001 2F2003",  # PWM limit
        "001 0E05050505",  # speed estimator shifts
        "001 9E007D",  # the second axis follows
    ]
    assert "001 4977000000" in sent  # the mask, once both axes are configured
    assert sent[-4:] == ["001 0909", "001 8909", "001 38", "001 B8"]


def test_starts_the_sensor_after_reading_its_full_scales(script: Script) -> None:
    sent: list[str] = []
    while script.robot.phase != "idle":
        sent += [one for one in script.tick() if one.startswith("20D")]

    assert sent == [
        "20D 0701",
        "20D 1C0100",
        *(f"20D 180{channel}" for channel in range(6)),
        "20D 0801",
        "20D 0700",
    ]


def test_asks_again_when_an_answer_is_lost(script: Script) -> None:
    answer = script.bus.answers.pop(frame("001 5B0106"))
    script.tick(150)
    assert script.robot.phase == "handshake"
    script.bus.answers[frame("001 5B0106")] = answer

    script.open()

    assert script.robot.phase == "idle"


def test_names_a_board_that_does_not_answer(script: Script) -> None:
    del script.bus.answers[frame("003 5B0106")]

    script.open()

    assert script.robot.phase == "failed"
    assert script.robot.status().faults == (
        "board r_forearm (bus 1, address 3) does not answer the handshake",
    )


def test_waits_for_a_board_that_is_switched_on_after_the_host(script: Script) -> None:
    asked = frame("003 5B0106")
    answer = script.bus.answers.pop(asked)
    for _ in range(3000):
        script.tick()
    assert script.robot.phase == "handshake"
    script.bus.answers[asked] = answer

    script.open()

    assert script.robot.phase == "idle"
    assert script.robot.status().fault_count == 0


def test_names_every_board_that_does_not_answer(script: Script) -> None:
    del script.bus.answers[frame("003 5B0106")]
    del script.bus.answers[frame("20D 1C0100")]

    script.open()

    (fault,) = script.robot.status().faults
    assert "board r_forearm" in fault
    assert "board r_strain (bus 1, address 13) does not answer" in fault


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ("010 5B03025057010601", "is of type 3; the robot file says bll_ie (type 4)"),
        ("010 5B04025757010601", "has firmware 2.57 build 87; the robot file says 2.50"),
        ("010 5B04025057010500", "speaks protocol 1.5 and refused the host's 1.6"),
    ],
)
def test_names_a_board_that_is_not_the_expected_one(
    script: Script, answer: str, reason: str
) -> None:
    script.bus.answers[frame("001 5B0106")] = frame(answer)

    script.open()

    assert script.robot.status().faults == (f"board r_shoulder (bus 1, address 1) {reason}",)


def test_uses_the_full_scale_of_the_sensor_and_reports_the_difference(script: Script) -> None:
    script.bus.answers[frame("20D 1803")] = frame("2D0 18030044")  # 68 Nm instead of 34
    script.bus.wrench = [frame("3DA 008000800080"), frame("3DB 00C000800080")]

    script.open()
    script.tick()

    (fault,) = script.robot.status().faults
    assert "68 35 22; the robot file says 1521 1658 1966 34 35 22: the sensor's are used" in fault
    assert script.robot.take_samples("r_arm_ft")[-1].torque_nm == (34.0, 0.0, 0.0)


def test_fails_when_a_board_answers_but_sends_no_positions(script: Script) -> None:
    del script.bus.positions[0x111]

    script.open()

    (fault,) = script.robot.status().faults
    assert fault == "board r_shoulder (bus 1, address 1) answers but sends no POSITION"


def test_learns_what_the_boards_kept_from_a_previous_host(script: Script) -> None:
    script.bus.answers[frame("001 38")] = frame("010 38010000")

    script.open()

    assert script.robot.joints.calibrated == [True, False, False, False]


def test_refuses_requests_until_it_is_open(script: Script) -> None:
    script.tick()

    task = script.robot.request("calibrate")

    assert (task.done, task.ok) == (True, False)
    assert task.reason == "the robot is still in phase opening"


def test_refuses_requests_once_it_has_failed(script: Script) -> None:
    del script.bus.answers[frame("003 5B0106")]
    script.open()

    task = script.robot.request("calibrate")

    assert task.reason.startswith("the robot has failed: board r_forearm")


def test_refuses_a_description_whose_bus_is_not_open() -> None:
    with pytest.raises(DescriptionError, match="board r_shoulder: bus 1 is not open; open: 7"):
        Robot(DESCRIPTION, {7: ScriptedBus()})


def test_names_the_known_joints_when_asked_for_another() -> None:
    robot = Robot(DESCRIPTION, {BUS: ScriptedBus()})

    with pytest.raises(DescriptionError, match="unknown joint 'knee'; known: pitch, roll, prosup"):
        robot.joint_index("knee")


def test_writes_again_a_setting_that_the_board_has_not_kept(script: Script) -> None:
    answer = frame("010 1F0064")  # kp 25600
    script.bus.answers[frame("001 1F")] = answer
    sent: list[str] = []
    while script.robot.phase != "idle":
        sent += script.tick()
        if sent.count("001 1E007D") == 2:
            script.bus.answers[frame("001 1F")] = frame("010 1F007D")

    assert sent.count("001 1E007D") == 2
    assert script.robot.status().faults == ()


def test_names_a_setting_that_the_board_does_not_keep(script: Script) -> None:
    script.bus.answers[frame("001 1F")] = frame("010 1F0064")

    script.open()

    assert script.robot.status().faults == (
        "board r_shoulder (bus 1, address 1) does not keep its settings: "
        "pitch SET_P_GAIN: wrote 32000, read 25600",
    )
    assert script.robot.status().boards[0].state == "wrong"
