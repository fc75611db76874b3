"""Set-up commands of the sensor boards: bytes by hand from can-protocol 5.1 and 7."""

import pytest

from hal.wire import analog, analog_setup
from hal.wire.analog_setup import ImuSensor, MtbSensor, RegulationMode, SkinType
from hal.wire.can import Frame
from hal.wire.message import Command

REQUESTS: list[tuple[Command, tuple[int, ...], str]] = [
    (analog_setup.AMPLIFIER_RESET, (0x1F,), "1D 1F"),
    (analog_setup.AMPLIFIER_GAINOFFSET_GET, (0x02,), "20 02"),
    (analog_setup.AMPLIFIER_GAINOFFSET_SET, (0x12, 0, 0x0930, 0x8001), "21 12 00 30 09 01 80"),
    (
        analog_setup.AMPLIFIER_OFFSET_AUTOCALIB,
        (0x0F, 0, 0x7D00, 0x0102, 4),
        "22 0F 00 00 7D 02 01 04",
    ),
    (
        analog_setup.AMPLIFIER_PGA308_CFG1_SET,
        (0x05, 0x2000, 0x46, 0x11, 0x6203),
        "2B 05 00 20 46 11 03 62",
    ),
    (
        analog_setup.IMU_CONFIG_SET,
        (ImuSensor.ACCELEROMETER | ImuSensor.GYROSCOPE | ImuSensor.STATUS, 1, 0, 0, 0),
        "34 05 80 01 00 00 00 00",
    ),
    (analog_setup.IMU_TRANSMIT, (50,), "35 32"),
    (analog_setup.THERMOMETER_CONFIG_SET, (1,), "39 01"),
    (analog_setup.THERMOMETER_TRANSMIT, (5,), "3A 05"),
    (analog_setup.REGULATIONSET_SET, (3 << 4 | RegulationMode.PERMANENT,), "3D 31"),
    (analog_setup.TACT_SETUP, (1, 1, 1, 0x2200, 0x0140), "4C 01 01 01 00 22 40 01"),
    (analog_setup.SET_BRD_CFG, (SkinType.PALM_FINGERTIP, 40, 240), "4D 01 28 F0"),
    (analog_setup.TACT_SETUP2, (2, 3, 245, 1, 0xFF01, 0x0A), "4E 02 03 F5 01 01 FF 0A"),
    (
        analog_setup.ACC_GYRO_SETUP,
        (MtbSensor.EXTERNAL_GYROSCOPE | MtbSensor.EXTERNAL_ACCELEROMETER, 10),
        "4F 0C 0A",
    ),
    (analog_setup.SET_TRIANG_CFG, (0, 15, 2, 1, 0x2200), "50 00 0F 02 01 00 22"),
    (analog_setup.POS_TRANSMIT, (10,), "53 0A"),
]
REPLIES: list[tuple[Command, tuple[int, ...], str]] = [
    (analog_setup.AMPLIFIER_RANGE_OF_GAIN_GET, (1, 700, 0x4E20), "1E 01 BC 02 20 4E"),
    (analog_setup.AMPLIFIER_RANGE_OF_OFFSET_GET, (1, 1, 0xFFFE), "1F 01 01 00 FE FF"),
    (analog_setup.AMPLIFIER_GAINOFFSET_GET, (0x12, 0x0930, 0x8001), "20 12 30 09 01 80"),
    (
        analog_setup.AMPLIFIER_OFFSET_AUTOCALIB,
        (0x0F, 0x01, 0x3E, 0x3F, 0, 0x0102),
        "22 0F 01 3E 3F 00 02 01",
    ),
    (
        analog_setup.AMPLIFIER_PGA308_CFG1_GET,
        (0x05, 0x2000, 0x46, 0x11, 0x6203),
        "2A 05 00 20 46 11 03 62",
    ),
    (analog_setup.IMU_CONFIG_GET, (0x8005, 1, 0x80, 0, 0), "33 05 80 01 80 00 00 00"),
    (analog_setup.REGULATIONSET_GET, (0x20,), "3E 20"),
]


@pytest.mark.parametrize(("command", "values", "payload"), REQUESTS)
def test_set_up_request_is_little_endian(
    command: Command, values: tuple[int, ...], payload: str
) -> None:
    assert command.request(14, *values) == (0x20E, bytes.fromhex(payload))
    assert command.parse_request(bytes.fromhex(payload)) == values


@pytest.mark.parametrize(("command", "values", "payload"), REPLIES)
def test_set_up_reply_is_little_endian(
    command: Command, values: tuple[int, ...], payload: str
) -> None:
    assert command.reply(14, *values) == (0x2E0, bytes.fromhex(payload))
    assert command.parse_reply(bytes.fromhex(payload)) == values


def test_start_of_the_inertial_stream_is_the_one_of_the_sheet() -> None:
    # Example 34: external accelerometer and gyroscope of MTB 14, each 10 ms.
    wanted: Frame = (0x20E, bytes.fromhex("4F0C0A"))
    sensors = MtbSensor.EXTERNAL_ACCELEROMETER | MtbSensor.EXTERNAL_GYROSCOPE
    assert analog_setup.ACC_GYRO_SETUP.request(14, sensors, 10) == wanted


def test_every_command_of_the_sheet_has_a_row() -> None:
    # can-protocol 5.1, first column
    codes = {*range(0x03, 0x23), 0x01, 0x2A, 0x2B, 0x32, 0x33, 0x34, 0x35, 0x38, 0x39, 0x3A}
    codes |= {0x3D, 0x3E, 0x4C, 0x4D, 0x4E, 0x4F, 0x50, 0x51, 0x52, 0x53}
    assert set(analog.COMMANDS) == codes


def test_unknown_payload_is_kept_byte_by_byte() -> None:
    request = analog_setup.POS_CONFIG_SET
    assert request.request(3, 1, 2, 3) == (0x203, b"\x52\x01\x02\x03")
    assert request.parse_request(b"\x52\x01\x02\x03") == (1, 2, 3)
    assert request.parse_request(b"\x52") == ()
    assert analog_setup.POS_CONFIG_GET.parse_reply(b"\x51\x09") == (9,)
