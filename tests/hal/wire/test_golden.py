"""Frames of the worked examples, can-protocol 12, typed from the sheet: `ID [DLC] bytes` in hex."""

import pytest

from hal.wire import analog, management, motor, motor_periodic
from hal.wire.analog import FORCE, TORQUE, TxMode
from hal.wire.can import EVERYBODY, Frame
from hal.wire.management import BoardType
from hal.wire.message import AxisCommand, PeriodicMessage
from hal.wire.modes import CalibrationType, ControlMode, InteractionMode
from hal.wire.motor_periodic import AxisFault
from hal.wire.numbers import round_half_away


def frame(text: str) -> Frame:
    head, dlc, *digits = text.split()
    data = bytes.fromhex("".join(digits))
    assert dlc == f"[{len(data)}]", "the sheet's line was typed wrongly"
    return int(head, 16), data


def data(text: str) -> bytes:
    return frame(text)[1]


REQUESTS = [
    ("001 [3] 5B 01 06", motor.GET_FIRMWARE_VERSION, (1, 0, 1, 6)),
    ("001 [5] 49 37 00 00 00", motor.SET_BCAST_POLICY, (1, 0, 0x37)),
    (
        "001 [8] 04 03 55 09 0A 00 09 0C",
        motor.CALIBRATE_ENCODER,
        (1, 0, CalibrationType.DIGITAL_ABSOLUTE, 2389, 10, 3081),
    ),
    ("001 [3] 1E 00 7D", motor.SET_P_GAIN, (1, 0, 32000)),
    ("001 [8] 4E B4 FF 00 00 00 00 0E", motor.SET_TORQUE_PID, (1, 0, -76, 0, 0, 14)),
    ("001 [5] 40 C7 07 00 00", motor.SET_MIN_POSITION, (1, 0, 1991)),
    ("001 [5] 42 77 0C 00 00", motor.SET_MAX_POSITION, (1, 0, 3191)),
    ("001 [5] 48 58 1B 00 00", motor.SET_CURRENT_LIMIT, (1, 0, 7000)),
    ("001 [3] 4A 08 00", motor.SET_VEL_SHIFT, (1, 0, 8)),
    ("001 [3] 56 64 00", motor.SET_VEL_TIMEOUT, (1, 0, 100)),
    ("002 [2] 89 01", motor.SET_CONTROL_MODE, (2, 1, ControlMode.POSITION)),
    ("001 [7] 1B 38 08 00 00 0B 00", motor.POSITION_MOVE, (1, 0, 2104, 11)),
    ("002 [5] BE 60 05 00 00", motor.SET_COMMAND_POSITION, (2, 1, 1376)),
    ("006 [5] 1C 1D 00 01 00", motor.VELOCITY_MOVE, (6, 0, 29, 1)),
    ("002 [2] F4 01", motor.SET_INTERACTION_MODE, (2, 1, InteractionMode.COMPLIANT)),
    ("001 [8] 57 90 00 33 2A 00 00 00", motor.SET_IMPEDANCE_PARAMS, (1, 0, 144, 10803)),
    ("001 [5] 2C 00 10 00 00", motor.SET_DESIRED_TORQUE, (1, 0, 4096)),
    ("001 [2] 09 50", motor.SET_CONTROL_MODE, (1, 0, ControlMode.OPENLOOP)),
    ("001 [3] 72 50 00", motor.SET_OPENLOOP_PARAMS, (1, 0, 80)),
    ("001 [2] 09 09", motor.SET_CONTROL_MODE, (1, 0, ControlMode.FORCE_IDLE)),
]


@pytest.mark.parametrize(("text", "command", "arguments"), REQUESTS)
def test_motor_request_has_the_bytes_of_the_sheet(
    text: str, command: AxisCommand, arguments: tuple[int, ...]
) -> None:
    assert command.request(*arguments) == frame(text)


@pytest.mark.parametrize(("text", "command", "arguments"), REQUESTS)
def test_board_reads_the_request_of_the_sheet(
    text: str, command: AxisCommand, arguments: tuple[int, ...]
) -> None:
    _, axis, *values = arguments
    payload = data(text)
    assert motor.command_of(payload) is command
    assert motor.axis_of(payload) == axis
    assert command.parse_request(payload) == tuple(values)


