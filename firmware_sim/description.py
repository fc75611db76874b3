"""What the emulated robot is made of: boards, axes with motors, sensors, and plant errors.

Plain values handed in by whoever builds a rig; firmware_sim reads no file.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True, slots=True)
class MotorSpec:
    """A brushed drive: motor side values and the gear, as in the robot file's [motors.*]."""

    supply_v: float
    torque_constant_nm_a: float
    resistance_ohm: float
    gear: float
    rotor_inertia_kg_m2: float
    coulomb_nm: float  # joint side
    viscous_nms_rad: float  # joint side


@dataclass(frozen=True, kw_only=True, slots=True)
class FingerSpec:
    """One finger joint that a hand motor's tendon pulls, in the order of the tendon."""

    name: str
    range_deg: tuple[float, float]  # hard stops; the spring opens it towards the first
    hall: tuple[int, ...] = ()  # MAIS channels whose Hall sensors see it; same bus as the motor
    spring_nm_rad: float = 0.02  # assumed


@dataclass(frozen=True, kw_only=True, slots=True)
class AxisSpec:
    """One motor axis: where it is wired and what it turns."""

    bus: int
    address: int
    axis: int
    joint: str | None  # URDF joint; None for an axis that drives nothing in this plant
    motor: MotorSpec | None
    pwm_polarity: int = 1  # +1 when positive PWM turns the joint in its positive sense
    ticks_per_deg: float = 0.0
    zero_deg: float = 0.0
    absolute_offset: int | None = (
        None  # ticks; the encoder's true zero crossing, None = incremental
    )
    hard_stop_deg: tuple[float, float] = (-1e9, 1e9)
    limit_deg: tuple[float, float] = (-1e9, 1e9)  # the limits that `limit_violations` is counted on
    start_deg: float = 0.0  # posture at power-up
    # What it turns. body: a joint of the URDF. single: a joint outside the URDF with an inertia of
    # its own (eyes, finger abduction). tendon: several finger joints, each with hard stops.
    mechanism: Literal["body", "single", "tendon"] = "body"
    inertia_kg_m2: float = 0.0  # single: what turns, joint side, rotor apart
    fingers: tuple[FingerSpec, ...] = ()  # tendon: what it pulls
    motor_ticks_per_deg: float = 3.0  # tendon: its motor's encoder, per degree wound; assumed
    driven: bool = False  # its board runs elsewhere: POSITION frames say where the joint is


@dataclass(frozen=True, kw_only=True, slots=True)
class BoardSpec:
    """One emulated board."""

    bus: int
    address: int
    type: str  # bll, bll_ie, bll_dc, dc4, strain, strain2, mais, mtb, imu
    firmware: tuple[int, int]  # as on the wire: 2.57 is (0x02, 0x57)
    name: str = ""
    faithful: bool = True  # quirks of the real firmware; False = the strict reading of the protocol
    coupled: bool = True  # DELIBERATE: False turns the couplings of motors and joints into identity
    frame: str = ""  # URDF frame that an inertial sensor (mtb, imu) sits in; empty = none


@dataclass(frozen=True, kw_only=True, slots=True)
class SensorSpec:
    """One emulated FT sensor: the URDF frame it sits at and the STRAIN board that reads it."""

    name: str
    frame: str
    bus: int
    address: int
    full_scale: tuple[float, float, float, float, float, float]  # N, N, N, Nm, Nm, Nm
    noise: tuple[float, float] = (0.05, 0.002)  # standard deviation, N and Nm
    offset: tuple[float, float] = (2.0, 0.1)  # bound of the constant error drawn from the seed


@dataclass(frozen=True, kw_only=True, slots=True)
class PlantSpec:
    """The physics behind the boards.

    Its inertias are drawn around the model's, never equal to them.
    """

    urdf: str  # path
    tip_frame: str
    seed: int
    mass_error: float = 0.05  # relative bound of each body's mass
    com_error_m: float = 0.005  # distance that each centre of mass is moved


@dataclass(frozen=True, kw_only=True, slots=True)
class RigSpec:
    """Boards, axes, sensors and physics of one emulated robot."""

    boards: tuple[BoardSpec, ...]
    axes: tuple[AxisSpec, ...]
    sensors: tuple[SensorSpec, ...]
    plant: PlantSpec
