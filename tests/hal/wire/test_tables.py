"""The rows against the lengths and bits of can-protocol 2.2 and 3, typed by hand."""

from types import ModuleType

import pytest

from hal.wire import analog, analog_setup, management, motor, motor_periodic
from hal.wire.layout import NibblePair, WireError
from hal.wire.message import PeriodicMessage, PolledMessage
from hal.wire.modes import ControlMode, reported_mode

# code: DLC of the request and of the reply (0 = no reply)
MOTOR_DLC = {
    **{0: (1, 0), 3: (1, 0), 4: (8, 0), 7: (1, 3), 8: (1, 3), 9: (2, 0), 10: (1, 0), 11: (1, 0)},
    **{12: (1, 6), 13: (6, 0), 14: (5, 0), 15: (5, 0), 16: (5, 0), 18: (4, 0), 19: (2, 3)},
    **{20: (1, 7), 21: (5, 0), 22: (1, 5), 23: (3, 0), 24: (1, 3), 25: (3, 0), 26: (1, 3)},
    **{27: (7, 0), 28: (5, 0), 29: (5, 0)},
    **dict.fromkeys((30, 32, 34, 36, 38, 40, 42), (3, 0)),
    **dict.fromkeys((31, 33, 35, 37, 39, 41, 43), (1, 3)),
    **{44: (5, 0), 45: (1, 5), 46: (1, 0), 47: (3, 0), 48: (1, 3), 50: (2, 0), 51: (1, 2)},
    **{52: (8, 0), 55: (1, 3), 56: (1, 4), 57: (1, 5), 58: (1, 3), 60: (1, 3), 61: (1, 3)},
    **{62: (5, 0), 63: (1, 3), 64: (5, 0), 65: (1, 5), 66: (5, 0), 67: (1, 5), 68: (3, 0)},
    **{69: (1, 3), 72: (5, 0), 73: (5, 0), 74: (3, 0), 75: (5, 0), 76: (1, 5)},
    **dict.fromkeys((78, 80, 82, 84), (8, 0)),
    **dict.fromkeys((79, 81, 83, 85), (1, 8)),
    **{86: (3, 0), 87: (8, 0), 88: (1, 8), 89: (3, 0), 90: (1, 3), 91: (3, 8), 92: (3, 0)},
    **{93: (5, 0), 94: (1, 5), 95: (5, 0), 96: (1, 5), 97: (8, 0), 98: (1, 8), 99: (8, 0)},
    **{100: (1, 8), 114: (3, 0), 115: (1, 3), 116: (2, 0), 117: (1, 3), 118: (2, 0), 120: (1, 2)},
}
ANY_LENGTH_SETS = {"CALIBRATE_ENCODER", "SET_INTERACTION_MODE", "SET_DEBUG_PARAM"} | {
    "SET_SPEED_ESTIM_SHIFT",
    "STOP_TRAJECTORY",
}


def _rows(module: ModuleType) -> dict[str, PolledMessage | PeriodicMessage]:
    return {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, PolledMessage | PeriodicMessage)
    }


def _codes(module: ModuleType) -> dict[str, int]:
    rows = _rows(module)
    return {name: row.code for name, row in rows.items() if isinstance(row, PolledMessage)}


def test_motor_lengths_are_those_of_the_sheet() -> None:
    lengths = {
        code: (
            command.request_layout.dlc,
            0 if command.reply_layout is None else command.reply_layout.dlc,
        )
        for code, command in motor.COMMANDS.items()
    }
    assert lengths == MOTOR_DLC


@pytest.mark.parametrize("module", [motor, motor_periodic, analog, analog_setup])
def test_constant_has_the_name_of_its_row(module: ModuleType) -> None:
    assert {name: row.name for name, row in _rows(module).items()} == {
        name: name for name in _rows(module)
    }


def test_every_command_constant_is_in_the_table_under_its_own_code() -> None:
    assert _codes(motor) == {row.name: code for code, row in motor.COMMANDS.items()}
    sensors = _codes(analog) | _codes(analog_setup)
    assert sensors == {row.name: code for code, row in analog.COMMANDS.items()}