def test_handshake_reply() -> None:
    text = "010 [8] 5B 04 02 50 57 01 06 01"
    values = (BoardType.BLL, 2, 0x50, 87, 1, 6, 1)
    assert motor.GET_FIRMWARE_VERSION.reply(1, 0, *values) == frame(text)
    assert motor.GET_FIRMWARE_VERSION.parse_reply(data(text)) == values


BROADCASTS = [
    (
        "123 [8] 00 00 00 01 00 00 00 00",
        motor_periodic.STATUS,
        (2, 0, ControlMode.IDLE, 0, ControlMode.POSITION, 0, 0, 0, 0),
    ),
    ("111 [8] 38 08 00 00 C6 0D 00 00", motor_periodic.POSITION, (1, 2104, 3526)),
    ("12C [1] 10", motor_periodic.ADDITIONAL_STATUS, (2, 0, 1)),
    (
        "113 [8] 04 00 04 00 00 00 00 00",
        motor_periodic.STATUS,
        (1, AxisFault.EXTERNAL, 0, AxisFault.EXTERNAL, 0, 0, 0, 0, 0),
    ),
    (
        "113 [8] 08 A0 00 00 00 00 00 00",
        motor_periodic.STATUS,
        (1, AxisFault.OVERCURRENT, ControlMode.HW_FAULT, 0, 0, 0, 0, 0, 0),
    ),
    ("114 [8] 5E 01 88 FF 00 00 00 00", motor_periodic.CURRENT, (1, 350, -120)),
    ("112 [8] 78 00 D3 FF 76 00 D4 FF", motor_periodic.PID_VAL, (1, 120, -45, 118, -44)),
    (
        "10F [8] FA 00 06 FF 00 00 00 00",
        motor_periodic.EMSTO2FOC_DESIRED_CURRENT,
        (0, 250, -250, 0, 0),
    ),
    ("110 [8] F4 01 0C 00 00 40 00 00", motor_periodic.FOC, (1, 500, 12, 16384)),
]


@pytest.mark.parametrize(("text", "message", "arguments"), BROADCASTS)
def test_broadcast_has_the_bytes_of_the_sheet(
    text: str, message: PeriodicMessage, arguments: tuple[int, ...]
) -> None:
    assert message.frame(*arguments) == frame(text)
    assert message.parse(data(text)) == arguments[1:]
    assert motor_periodic.MESSAGES[message.type] is message


def test_strain_full_scale_is_big_endian() -> None:
    assert analog.GET_FULL_SCALES.request(13, 0) == frame("20D [2] 18 00")
    assert analog.GET_FULL_SCALES.reply(13, 0, 1521) == frame("2D0 [4] 18 00 05 F1")
    assert analog.GET_FULL_SCALES.parse_reply(data("2D0 [4] 18 00 05 F1")) == (0, 1521)


def test_strain_start_and_acknowledgement() -> None:
    assert analog.SET_CANDATARATE.request(13, 1) == frame("20D [2] 08 01")
    assert analog.SET_TXMODE.request(13, TxMode.CALIBRATED) == frame("20D [2] 07 00")
    assert analog.ack(13) == frame("2D0 [0]")


def test_strain_serial_number() -> None:
    assert analog.GET_SERIAL_NO.request(14) == frame("20E [1] 1A")
    reply = analog.GET_SERIAL_NO.parse_reply(data("2E0 [8] 1A 53 4E 30 32 33 00 00"))
    assert reply is not None
    assert bytes(reply) == b"SN023\0\0"


def test_strain_version_reply() -> None:
    # Section 5.1: a present STRAIN answers 1C 06 03 00 05 01 00 ack.
    values = (BoardType.STRAIN, 3, 0, 5, 1, 0, 1)
    assert analog.GET_FW_VERSION.reply(13, *values) == frame("2D0 [8] 1C 06 03 00 05 01 00 01")


def test_strain_reset_cause() -> None:
    assert analog.reset_cause(13, 0, 0, 0, 1, 0, 0) == frame("2D0 [6] 00 00 00 01 00 00")
    assert analog.parse_reset_cause(data("2D0 [6] 00 00 00 01 00 00")) == (0, 0, 0, 1, 0, 0)


