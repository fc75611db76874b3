"""What the HAL hands out: the joints as they are, force/torque samples, and its own status.

SI units and radians, joints in the order of the robot description.
"""

import math

import msgspec

from hal.wire.modes import ControlMode

Triple = tuple[float, float, float]


class JointReadings:
    """Latest state of every joint, one list per quantity; the HAL overwrites the entries in place.

    `q_rad` is NaN before the first POSITION frame, `tau_nm` NaN before the first torque. `fault` is
    the text of the axis's present fault, empty when there is none. `heard_ns` is the arrival of the
    last POSITION frame.
    """

    __slots__ = (
        "calibrated",
        "compliant",
        "control_mode",
        "dq_rad_s",
        "fault",
        "heard_ns",
        "moving",
        "names",
        "q_rad",
        "tau_nm",
    )

    def __init__(self, names: tuple[str, ...]) -> None:
        count = len(names)
        self.names = names
        self.q_rad = [math.nan] * count
        self.dq_rad_s = [0.0] * count
        self.tau_nm = [math.nan] * count
        self.control_mode: list[int] = [ControlMode.IDLE] * count
        self.compliant = [False] * count
        self.calibrated = [False] * count
        self.moving = [False] * count
        self.fault = [""] * count
        self.heard_ns = [0] * count


class ForceTorqueSample(msgspec.Struct, frozen=True, gc=False):
    """One pair of force and torque frames of a sensor, physical units, in the sensor's own frame.

    A STRAIN board repeats the last good values while saturated, so a saturated sample is not a
    fresh reading.
    """

    force_n: Triple
    torque_nm: Triple
    arrival_ns: int  # of the second frame, 0xB
    saturated: bool = False
    channels: tuple[int, ...] = ()  # while saturated: 0 ok, 1 low, 2 high, per channel
    frozen: bool = False  # the sensor repeats one sample where noise is expected

    @property
    def is_fresh(self) -> bool:
        """Whether this is a reading, and not the repetition of one."""
        return not (self.saturated or self.frozen)


class HallSample(msgspec.Struct, frozen=True, gc=False):
    """The 15 Hall sensors of a hand, HES0 first, 0 to 255."""

    hall_counts: tuple[int, ...]
    arrival_ns: int  # of the second frame


class SkinSample(msgspec.Struct, frozen=True, gc=False):
    """All taxels of one board: 12 x triangle + taxel. Pressure lowers a taxel below `no_load`.

    A triangle that was not heard in this period, or whose error is not 0, shows older values.
    """

    taxels: bytes  # 192
    errors: bytes  # per triangle: 0 ok, 1 no answer, 2 not connected
    out_of_range: tuple[int, ...]  # per triangle, bit i = taxel i
    heard: int  # bit per triangle
    arrival_ns: int  # of the last tail
    no_load: int


class InertialSample(msgspec.Struct, frozen=True, gc=False):
    """Gyroscope and accelerometer of an MTB board, in the sensors' own axes."""

    gyro_rad_s: Triple
    acceleration_m_s2: Triple  # at rest g upwards
    arrival_ns: int  # of the second frame


class ImuSample(msgspec.Struct, frozen=True, gc=False):
    """One acquisition of an IMU, in its own axes; the quaternion turns them into the earth's."""

    quaternion: tuple[float, float, float, float]  # w, x, y, z
    gyro_rad_s: Triple
    acceleration_m_s2: Triple  # at rest g upwards
    magnetic_t: Triple
    calibration: tuple[int, int, int]  # gyroscope, accelerometer, magnetometer: 0 to 3
    sequence: int  # 0 to 255
    lost: int  # acquisitions between the previous sample and this one
    arrival_ns: int  # of the last frame


class BoardReport(msgspec.Struct, frozen=True, kw_only=True):
    """One board of the robot description as it is found on its bus."""

    name: str
    bus: int
    address: int
    type: str  # expected, a name of hal/registry.py
    found_type: int | None  # the number that it reports, None while it has never answered
    firmware: tuple[int, int]  # expected, as on the wire
    found_firmware: tuple[int, int] | None
    build: int | None
    protocol: tuple[int, int] | None
    state: str  # ok | missing | wrong | silent | restarted | needs calibration
    reason: str  # why it is not ok, empty when it is
    since_ns: int  # when it entered that state


class BusReport(msgspec.Struct, frozen=True, kw_only=True):
    """One CAN bus: what passes, and whether it works."""

    number: int
    state: str  # active | passive | off | nobody acknowledges
    since_ns: int
    frames_received: int
    frames_sent: int
    frames_lost: int
    errors: int  # reports of CAN trouble by its boards, and frames that could not be used
    load_percent: float  # of 1 Mbit/s over the last second, without stuff bits


class HalStatus(msgspec.Struct, frozen=True, kw_only=True):
    """Phase, faults and counters. Field names are those of the RobotStatus message."""

    phase: str  # opening | handshake | configuring | idle | calibrating | ready | stopping | failed
    calibrated: bool
    compliant: tuple[str, ...]
    faults: tuple[str, ...]  # the last ones, newest last
    fault_count: int
    frames_received: int
    frames_sent: int
    frames_lost: int
    frames_dropped: int
    drops: tuple[tuple[str, int], ...]  # by cause
    refused_commands: int
    refusals: tuple[tuple[str, int], ...]  # by cause
    clamped: tuple[tuple[str, int], ...]  # set-points that were sent, but not as given, by cause
    torque_loop_ms: tuple[float, ...]  # samples since the previous status
    foreign_frames: int
    busy: bool
    boards: tuple[BoardReport, ...] = ()
    buses: tuple[BusReport, ...] = ()
    calibration: tuple[tuple[str, str], ...] = ()  # joint, and: done, pending or failed: reason
