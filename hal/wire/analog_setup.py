"""Set-up commands of STRAIN2, of its IMU and thermometer, and of the skin boards (class 2).

Unlike STRAIN's own commands (hal/wire/analog.py) these are little-endian (can-protocol 1 and 5.1).
STRAIN2 reads the high half of a channel byte as the regulation set: 0 the one in use, 1 to 3. The
layouts that can-protocol 5.1 leaves open are those that robotology/icub-firmware reads (commit
08c40805, embot_prot_can_analog_polling.cpp).
"""

from enum import IntEnum, IntFlag

from hal.wire.can import CLASS_ANALOG_POLLING
from hal.wire.layout import opaque, u8, u16
from hal.wire.message import Command, Payload


class ImuSensor(IntFlag):
    """Sensor mask of IMU_CONFIG; bit n is the sensor of id n in the IMU frames."""

    ACCELEROMETER = 0x0001
    MAGNETOMETER = 0x0002
    GYROSCOPE = 0x0004
    EULER = 0x0008
    QUATERNION = 0x0010
    LINEAR_ACCELERATION = 0x0020
    GRAVITY = 0x0040
    STATUS = 0x8000


class MtbSensor(IntFlag):
    """Sensor mask of ACC_GYRO_SETUP; zero stops them all."""

    ANALOG_ACCELEROMETER = 0x01
    INTERNAL_ACCELEROMETER = 0x02
    EXTERNAL_GYROSCOPE = 0x04
    EXTERNAL_ACCELEROMETER = 0x08


class SkinType(IntEnum):
    """What the taxels of a board are, in SET_BRD_CFG."""

    TEMPERATURE_COMPENSATED = 0
    PALM_FINGERTIP = 1
    UNCOMPENSATED = 2
    ERGOHAND = 3
    RAW = 7
    TEMPERATURE_COMPENSATED_V2 = 8


COMMANDS: dict[int, Command] = {}
"""Every row by its code."""


def _row(code: int, name: str, request: Payload = (), reply: Payload | None = None) -> Command:
    command = Command(CLASS_ANALOG_POLLING, code, name, request, reply)
    COMMANDS[code] = command
    return command


class RegulationMode(IntEnum):
    """Low half of the byte of REGULATIONSET_SET; the high half is the regulation set."""

    TEMPORARY = 0
    PERMANENT = 1  # the set in use after a boot


_CHANNEL = (u8("set_channel"),)  # regulation set << 4 | channel, 15 = all channels
_GAIN_OFFSET = (u16("gain", "0.01"), u16("offset"))
_PGA308 = (
    *_CHANNEL,
    u16("fine_gain"),
    u8("gains"),  # input gain << 4 | negative << 3 | output gain
    u8("coarse_offset"),
    u16("zero_dac"),
)
_IMU_CONFIG = (
    u16("sensors", choices=ImuSensor),
    u8("fusion_mode"),
    u8("orientation"),  # bit 7 = custom, the others its parameter
    u8("reserved0"),
    u16("reserved1"),
)

AMPLIFIER_RESET = _row(0x1D, "AMPLIFIER_RESET", _CHANNEL)
AMPLIFIER_RANGE_OF_GAIN_GET = _row(
    0x1E,
    "AMPLIFIER_RANGE_OF_GAIN_GET",
    _CHANNEL,
    (*_CHANNEL, u16("lowest", "0.01"), u16("highest", "0.01")),
)
AMPLIFIER_RANGE_OF_OFFSET_GET = _row(
    0x1F, "AMPLIFIER_RANGE_OF_OFFSET_GET", _CHANNEL, (*_CHANNEL, u16("lowest"), u16("highest"))
)
AMPLIFIER_GAINOFFSET_GET = _row(
    0x20, "AMPLIFIER_GAINOFFSET_GET", _CHANNEL, (*_CHANNEL, *_GAIN_OFFSET)
)
AMPLIFIER_GAINOFFSET_SET = _row(
    0x21, "AMPLIFIER_GAINOFFSET_SET", (*_CHANNEL, u8("default"), *_GAIN_OFFSET)
)
AMPLIFIER_OFFSET_AUTOCALIB = _row(
    0x22,
    "AMPLIFIER_OFFSET_AUTOCALIB",
    (*_CHANNEL, u8("mode"), u16("target"), u16("tolerance"), u8("samples")),
    (
        *_CHANNEL,
        u8("noisy_channels"),
        u8("algorithm_ok"),
        u8("measure_ok"),
        u8("reserved"),
        u16("mean_error"),
    ),
)
AMPLIFIER_PGA308_CFG1_GET = _row(0x2A, "AMPLIFIER_PGA308_CFG1_GET", _CHANNEL, _PGA308)
AMPLIFIER_PGA308_CFG1_SET = _row(0x2B, "AMPLIFIER_PGA308_CFG1_SET", _PGA308)
IMU_CONFIG_GET = _row(0x33, "IMU_CONFIG_GET", (), _IMU_CONFIG)
IMU_CONFIG_SET = _row(0x34, "IMU_CONFIG_SET", _IMU_CONFIG)
IMU_TRANSMIT = _row(0x35, "IMU_TRANSMIT", (u8("period", "ms"),))  # 0 stops
THERMOMETER_CONFIG_GET = _row(0x38, "THERMOMETER_CONFIG_GET", (), (u8("sensors"),))
THERMOMETER_CONFIG_SET = _row(0x39, "THERMOMETER_CONFIG_SET", (u8("sensors"),))
THERMOMETER_TRANSMIT = _row(0x3A, "THERMOMETER_TRANSMIT", (u8("period", "s"),))  # 0 stops
# The byte holds regulation set << 4 | RegulationMode.
REGULATIONSET_SET = _row(0x3D, "REGULATIONSET_SET", (u8("set_mode"),))
REGULATIONSET_GET = _row(0x3E, "REGULATIONSET_GET", (u8("mode"),), (u8("set_mode"),))
TACT_SETUP = _row(  # the old way to start a skin board, with TACT_SETUP2
    0x4C,
    "TACT_SETUP",
    (u8("connected"), u8("time"), u8("timer"), u16("cdc_offset"), u16("time_param")),
)
SET_BRD_CFG = _row(
    0x4D,
    "SET_BRD_CFG",
    (u8("type", choices=SkinType), u8("period", "ms"), u8("no_load")),
)
TACT_SETUP2 = _row(
    0x4E,
    "TACT_SETUP2",
    (
        u8("shift"),
        u8("shift3_1"),
        u8("no_load"),
        u8("param"),
        u16("enable"),
        u8("last"),  # 0x0A
    ),
)
ACC_GYRO_SETUP = _row(
    0x4F, "ACC_GYRO_SETUP", (u8("sensors", choices=MtbSensor), u8("period", "ms"))
)
SET_TRIANG_CFG = _row(
    0x50,
    "SET_TRIANG_CFG",
    (u8("first"), u8("last"), u8("shift"), u8("flags"), u16("cdc_offset")),  # bit 0 = enabled
)
# Boards of the hand (PSC) that an iCub v1 and v2 does not have: bytes as they come.
POS_CONFIG_GET = _row(0x51, "POS_CONFIG_GET", opaque(prefix=True), opaque(prefix=True))
POS_CONFIG_SET = _row(0x52, "POS_CONFIG_SET", opaque(prefix=True))
POS_TRANSMIT = _row(0x53, "POS_TRANSMIT", (u8("period", "ms"),))  # 0 stops
