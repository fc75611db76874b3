"""Inertial frames, class 5: accelerometer and gyroscope of MTB boards, IMU of STRAIN2-like boards.

Counts are signed 16-bit words; the scales below are counts per unit (can-protocol 7.1, 7.2). Those
of the MTB are the data sheets' (L3G4200D at 250 deg/s, LIS331DLH at 2 g).
"""

from enum import IntEnum

from hal.wire.can import CLASS_INERTIAL_PERIODIC
from hal.wire.layout import Field, Layout, i16, u8, u32
from hal.wire.message import PeriodicMessage

MTB_COUNTS_PER_DEG_S = 1 / 0.00875
MTB_COUNTS_PER_G = 16000.0

IMU_COUNTS_PER_M_S2 = 100.0
IMU_COUNTS_PER_MICROTESLA = 16.0
IMU_COUNTS_PER_DEG_S = 16.0
IMU_COUNTS_PER_DEG = 16.0  # Euler angles
IMU_COUNTS_PER_UNIT = 16384.0  # quaternion


class ImuKind(IntEnum):
    """What an IMU_TRIPLE carries; also the number of its bit in the mask of IMU_CONFIG_SET."""

    ACCELEROMETER = 0
    MAGNETOMETER = 1
    GYROSCOPE = 2
    EULER = 3
    QUATERNION = 4  # a frame of its own
    LINEAR_ACCELERATION = 5
    GRAVITY = 6
    STATUS = 15  # a frame of its own


COUNTS_PER_UNIT: dict[ImuKind, float] = {
    ImuKind.ACCELEROMETER: IMU_COUNTS_PER_M_S2,
    ImuKind.MAGNETOMETER: IMU_COUNTS_PER_MICROTESLA,
    ImuKind.GYROSCOPE: IMU_COUNTS_PER_DEG_S,
    ImuKind.EULER: IMU_COUNTS_PER_DEG,
    ImuKind.LINEAR_ACCELERATION: IMU_COUNTS_PER_M_S2,
    ImuKind.GRAVITY: IMU_COUNTS_PER_M_S2,
}
"""Scale of each IMU_TRIPLE."""


def _xyz(unit: str) -> tuple[Field, Field, Field]:
    return i16("x", unit), i16("y", unit), i16("z", unit)


MESSAGES: dict[int, PeriodicMessage] = {}
"""Every row by its type."""


def _row(kind: int, name: str, *fields: Field, order: str = "<") -> PeriodicMessage:
    message = PeriodicMessage(CLASS_INERTIAL_PERIODIC, kind, name, Layout(fields, order=order))
    MESSAGES[kind] = message
    return message


GYROSCOPE = _row(0, "GYROSCOPE", *_xyz("8.75 mdeg/s"))
ACCELEROMETER = _row(1, "ACCELEROMETER", *_xyz("g/16000"))
ANALOG_ACCELEROMETER = _row(2, "ANALOG_ACCELEROMETER", *_xyz(""), order=">")  # obsolete
IMU_TRIPLE = _row(3, "IMU_TRIPLE", u8("sequence"), u8("sensor", choices=ImuKind), *_xyz(""))
IMU_QUATERNION = _row(
    4,
    "IMU_QUATERNION",
    i16("w", "1/16384"),
    i16("x", "1/16384"),
    i16("y", "1/16384"),
    i16("z", "1/16384"),
)
IMU_STATUS = _row(
    5,
    "IMU_STATUS",
    u8("sequence"),
    u8("gyroscope_calibration"),  # 0 to 3
    u8("accelerometer_calibration"),
    u8("magnetometer_calibration"),
    u32("acquisition_time", "us"),
)
