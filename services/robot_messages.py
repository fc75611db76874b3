"""What the robot process is asked, and what it tells of itself, its boards and its buses."""

import msgspec

from services.messages import Floats, Message


class RobotRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something for the HAL to do."""

    action: str  # calibrate | move | mode | interaction | stop | park | idle | tune
    joints: tuple[str, ...] = ()  # empty = all
    value: str = ""  # mode: idle, position, direct, velocity, torque, pwm; interaction: stiff,
    # compliant; tune: position_pid, torque_pid, impedance, current_limit, velocity_limit
    q_rad: Floats = ()
    duration_s: float = 0.0
    settings: tuple[tuple[str, float], ...] = ()  # tune: all of the kind, by the HAL's names


class BoardStatus(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One board of the robot file as it is found on its bus."""

    name: str
    bus: int
    address: int
    state: str  # ok | missing | wrong | silent | restarted | needs calibration
    reason: str  # why it is not ok, empty when it is
    since_ns: int


class BusStatus(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One CAN bus: whether it works, and what passes."""

    number: int
    state: str  # active | passive | off | nobody acknowledges
    frames_received: int
    frames_sent: int
    frames_lost: int
    errors: int
    load_percent: float


class RobotStatus(Message, frozen=True, kw_only=True):
    """The HAL's heartbeat."""

    phase: str  # opening | handshake | configuring | calibrating | ready | stopping | idle | failed
    calibrated: bool
    compliant: tuple[str, ...]  # names of the compliant joints
    faults: tuple[str, ...]  # text, newest last
    fault_count: int
    frames_received: int
    frames_sent: int
    frames_lost: int
    frames_dropped: int  # undecodable or orphaned, by cause in `drops`
    drops: tuple[tuple[str, int], ...] = ()
    refused_commands: int = 0
    torque_loop_ms: Floats = ()  # samples since the previous status
    foreign_frames: int = 0
    busy: bool = False
    refusals: tuple[tuple[str, int], ...] = ()  # by cause
    finished_task: int = 0  # every request up to this number has ended
    failed_tasks: tuple[tuple[int, str], ...] = ()  # the last ones that failed, and why
    clamped: tuple[tuple[str, int], ...] = ()  # sent, but not as given, by cause
    boards: tuple[BoardStatus, ...] = ()
    buses: tuple[BusStatus, ...] = ()
    calibration: tuple[tuple[str, str], ...] = ()  # joint, and: done, pending or failed: reason
