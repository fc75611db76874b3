"""Payloads written by hand from the offsets of can-protocol 2.2, 3.1 and 5, one per layout.

Every value differs from its neighbours, so a swapped or shifted field cannot pass.
"""

import pytest

from hal.wire import analog, motor, motor_periodic
from hal.wire.analog import THERMOMETER, TripleMessage
from hal.wire.message import AxisCommand, Command, PeriodicMessage
from hal.wire.modes import CalibrationType

AXIS_REQUESTS: list[tuple[AxisCommand, tuple[int, ...], str]] = [
    (
        motor.CALIBRATE_ENCODER,
        (CalibrationType.HARD_STOP, 900, -20, 0),
        "84 00 84 03 EC FF 00 00",
    ),
    (motor.SET_ADDITIONAL_INFO, (2, *b"abcd"), "8D 02 61 62 63 64"),
    (motor.SET_SPEED_ESTIM_SHIFT, (5, 6, 7, 8), "8E 05 06 07 08"),
    (motor.SET_MAX_MOTOR_POS, (-2,), "8F FE FF FF FF"),
    (motor.SET_DEBUG_PARAM, (10, -1000), "92 0A 18 FC"),
    (motor.GET_DEBUG_PARAM, (10,), "93 0A"),
    (motor.SET_DESIRED_POSITION, (70000,), "95 70 11 01 00"),
    (motor.SET_DESIRED_VELOCITY, (258,), "97 02 01"),
    (motor.SET_D_GAIN, (-100,), "A0 9C FF"),
    (motor.SET_I_GAIN, (60,), "A2 3C 00"),
    (motor.SET_ILIM_GAIN, (800,), "A4 20 03"),
    (motor.SET_OFFSET, (-3,), "A6 FD FF"),
    (motor.SET_SCALE, (13,), "A8 0D 00"),
    (motor.SET_TLIM, (760,), "AA F8 02"),
    (motor.SET_PWM_LIMIT, (120,), "AF 78 00"),
    (motor.SET_BOARD_ID, (9,), "B2 09"),
    (motor.SET_TORQUE_SOURCE, (12, 3), "B4 0C 03 00 00 00 00 00"),
    (motor.SET_OFFSET_ABS_ENCODER, (4095,), "CB FF 0F 00 00"),
    (motor.SET_TORQUE_PIDLIMITS, (1, 760, 800), "D0 01 00 F8 02 20 03 00"),
    (motor.SET_POS_PID, (-32000, 60, 50, 13), "D2 00 83 3C 00 32 00 0D"),
    (motor.SET_POS_PIDLIMITS, (-1, 760, 800), "D4 FF FF F8 02 20 03 00"),
    (motor.SET_IMPEDANCE_OFFSET, (-4096,), "D9 00 F0"),
    (motor.SET_POS_STICTION_PARAMS, (20, -30), "DD 14 00 E2 FF"),
    (motor.SET_TORQUE_STICTION_PARAMS, (21, -31), "DF 15 00 E1 FF"),
    (motor.SET_MOTOR_PARAMS, (259, 4, -2, 5), "E1 03 01 04 FE FF 05 00"),
    (motor.SET_MODEL_PARAMS, (-2, 9), "E3 FE FF 09 00 00 00 00"),
    (motor.SET_TCFILTER_TYPE, (3,), "F6 03"),
    (motor.STOP_TRAJECTORY, (), "AE"),
]

AXIS_REPLIES: list[tuple[AxisCommand, tuple[int, ...], str]] = [
    (motor.GET_CONTROL_MODE, (0x60,), "07 60 00"),
    (motor.MOTION_DONE, (1,), "08 01 00"),
    (motor.GET_ADDITIONAL_INFO, (7, *b"wxyz"), "0C 07 77 78 79 7A"),
    (motor.GET_DEBUG_PARAM, (-2,), "13 FE FF"),
    (motor.GET_ENCODER_POSITION, (-2, 258), "14 FE FF FF FF 02 01"),
    (motor.GET_CALIBRATION_STATUS, (1, 0x41, 0), "38 01 41 00"),
    (motor.GET_DESIRED_TORQUE, (-4096,), "2D 00 F0 FF FF"),
    (motor.GET_TORQUE_PID, (-76, 1, 2, 14), "4F B4 FF 01 00 02 00 0E"),
    (motor.GET_IMPEDANCE_PARAMS, (144, 10803, -5), "58 90 00 33 2A FB FF 00"),
    (motor.GET_INTERACTION_MODE, (1,), "75 01 00"),
    (motor.GET_TCFILTER_TYPE, (3,), "78 03"),
]

