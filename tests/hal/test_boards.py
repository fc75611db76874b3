"""Motor boards' frames: readings in SI units, modes, faults in words, and bytes that do not fit."""

import math

import pytest

from hal.boards.status import SILENT_CAUSES
from tests.hal.arm import PITCH, PROSUP, ROLL, WRIST
from tests.hal.scripted import Script


@pytest.fixture
def script() -> Script:
    script = Script()
    script.ready()
    return script


def test_reads_positions_of_both_axes_of_an_address(script: Script) -> None:
    script.say("111 D107000098030000")  # 2001 and 920 ticks
    script.tick()

    q_rad = script.robot.joints.q_rad
    assert q_rad[PITCH] == pytest.approx(math.radians(2001 / 11.375 - 177.0))
    assert q_rad[ROLL] == pytest.approx(math.radians(920 / 11.375 - 37.0))


def test_reads_a_negative_factor_and_the_second_address_of_a_4dc(script: Script) -> None:
    script.bus.positions[0x131] = bytes.fromhex("0FF3FFFF00000000")  # -3313 ticks
    script.bus.positions[0x141] = bytes.fromhex("0008000000000000")  # 2048 ticks
    script.tick(8)

    q_rad = script.robot.joints.q_rad
    assert q_rad[PROSUP] == pytest.approx(math.radians(-3313 / -706.67 + 74.0))
    assert q_rad[WRIST] == pytest.approx(math.radians(2048 / -11.375 + 180.0))


def test_reads_speeds_of_a_bll_as_ticks_per_ms_times_32(script: Script) -> None:
    script.say("117 2000E0FF00000000")  # 32 and -32: one tick per ms
    script.tick()

    dq_rad_s = script.robot.joints.dq_rad_s
    assert dq_rad_s[PITCH] == pytest.approx(math.radians(1000 / 11.375))
    assert dq_rad_s[ROLL] == pytest.approx(-math.radians(1000 / 11.375))


def test_takes_the_speed_of_a_4dc_from_its_positions(script: Script) -> None:
    for ms in range(40):
        script.bus.positions[0x131] = (7 * ms).to_bytes(4, "little") + bytes(4)
        script.say("137 0700000000000000")  # unshifted, one sample of one millisecond: not used
        script.tick()

    assert script.robot.joints.dq_rad_s[PROSUP] == pytest.approx(
        math.radians(7000 / -706.67), rel=1e-6
    )


def test_reads_modes_from_status(script: Script) -> None:
    script.say("113 0000000100000000")  # idle, position
    script.tick()

    assert script.robot.joints.control_mode[:2] == [0, 1]


def test_reads_interaction_modes(script: Script) -> None:
    script.say("11C 10")  # axis 1 compliant
    script.tick()

    assert script.robot.joints.compliant == [False, True, False, False]
    assert script.robot.status().compliant == ("roll",)


def test_reports_a_hardware_fault_with_its_cause_and_the_last_frames(script: Script) -> None:
    script.say("113 08A0000100000000")
    script.tick()

    fault = script.robot.fault_events[-1]
    assert fault.text == "pitch in hardware fault: over-current or I2T trip"
    assert any("POSITION position0=2001 tick" in line for line in fault.frames)
    assert "STATUS fault0=OVERCURRENT, mode0=HW_FAULT" in fault.frames[-1]
    assert script.robot.joints.fault[PITCH] == "hardware fault: over-current or I2T trip"


def test_reports_a_hardware_fault_without_any_bit(script: Script) -> None:
    script.say("113 00A0000100000000")
    script.tick()

    assert "no fault bit: torque source or coupled board silent" in script.robot.status().faults[-1]


def test_reports_the_emergency_button_and_axes_that_went_idle_by_themselves(
    script: Script,
) -> None:
    task = script.robot.request("mode", ["pitch"], "direct")
    script.status(0x113, 0x08, 0x01)
    script.finish(task)
    for _ in range(20):
        script.say("113 0400040000000000")
        script.tick()

    assert script.robot.status().faults == (
        "board r_shoulder (bus 1, address 1): emergency button pressed",
        "pitch went idle by itself: emergency button pressed",
    )
    assert script.robot.joints.fault[PITCH] == "emergency button pressed"


