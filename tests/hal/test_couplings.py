"""Axes that a board switches together, and boards that fault when another one is silent."""

import pytest
from msgspec.structs import replace

from hal.description import Board, RobotDescription
from tests.hal.arm import BUS, DESCRIPTION, PITCH, ROLL, joint
from tests.hal.scripted import Script, frame


def waist() -> RobotDescription:
    """The shoulder board as a waist: axes 0 and 1 do everything together."""
    boards = [replace(b, firmware=(2, 0x52)) if b.address == 1 else b for b in DESCRIPTION.boards]
    return replace(DESCRIPTION, boards=tuple(boards))


@pytest.fixture
def script() -> Script:
    script = Script(waist())
    script.bus.answers[frame("001 5B0106")] = frame("010 5B04025257010601")
    script.ready()
    return script


def test_says_that_an_axis_is_idle_because_its_partner_faulted(script: Script) -> None:
    task = script.robot.request("mode", ["pitch", "roll"], "direct")
    script.status(0x113, 0x08, 0x08)
    script.finish(task)
    script.status(0x113, 0x00, 0xA0, 0, 0x08)
    script.tick()

    assert script.robot.status().faults == (
        "roll: over-current or I2T trip",
        "roll in hardware fault: over-current or I2T trip; pitch coupled with it goes idle",
        "pitch is idle: its coupled partner roll faulted",
    )
    assert script.robot.joints.fault[PITCH] == "idle because its coupled partner roll faulted"


def test_forgets_the_partners_fault_with_it(script: Script) -> None:
    script.status(0x113, 0x00, 0xA0, 0, 0x08)
    script.tick()
    script.status(0x113, 0x00, 0x00)
    script.tick()

    assert script.robot.joints.fault[:2] == ["", ""]


def test_a_mode_that_takes_the_partner_along_is_no_fault(script: Script) -> None:
    script.robot.request("mode", ["roll"], "idle")
    script.tick()
    script.status(0x113, 0x00, 0x00)
    script.tick()

    assert script.robot.status().faults == ()


def test_calibrates_a_pair_together(script: Script) -> None:
    script.robot.joints.calibrated[PITCH] = False
    script.robot.joints.calibrated[ROLL] = False
    script.robot.request("calibrate", ["roll"])
    sent = script.tick(150)

    assert [one[:6] for one in sent if one[4:6] in ("04", "84")] == ["001 84", "001 04"]


def test_names_the_uncalibrated_partner_that_keeps_a_pair_off(script: Script) -> None:
    script.status(0x113, 0, 0)
    script.tick()
    script.robot.joints.calibrated[PITCH] = False
    task = script.robot.request("mode", ["roll"], "position")
    script.finish(task)

    assert task.reason == (
        "roll did not enter position mode: its coupled partner pitch is not calibrated"
    )


def test_names_the_coupled_board_whose_silence_made_an_axis_fault() -> None:
    elbow = Board(
        name="r_elbow", bus=BUS, address=2, type="bll_ie", firmware=(2, 0x57), broadcast=(0x77,)
    )
    script = Script(
        replace(
            DESCRIPTION,
            boards=(*DESCRIPTION.boards, elbow),
            joints=(*DESCRIPTION.joints, joint("yaw", 2, 0)),
        )
    )
    script.bus.answers[frame("002 5B0106")] = frame("020 5B04025757010601")
    script.bus.answers[frame("002 38")] = frame("020 38010000")
    script.bus.positions[0x121] = bytes(8)
    script.ready()
    del script.bus.positions[0x111]
    script.tick(95)
    script.status(0x123, 0xA0, 0x00)
    script.tick()

    assert "yaw in hardware fault: coupled board r_shoulder silent" in script.robot.status().faults


def hand() -> Script:
    boards = [replace(b, firmware=(2, 0x30)) if b.type == "dc4" else b for b in DESCRIPTION.boards]
    mais = Board(name="r_mais", bus=BUS, address=14, type="mais", firmware=(1, 0), broadcast=())
    script = Script(replace(DESCRIPTION, boards=(*boards, mais)))
    script.bus.answers[frame("003 5B0106")] = frame("030 5B03023057010601")
    script.bus.answers[frame("20E 1C0100")] = frame("2E0 1C07010005010001")
    script.bus.positions |= {0x3EC: bytes(7), 0x3ED: bytes(8)}
    return script


def test_a_silent_mais_is_reported_with_what_follows_and_what_to_check() -> None:
    script = hand()
    script.ready()
    del script.bus.positions[0x3EC], script.bus.positions[0x3ED]
    script.tick(105)
    script.status(0x133, 0xA0, 0x00)
    script.tick()

    faults = script.robot.status().faults
    assert faults[-2].startswith("board r_mais (bus 1, address 14) silent for 0.09")
    assert faults[-2].endswith("without it r_forearm fault, check the cable and power of the MAIS")
    assert faults[-1] == ("prosup in hardware fault: MAIS r_mais silent, check its cable and power")


def test_quotes_what_the_board_prints_when_it_refuses(script: Script) -> None:
    script.status(0x113, 0, 0)
    script.tick()
    task = script.robot.request("mode", ["roll"], "position")
    script.tick()
    script.status(0x113, 0, 0xA0)
    script.say("116 060063616C696220", "116 86016661696C6564")  # "calib " "failed"
    script.finish(task)

    assert task.reason.endswith('its board says "calib failed"')


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ("0101000000000000", "pitch: undervoltage"),
        ("0001020100000000", "roll: overvoltage or driver overload"),
        ("0801000100000000", "pitch: over-current or I2T trip"),
        ("1001000100000000", "pitch: Hall sensor error"),
        ("0001200100000000", "roll: absolute encoder read error"),
        ("4001000100000000", "pitch: Hall sensor error or optical encoder drift"),
        ("8001000100000000", "pitch: Hall sensor error"),
        ("0001000101000000", "CAN transmit buffer overrun"),
        ("0001000102000000", "CAN bus-off"),
        ("0001000104000000", "CAN transmit error-passive"),
        ("0001000108000000", "CAN receive error-passive"),
        ("0001000110000000", "CAN transmit warning"),
        ("0001000120000000", "CAN receive warning"),
        ("0001000140000000", "CAN receive overrun"),
        ("0001000100010000", "control loop longer than 1 ms"),
        ("0001000100020000", "over-temperature axis 0"),
        ("0001000100040000", "over-temperature axis 1"),
        ("0001000100080000", "temperature sensor 0 not readable"),
        ("0001000100100000", "temperature sensor 1 not readable"),
        ("0001000100000100", "CAN transmit errors since its last report"),
        ("0001000100000001", "CAN receive errors since its last report"),
    ],
)
def test_tells_every_bit_of_a_status(script: Script, data: str, text: str) -> None:
    script.say(f"113 {data}")
    script.tick()

    assert any(fault.endswith(text) for fault in script.robot.status().faults)


def test_names_the_torques_whose_absence_made_an_axis_fault(script: Script) -> None:
    script.say("11C 10")  # roll is compliant, and stays so
    script.tick(200)
    script.status(0x113, 0x01, 0xA0)
    script.tick()

    assert (
        "roll in hardware fault: no joint torques for too long" in script.robot.status().faults[-1]
    )
