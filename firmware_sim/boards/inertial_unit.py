"""The BNO055 of STRAIN2-like boards: its configuration and its frames (can-protocol 7.2).

Order of the frames and where the sequence number counts: robotology/icub-firmware,
embot_app_application_theIMU.cpp (commit 04734b15). One number serves a whole acquisition.
"""

import math
from collections.abc import Sequence
from typing import Protocol

from hal.wire import analog_setup, inertial
from hal.wire.can import Frame
from hal.wire.inertial import ImuKind
from hal.wire.numbers import saturate_i16

GRAVITY_M_S2 = 9.80665
CALIBRATED = 3  # the highest level
ACQUISITION_US = 1800  # DELIBERATE: assumed; the sources state no duration
_TRIPLES = (
    ImuKind.ACCELEROMETER,
    ImuKind.MAGNETOMETER,
    ImuKind.GYROSCOPE,
    ImuKind.EULER,
    ImuKind.LINEAR_ACCELERATION,
    ImuKind.GRAVITY,
)


class Motion(Protocol):
    """What an inertial unit feels, in its own axes."""

    acceleration_m_s2: list[float]  # at rest +1 g upwards
    gyro_deg_s: list[float]
    magnetic_ut: list[float]
    quaternion: list[float]  # w, x, y, z: from the sensor's axes to the earth's


class AtRest:
    """The motion of a unit that lies still, to be changed by whoever moves it."""

    def __init__(self) -> None:
        self.acceleration_m_s2 = [0.0, 0.0, GRAVITY_M_S2]
        self.gyro_deg_s = [0.0, 0.0, 0.0]
        self.magnetic_ut = [0.0, 0.0, 0.0]
        self.quaternion = [1.0, 0.0, 0.0, 0.0]


class InertialUnit:
    """Answers its commands; `tick` once a millisecond gives the frames to send."""

    def __init__(self, address: int, motion: Motion) -> None:
        self.calibration = CALIBRATED
        self._motion = motion
        self._address = address
        self.boot()

    def boot(self) -> None:
        """Nothing is configured and nothing sent."""
        self.config: tuple[int, ...] = (0, 0, 0, 0, 0)
        self.sequence = 0
        self.stop()

    def stop(self) -> None:
        """Send nothing until the next IMU_TRANSMIT."""
        self._period_ms = 0
        self._elapsed_ms = 0

    def answer(self, code: int, data: bytes) -> list[Frame] | None:
        """Act on a command; None when it is none of the unit's."""
        if code == analog_setup.IMU_CONFIG_SET.code:
            self.stop()  # a new configuration ends the transmission
            self.config = analog_setup.IMU_CONFIG_SET.parse_request(data) or self.config
        elif code == analog_setup.IMU_CONFIG_GET.code:
            return [analog_setup.IMU_CONFIG_GET.reply(self._address, *self.config)]
        elif code == analog_setup.IMU_TRANSMIT.code:
            self.stop()
            (self._period_ms,) = analog_setup.IMU_TRANSMIT.parse_request(data) or (0,)
        else:
            return None
        return []

    def tick(self, sent: list[Frame]) -> None:
        """Append the frames of one acquisition when its time has come."""
        if not self._period_ms:
            return
        self._elapsed_ms += 1
        if self._elapsed_ms >= self._period_ms:
            self._elapsed_ms = 0
            self._acquire(sent)

    def _acquire(self, sent: list[Frame]) -> None:
        mask = self.config[0]
        self.sequence = self.sequence + 1 & 0xFF
        for kind in _TRIPLES:
            if mask >> kind & 1:
                scale = inertial.COUNTS_PER_UNIT[kind]
                x, y, z = (saturate_i16(value * scale) for value in self._values(kind))
                sent.append(inertial.IMU_TRIPLE.frame(self._address, self.sequence, kind, x, y, z))
        if mask >> ImuKind.QUATERNION & 1:
            counts = [
                saturate_i16(q * inertial.IMU_COUNTS_PER_UNIT) for q in self._motion.quaternion
            ]
            sent.append(inertial.IMU_QUATERNION.frame(self._address, *counts))
        if mask >> ImuKind.STATUS & 1:
            levels = (self.calibration,) * 3
            values = (self.sequence, *levels, ACQUISITION_US)
            sent.append(inertial.IMU_STATUS.frame(self._address, *values))

    def _values(self, kind: ImuKind) -> Sequence[float]:
        if kind == ImuKind.ACCELEROMETER:
            return self._motion.acceleration_m_s2
        if kind == ImuKind.MAGNETOMETER:
            return self._motion.magnetic_ut
        if kind == ImuKind.GYROSCOPE:
            return self._motion.gyro_deg_s
        if kind == ImuKind.EULER:
            return euler_deg(self._motion.quaternion)
        gravity = gravity_m_s2(self._motion.quaternion)
        if kind == ImuKind.GRAVITY:
            return gravity
        return [a - g for a, g in zip(self._motion.acceleration_m_s2, gravity, strict=True)]


def gravity_m_s2(quaternion: Sequence[float]) -> list[float]:
    """What a sensor at rest reads, in its own axes; `quaternion` turns sensor axes into earth's."""
    w, x, y, z = quaternion
    up = (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    return [GRAVITY_M_S2 * part for part in up]


def euler_deg(quaternion: Sequence[float]) -> list[float]:
    """Heading, roll and pitch of the BNO055 in degrees, heading 0 to 360."""
    w, x, y, z = quaternion
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    return [math.degrees(heading) % 360.0, math.degrees(roll), math.degrees(pitch)]