def test_strain_answers_bug() -> None:
    assert analog.unknown_command(13, 0x99) == frame("2D0 [4] 99 42 55 47")
    assert analog.is_unknown_command(data("2D0 [4] 99 42 55 47"))
    assert not analog.is_unknown_command(data("2D0 [4] 18 00 05 F1"))


def test_force_frame() -> None:
    full_scales_n = (1521.0, 1658.0, 1966.0)
    words = [analog.to_word(f, s) for f, s in zip((0.0, -10.0, 50.0), full_scales_n, strict=True)]
    assert FORCE.frame(13, *words) == frame("3DA [6] 00 80 3A 7F 41 83")
    parsed = FORCE.parse(data("3DA [6] 00 80 3A 7F 41 83"))
    assert parsed is not None
    forces_n = [analog.to_physical(w, s) for w, s in zip(parsed, full_scales_n, strict=False)]
    assert forces_n == pytest.approx([0.0, -10.0, 50.0], abs=0.06)
    assert parsed[3] == 0


def test_torque_frame() -> None:
    full_scales_nm = (34.0, 35.0, 22.0)
    words = [analog.to_word(t, s) for t, s in zip((1.0, -0.5, 0.2), full_scales_nm, strict=True)]
    assert TORQUE.frame(13, *words) == frame("3DB [6] C4 83 2C 7E 2A 81")
    parsed = TORQUE.parse(data("3DB [6] C4 83 2C 7E 2A 81"))
    assert parsed is not None
    torques_nm = [analog.to_physical(w, s) for w, s in zip(parsed, full_scales_nm, strict=False)]
    assert torques_nm == pytest.approx([1.0, -0.5, 0.2], abs=1.1e-3)


def test_saturated_force_frame() -> None:
    text = "3DA [7] 00 80 3A 7F 41 83 05"
    byte = analog.saturation_byte(analog.Saturation.LOW, 0, 0)
    assert FORCE.frame(13, 0x8000, 0x7F3A, 0x8341, byte) == frame(text)
    parsed = FORCE.parse(data(text))
    assert parsed == (0x8000, 0x7F3A, 0x8341, 5)
    assert analog.saturation_states(parsed[3]) == (analog.Saturation.LOW, 0, 0)


def test_virtual_torques_of_the_right_arm() -> None:
    first, second, clamped = analog.virtual_torque_frames(
        12, (4.0, -2.0, 0.0, 0.5, 0.0, 0.0), (8.0,) * 6
    )
    assert first == frame("3CA [6] FF BF 01 60 00 80")
    assert second == frame("3CB [6] FF 87 00 80 00 80")
    assert clamped == 0


def test_boards_see_the_virtual_torques_of_the_sheet() -> None:
    words = FORCE.parse(data("3CA [6] FF BF 01 60 00 80"))
    assert words is not None
    assert [word - analog.ZERO_WORD for word in words[:3]] == [16383, -8191, 0]
    words = TORQUE.parse(data("3CB [6] FF 87 00 80 00 80"))
    assert words is not None
    assert words[0] - analog.ZERO_WORD == 2047


def test_discovery() -> None:
    assert management.DISCOVER.request(EVERYBODY) == frame("70F [1] FF")
    strain = (BoardType.STRAIN, 2, 3, 6)
    assert management.DISCOVER.reply(14, *strain) == frame("7E0 [5] FF 06 02 03 06")
    assert management.DISCOVER.parse_reply(data("730 [5] FF 03 01 11 17")) == (
        BoardType.DC4,
        1,
        0x11,
        23,
    )


def test_label_piece_and_bootloader_jump() -> None:
    assert management.GET_ADDITIONAL_INFO.request(3) == frame("703 [1] 0C")
    assert management.GET_ADDITIONAL_INFO.reply(3, 7, *b"wxyz") == frame(
        "730 [6] 0C 07 77 78 79 7A"
    )
    assert management.BOARD.request(13, 0) == frame("70D [2] 00 00")
    assert management.BOARD.reply(13, 1) == frame("7D0 [2] 00 01")


def test_rounding_of_the_calibration_arguments() -> None:
    # Example 7: 2388.75 and 3081.4875.
    assert [round_half_away(value) for value in (2388.75, 3081.4875)] == [2389, 3081]
