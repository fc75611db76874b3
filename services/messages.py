"""What all messages share, and those that pass between the services.

What one service alone is asked and tells is in a file of its own: `robot_messages.py`, and the
`messages.py` of its package. SI units and radians; the first field is the sender's time. Fields are
only ever added at the end, with a default.
"""

import math

import msgspec

Vector3 = tuple[float, float, float]
Floats = tuple[float, ...]
NAN3: Vector3 = (math.nan, math.nan, math.nan)


class Message(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """What all streams share: when it was made, on the sender's monotonic clock."""

    stamp_ns: int


class JointState(Message, frozen=True, kw_only=True):
    """One part's joints, in the order of the robot file."""

    q_rad: Floats
    dq_rad_s: Floats
    tau_nm: Floats  # the estimate that the boards were last given; NaN before the first
    control_mode: tuple[int, ...]  # code of can-protocol 10.1
    compliant: tuple[bool, ...]
    valid: bool  # every joint was heard within the age limit and is calibrated


class Wrench(Message, frozen=True, kw_only=True):
    """Reading of one FT sensor.

    What the limb beyond the sensor exerts on the near side, in the sensor frame.
    """

    force_n: Vector3
    torque_nm: Vector3
    arrival_ns: int  # when the second frame of the newest sample reached the robot process
    saturated: bool = False
    samples: int = 1  # averaged
    frozen: bool = False  # the sensor repeats one reading


class Hall(Message, frozen=True, kw_only=True):
    """Hall sensors of one hand, HES0 first."""

    counts: tuple[int, ...]  # 0 to 255
    arrival_ns: int


class Skin(Message, frozen=True, kw_only=True):
    """The 16 triangles of one skin board: 12 taxels each. Pressure lowers a taxel."""

    taxels: bytes  # 192, 0 to 255
    errors: bytes  # per triangle: 0 ok, 1 no answer, 2 not connected
    heard: int  # bit per triangle: its taxels are new
    no_load: int  # a taxel that nothing touches
    arrival_ns: int


class Inertial(Message, frozen=True, kw_only=True):
    """Gyroscope and accelerometer of a skin board, in their own axes."""

    gyro_rad_s: Vector3
    acceleration_m_s2: Vector3  # at rest g upwards
    arrival_ns: int


class Imu(Message, frozen=True, kw_only=True):
    """An IMU, in its own axes; the quaternion turns them into the earth's."""

    quaternion: tuple[float, float, float, float]  # w, x, y, z
    gyro_rad_s: Vector3
    acceleration_m_s2: Vector3  # at rest g upwards
    magnetic_t: Vector3
    arrival_ns: int
    lost: int = 0  # acquisitions since the previous message that never arrived


class TorqueEstimate(Message, frozen=True, kw_only=True):
    """Torque that each drive exerts on its joint, all included, in the model's sign."""

    tau_nm: Floats
    arrival_ns: int  # of the FT sample behind it


class ImpedanceOffset(Message, frozen=True, kw_only=True):
    """Gravity torque of the model at the measured posture, for the boards' impedance offset."""

    tau_nm: Floats


class JointCommand(Message, frozen=True, kw_only=True):
    """Set-points of one part: the HAL takes the quantity that the mode names."""

    mode: str  # direct | velocity | torque | pwm
    q_rad: Floats = ()
    dq_rad_s: Floats = ()
    tau_nm: Floats = ()
    joints: tuple[str, ...] = ()  # of the part, that the values belong to; empty = all
    duty_percent: Floats = ()  # pwm: of the bridge's full scale, in the board's own sign


class Goal(Message, frozen=True, kw_only=True):
    """Where a hand is to go, in the base frame; orientation as a rotation vector."""

    position_m: Vector3
    rotation_rad: Vector3
    active: bool = True
    limb: str = ""  # right_arm, left_arm or both_arms; empty = the main job's
    position_only: bool = False  # the hand may turn as it likes
    velocity_m_s: Vector3 = (0.0, 0.0, 0.0)  # of the goal itself
    second_position_m: Vector3 | None = None  # of both arms' right hand; None = it is free
    second_rotation_rad: Vector3 | None = None
    second_velocity_m_s: Vector3 = (0.0, 0.0, 0.0)
    follow: str = ""  # name of an object: position and velocity are its centre's


class Obstacle(msgspec.Struct, frozen=True, array_like=True):
    """A ball, in the base frame."""

    centre_m: Vector3
    radius_m: float


class WorldObject(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something near the robot, in the base frame; `docs/fields.md` says what a source may send.

    size_m: sphere: radius; ellipsoid: semi-axes; box: half edges; cylinder: radius and half length
    along its z; mesh: none, the box about `vertices_m`.
    """

    name: str
    shape: str  # sphere | ellipsoid | box | cylinder | mesh
    size_m: Floats
    position_m: Vector3
    rotation_rad: Vector3 = (0.0, 0.0, 0.0)  # of its own axes, as a rotation vector
    velocity_m_s: Vector3 | None = None  # None = to be estimated from the positions
    covariance_m2: Floats | None = None  # of the position: xx, xy, xz, yy, yz, zz; None = exact
    role: str = "obstacle"  # | target: may be followed, and is not avoided
    on: bool = True  # off: listed, and without any effect
    vertices_m: tuple[Vector3, ...] = ()  # of a mesh, in its own axes
    seen_ns: int = 0  # when, on the clock of the message's stamp; 0 = when that was made


class Objects(Message, frozen=True, kw_only=True):
    """What a source sees; it takes the place of all that the source sent before."""

    obstacles: tuple[Obstacle, ...] = ()
    objects: tuple[WorldObject, ...] = ()
    source: str = ""


class VirtualPoint(Message, frozen=True, kw_only=True):
    """The point that the force field drives to the goal; the hand follows it."""

    sequence: int
    position_m: Vector3
    velocity_m_s: Vector3
    rotation_rad: Vector3
    limb: str = ""  # empty = the main job's
    position_only: bool = False  # the orientation does not matter
    second_position_m: Vector3 | None = None  # of the limb's second tip; None = it does not matter
    second_rotation_rad: Vector3 | None = None
    second_velocity_m_s: Vector3 = (0.0, 0.0, 0.0)
    q_rad: Floats = ()  # posture of the limb whose hand the point is; empty = the field keeps none
    dq_rad_s: Floats = ()
    trajectory_time_s: float = 0.0  # of the controller that follows; 0 = the robot file's
    mode: str = ""  # of the field


class IkSolution(Message, frozen=True, kw_only=True):
    """Posture of the chain for one virtual point."""

    sequence: int
    q_rad: Floats
    status: str  # converged | infeasible | out_of_time
    position_error_m: float
    orientation_error_rad: float
    iterations: int
    limb: str = ""
    reason: str = ""  # why the point is not reached
    tip_errors: tuple[tuple[float, float] | None, ...] = ()  # m and rad of each tip that has a pose
    limited: bool = False  # held back by the joint step of one tick
    missed: int = 0  # searches of this stream that used up their budget, so far


class DynamicsStatus(Message, frozen=True, kw_only=True):
    """The estimate for slower readers, and what it stands on."""

    state: str  # waiting | calibrating | running
    samples: int  # of the offset calibration under way
    offset: Floats  # of the FT sensor, N and Nm
    refused: int  # readings that were not finite, or came with joints that were not
    reason: str = ""
    external_force_n: Vector3 = (0.0, 0.0, 0.0)  # on the hand, in the base frame
    external_moment_nm: Vector3 = (0.0, 0.0, 0.0)  # about the hand frame's origin
    tau_nm: Floats = ()  # the newest estimate, whole chain


class CartesianStatus(Message, frozen=True, kw_only=True):
    """The main job's limb as it is measured, and what the Cartesian controller does with its limb.

    Posture and hand pose are of the main job's limb, all else is of the limb in use.
    """

    state: str  # waiting | moving | in_target
    q_rad: Floats  # measured, whole chain; empty while the joints are not valid
    hand_position_m: Vector3  # of the measured posture; NaN while the joints are not valid
    hand_rotation_rad: Vector3
    position_error_m: float = math.nan  # measured hand to the target; of the worst tip
    orientation_error_rad: float = math.nan
    external_force_n: float = 0.0
    gated: bool = False  # correction frozen because something pushes the arm
    plan_position_m: Vector3 = NAN3
    point_position_m: Vector3 = NAN3  # the virtual point that is followed
    ik_status: str = ""
    ik_position_error_m: float = math.nan
    refused: int = 0  # inputs that were not finite, out of order or of the wrong length
    mode: str = "idle"  # idle | field | pose | tracking | velocity | stopping
    limb: str = ""  # in use
    motion: int = 0  # number of the newest one
    progress: float = math.nan  # of it, in joint space
    ignored: int = 0  # virtual points that came while a request commanded
    reason: str = ""  # why nothing is commanded that should be


class ServiceStats(Message, frozen=True, kw_only=True):
    """How one process keeps its time."""

    process: str
    steps: int
    step_ms_p50: float
    step_ms_p99: float
    late_us_p50: float
    late_us_p99: float
    tick_slips: int
    scheduler: str = ""
    errors: int = 0


class FtRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Remove the offset of the named FT sensors: no contact, arm at rest."""

    sensors: tuple[str, ...] = ()
    samples: int = 200


class Reply(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Answer to a request: taken up, or refused with the reason."""

    ok: bool
    reason: str = ""
    task: int = 0  # where the work goes on after the answer: wait for it in finished_task
