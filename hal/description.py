"""What the HAL must know of a robot: boards, joints, sensors, in the units of the robot file.

services/config.py builds these values from robots/<name>/robot.toml; the HAL never reads a file.
"""

import math

import msgspec


class PositionPid(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains of the board's position loop, machine units (ticks, PWM counts, right shift)."""

    kp: int
    ki: int
    kd: int
    shift: int
    integral_limit: int
    output_limit: int
    offset: int = 0
    stiction_up: int = 0
    stiction_down: int = 0


class TorquePid(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains of the board's torque loop, machine units (torque units, PWM counts, right shift)."""

    kp: int
    ki: int
    kd: int
    shift: int
    integral_limit: int
    output_limit: int
    offset: int = 0
    kff: int = 0
    bemf: int = 0
    bemf_shift: int = 0
    ktau: int = 0
    ktau_shift: int = 0
    stiction_up: int = 0
    stiction_down: int = 0
    filter: int = 0  # 0 none, 3 = 3 Hz low-pass of the torque loop's PWM


class Impedance(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Joint impedance that the board runs while the axis is compliant."""

    stiffness_nm_deg: float
    damping_nms_deg: float


class TorqueSource(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Virtual sensor whose channel carries this joint's torque (can-protocol 6)."""

    address: int
    channel: int
    full_scale_nm: float  # the board's TorqueMax is this value, never a second setting


class Calibration(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Arguments of CALIBRATE_ENCODER (can-protocol 10.5)."""

    type: int
    p1: float
    p2: float
    p3: float
    startup_pwm: int
    order: int = 0  # joints of one order are calibrated together, lower orders first


class Joint(msgspec.Struct, frozen=True, kw_only=True):
    """One motor axis seen from the host. Limits are already the intersection with the model."""

    name: str
    part: str
    bus: int
    address: int  # the address that owns the axis: a 4DC's axes 2 and 3 answer at address + 1
    axis: int  # 0 or 1
    ticks_per_deg: float
    zero_deg: float
    min_deg: float
    max_deg: float
    margin_deg: float = 0.0  # set-points stay this far inside: what the axis overshoots at most
    max_velocity_deg_s: float
    position_pid: PositionPid
    current_limit_ma: int
    pwm_limit: int
    calibration: Calibration
    torque_pid: TorquePid | None = None
    impedance: Impedance | None = None
    torque_source: TorqueSource | None = None
    max_acceleration_deg_s2: float = math.inf  # of velocity set-points
    max_torque_rate_nm_s: float = math.inf  # of torque set-points
    motor_nm: float = 0.0  # torque of its own motor, joint side, stalled at full PWM; 0 = not known
    max_duty_rate_percent_s: float = 200.0  # of open-loop set-points


class Board(msgspec.Struct, frozen=True, kw_only=True):
    """One controller board on a bus."""

    name: str
    bus: int
    address: int
    type: str  # a name of hal/registry.py
    firmware: tuple[int, int]  # as on the wire: 2.57 is (0x02, 0x57)
    broadcast: tuple[int, ...]  # SET_BCAST_POLICY mask per address that the board owns
    required: bool = True  # without it the robot does not start; else it starts without its axes
    period_ms: int = 0  # of what a sensor board sends; 0 = the type's own
    frame: str = ""  # URDF link that an inertial sensor sits on; an mtb without one sends skin only
    coupled: bool = True  # False: motors turn one joint each, whatever its firmware couples


class ForceTorqueSensor(msgspec.Struct, frozen=True, kw_only=True):
    """One six-axis sensor and the STRAIN board that reads it."""

    name: str
    frame: str  # URDF frame that the wrench is expressed in
    bus: int
    address: int
    full_scale: tuple[float, float, float, float, float, float]  # N, N, N, Nm, Nm, Nm


class RobotDescription(msgspec.Struct, frozen=True, kw_only=True):
    """Everything the HAL configures, commands and listens to."""

    name: str
    boards: tuple[Board, ...]
    joints: tuple[Joint, ...]
    sensors: tuple[ForceTorqueSensor, ...]
    velocity_shift: int = 8  # scale of VELOCITY_MOVE: ticks/ms * 2^shift
    speed_estimate_shift: int = 5  # scale of the VELOCITY broadcast
    velocity_timeout_ms: int = 100
    allow_missing: bool = False  # start with the boards that are there, as if none were required