def test_mask_bit_is_type_minus_one_up_to_motor_speed() -> None:
    for kind, message in motor_periodic.MESSAGES.items():
        assert message.mask_bit == (1 << kind - 1 if 1 <= kind <= 11 else 0), message.name


def test_masks_used_on_robots() -> None:
    streams = motor_periodic.POSITION.mask_bit | motor_periodic.STATUS.mask_bit
    events = motor_periodic.OVERFLOW.mask_bit | motor_periodic.PRINT.mask_bit
    assert streams | events == 0x35
    assert streams | events | motor_periodic.PID_VAL.mask_bit == 0x37


def test_boards_drop_a_set_of_wrong_length_and_take_the_exempted_ones() -> None:
    for command in motor.COMMANDS.values():
        is_set = command.reply_layout is None
        wrong = bytes(command.request_layout.dlc + 1)
        dropped = command.parse_request(wrong) is None
        assert dropped == (is_set and command.name not in ANY_LENGTH_SETS), command.name


def test_exempted_command_reads_missing_bytes_as_zero() -> None:
    # [04, type 3, p1 = 0x0955] and nothing else
    assert motor.CALIBRATE_ENCODER.parse_request(b"\x04\x03\x55\x09") == (3, 0x955, 0, 0)


def test_commands_that_dsp_boards_ignore_are_unknown() -> None:
    for code in (1, 2, 5, 6, 17, 49, 53, 59, 70, 71, 77, 101, 109, 113, 119, 124, 127):
        assert motor.command_of(bytes((code,))) is None
    assert motor.command_of(b"") is None


def test_reply_of_wrong_length_is_refused() -> None:
    assert motor.GET_PID_ERROR.parse_reply(b"\x37\x00") is None
    assert motor.SET_P_GAIN.parse_reply(b"\x1e\x00\x7d") is None
    assert analog.GET_FULL_SCALES.parse_reply(b"\x18\x00\x05") is None
    assert management.DISCOVER_BOOTLOADER.parse_reply(b"\xff\x00\x02\x03") == (0, 2, 3)


@pytest.mark.parametrize(
    ("speed", "target", "named"),
    [(40_000, 0, "speed = 40000 does not fit i16"), (0, 1 << 31, "target = 2147483648")],
)
def test_value_that_does_not_fit_is_named(speed: int, target: int, named: str) -> None:
    with pytest.raises(WireError, match=f"POSITION_MOVE: {named}"):
        motor.POSITION_MOVE.request(1, 0, target, speed)


def test_other_misuse_is_named() -> None:
    with pytest.raises(WireError, match="POSITION_MOVE carries target, speed; got 1 values"):
        motor.POSITION_MOVE.request(1, 0, 5)
    with pytest.raises(WireError, match="axis does not fit"):
        motor.MOTION_DONE.request(1, 2)
    with pytest.raises(WireError, match="SET_P_GAIN has no reply"):
        motor.SET_P_GAIN.reply(1, 0, 5)
    with pytest.raises(WireError, match="interaction1 = 16 does not fit u4"):
        motor_periodic.ADDITIONAL_STATUS.frame(1, 0, 16)
    with pytest.raises(WireError, match="FORCE: fy = 65536 does not fit u16"):
        analog.FORCE.frame(13, 0, 65536, 0)
    with pytest.raises(WireError, match="mode = 256 does not fit u8"):
        analog.SET_TXMODE.request(13, 256)


def test_fields_lie_where_the_sheet_puts_them() -> None:
    layout = motor.SET_MOTOR_PARAMS.request_layout
    assert [field.name for field in layout.fields] == ["bemf", "bemf_shift", "ktau", "ktau_shift"]
    assert layout.offsets == (1, 3, 4, 6)
    assert isinstance(motor_periodic.ADDITIONAL_STATUS.layout, NibblePair)
    assert motor_periodic.MOTOR_SPEED.layout.offsets == (0, 2)


def test_internal_calibration_modes_are_reported_as_calibration() -> None:
    assert [reported_mode(m) for m in (0x10, 0x20, 0x40, 0x41)] == [ControlMode.CALIBRATION] * 4
    assert reported_mode(ControlMode.HW_FAULT) == 0xA0