SENSOR_REQUESTS: list[tuple[Command, tuple[int, ...], str]] = [
    (analog.SET_MATRIX_RC, (1, 5, -2), "03 01 05 FF FE"),
    (analog.SET_CH_DAC, (4, 0x0102), "04 04 01 02"),
    (analog.GET_CH_ADC, (2, 1), "0C 02 01"),
    (analog.SET_MATRIX_G, (1,), "11 01"),
    (analog.SET_CALIB_TARE, (2, 3, -300), "13 02 03 FE D4"),
    (analog.SET_FULL_SCALES, (0, 1521), "17 00 05 F1"),
    (analog.SET_SERIAL_NO, tuple(b"SN023\0\0"), "19 53 4E 30 32 33 00 00"),
    (analog.GET_FW_VERSION, analog.HOST_PROTOCOL, "1C 01 00"),
]

SENSOR_REPLIES: list[tuple[Command, tuple[int, ...], str]] = [
    (analog.SAVE2EE, (1,), "09 01"),
    (analog.GET_MATRIX_RC, (1, 5, 0x7FFF), "0A 01 05 7F FF"),
    (analog.GET_CH_ADC, (2, 1, 0x8001), "0C 02 01 80 01"),
    (analog.GET_MATRIX_G, (1,), "12 01"),
    (analog.GET_CALIB_TARE, (3, -300), "14 03 FE D4"),
    (analog.GET_CURR_TARE, (3, 300), "16 03 01 2C"),
    (analog.GET_EEPROM_STATUS, (1,), "1B 01"),
]

BROADCASTS: list[tuple[PeriodicMessage | TripleMessage, tuple[int, ...], str]] = [
    (motor_periodic.VELOCITY, (291, -291, 1, -1), "23 01 DD FE 01 00 FF FF"),
    (motor_periodic.PID_ERROR, (1, -2, 3, -4), "01 00 FE FF 03 00 FC FF"),
    (motor_periodic.DEBUG, (1, 2, 3, -4), "01 00 02 00 03 00 FC FF"),
    (motor_periodic.MOTOR_POSITION, (70000, -2), "70 11 01 00 FE FF FF FF"),
    (motor_periodic.MOTOR_SPEED, (258, -2), "02 01 FE FF 00 00 00 00"),
    (motor_periodic.OVERFLOW, (), ""),
    (motor_periodic.STATUS, (1, 2, 3, 4, 5, 6, 7, 8), "01 02 03 04 05 06 07 08"),
    (THERMOMETER, (1, 312, -5), "01 38 01 FB FF"),
    (analog.RAW_TORQUE, (1, 0x0203, 0xFFFE), "01 00 03 02 FE FF"),
]


@pytest.mark.parametrize(("command", "values", "payload"), AXIS_REQUESTS)
def test_request_of_axis_1(command: AxisCommand, values: tuple[int, ...], payload: str) -> None:
    assert command.request(3, 1, *values) == (0x003, bytes.fromhex(payload))
    assert command.parse_request(bytes.fromhex(payload)) == values


@pytest.mark.parametrize(("command", "values", "payload"), AXIS_REPLIES)
def test_reply_of_axis_0(command: AxisCommand, values: tuple[int, ...], payload: str) -> None:
    assert command.reply(3, 0, *values) == (0x030, bytes.fromhex(payload))
    assert command.parse_reply(bytes.fromhex(payload)) == values


@pytest.mark.parametrize(("command", "values", "payload"), SENSOR_REQUESTS)
def test_sensor_request(command: Command, values: tuple[int, ...], payload: str) -> None:
    assert command.request(13, *values) == (0x20D, bytes.fromhex(payload))
    assert command.parse_request(bytes.fromhex(payload)) == values


@pytest.mark.parametrize(("command", "values", "payload"), SENSOR_REPLIES)
def test_sensor_reply(command: Command, values: tuple[int, ...], payload: str) -> None:
    assert command.reply(13, *values) == (0x2D0, bytes.fromhex(payload))
    assert command.parse_reply(bytes.fromhex(payload)) == values


@pytest.mark.parametrize(("message", "values", "payload"), BROADCASTS)
def test_broadcast(
    message: PeriodicMessage | TripleMessage, values: tuple[int, ...], payload: str
) -> None:
    assert message.frame(4, *values)[1] == bytes.fromhex(payload)
    parsed = message.parse(bytes.fromhex(payload))
    assert parsed is not None
    assert parsed[: len(values)] == values


def test_type_and_class_of_the_sensor_broadcasts() -> None:
    words = (0, 0, 0)
    ids = [analog.MESSAGES[kind].frame(13, *words)[0] for kind in (0x8, 0x9, 0xA, 0xB, 0xE)]
    assert ids == [0x3D8, 0x3D9, 0x3DA, 0x3DB, 0x3DE]