def test_reports_can_and_board_trouble_once_a_second(script: Script) -> None:
    for _ in range(100):
        script.say("113 0001000160010000")
        script.tick()

    name = "board r_shoulder (bus 1, address 1)"
    assert script.robot.status().faults == (
        f"{name}: CAN receive warning, CAN receive overrun",
        f"{name}: control loop longer than 1 ms",
    )


def test_puts_printed_texts_together(script: Script) -> None:
    script.say("116 860063616C696220", "116 060163616C696220")
    script.say("116 0620666F6C6C6F77", "116 8621206D65")
    script.tick()

    assert script.robot.status().faults[-1] == (
        "board r_shoulder (bus 1, address 1) says: follow me"
    )


def test_drops_and_counts_frames_of_wrong_length(script: Script) -> None:
    before = list(script.robot.joints.q_rad)
    script.say("111 D107", "113 00", "117 00", "11C 0000", "010 1400")
    script.tick()

    assert script.robot.joints.q_rad == before
    assert dict(script.robot.status().drops) == {
        "POSITION of wrong length": 1,
        "STATUS of wrong length": 1,
        "VELOCITY of wrong length": 1,
        "ADDITIONAL_STATUS of wrong length": 1,
        "undecodable reply of a motor board": 1,
    }


def test_counts_identifiers_that_nobody_should_send(script: Script) -> None:
    script.say("191 0000000000000000")
    script.tick()

    assert script.robot.status().drops == (("unexpected identifier 0x191 on bus 1", 1),)


def test_counts_the_fortieth_and_every_further_identifier_together(script: Script) -> None:
    for can_id in range(0x600, 0x700):
        script.say(f"{can_id:03X} 00")
    script.tick()

    drops = dict(script.robot.status().drops)
    assert len(drops) == 41
    assert drops["unexpected identifiers on bus 1"] == 216
    assert script.robot.status().frames_dropped == 256
    script.say("111 00")
    script.tick()
    assert dict(script.robot.status().drops)["POSITION of wrong length"] == 1


def test_knows_when_a_joint_was_heard(script: Script) -> None:
    assert script.robot.is_fresh(PITCH, script.now_ns)
    assert not script.robot.is_fresh(PITCH, script.now_ns + 110_000_000)


def test_counts_replies_about_an_axis_that_the_robot_has_not(script: Script) -> None:
    script.say("040 8700")  # axis 1 of address 4
    script.tick()
    assert dict(script.robot.status().drops) == {"undecodable reply of a motor board": 1}
    script.say("040 870000")
    script.tick()

    assert dict(script.robot.status().drops) == {
        "undecodable reply of a motor board": 1,
        "reply about an axis that the robot does not use": 1,
    }


def test_keeps_the_cause_of_a_fault_that_its_bits_show_only_once(script: Script) -> None:
    script.say("113 08A0000100000000")  # example 31
    script.tick()
    script.say("113 00A0000800000000")  # the other axis changes its mode
    script.tick()
    assert script.robot.joints.fault[PITCH] == "hardware fault: over-current or I2T trip"

    script.say("113 0000000800000000")
    script.tick()
    assert script.robot.joints.fault[PITCH] == ""


def test_forgets_the_emergency_button_once_it_is_released(script: Script) -> None:
    script.say("113 04A0040000000000")
    script.tick()
    script.say("113 00A0000000000000")
    script.tick()

    assert not any("emergency" in text for text in script.robot.joints.fault)


@pytest.mark.parametrize(
    ("status", "cause"),
    [
        ("113 00A0000100040000", ""),  # over-temperature of the other axis
        ("113 00A0000100020000", "over-temperature axis 0"),
        ("113 00A000A002000000", "CAN bus-off"),
    ],
)
def test_finds_the_cause_of_a_fault_in_the_bytes_about_the_board(
    script: Script, status: str, cause: str
) -> None:
    script.say(status)
    script.tick()
    assert script.robot.joints.fault[PITCH] == f"hardware fault: {cause or SILENT_CAUSES}"
    script.say("113 00A0000100000000")  # heat and bus-off are told once, the fault stays
    script.tick()
    assert script.robot.joints.fault[PITCH] == f"hardware fault: {cause or SILENT_CAUSES}"
