"""The schema of a robot file, one class per table. Units are in the keys; angles are degrees."""

from pathlib import Path
from typing import Literal

import msgspec

from hal.description import Calibration, Impedance, PositionPid, TorquePid


class Strict(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table of the file: an unknown key is an error."""


class RobotTable(Strict, frozen=True, kw_only=True):
    """Table [robot]."""

    name: str
    urdf: str
    base_frame: str


class BusTable(Strict, frozen=True, kw_only=True):
    """Table [buses.<name>]."""

    number: int
    channel: str


class BoardTable(Strict, frozen=True, kw_only=True):
    """Table [boards.<name>]."""

    bus: str
    address: int
    type: Literal["bll_ie", "dc4", "strain"]
    firmware: str
    broadcast: int = 0x75  # position, status, overflow, prints, velocity


class SensorTable(Strict, frozen=True, kw_only=True):
    """[sensors.<name>]: an FT sensor."""

    frame: str
    board: str
    full_scale: tuple[float, float, float, float, float, float]


class VirtualSensorTable(Strict, frozen=True, kw_only=True):
    """[virtual_sensors.<name>]: joint torques that the host broadcasts."""

    bus: str
    address: int
    full_scale_nm: float
    channels: tuple[str, ...]


class CouplingTable(Strict, frozen=True, kw_only=True):
    """[couplings.<name>]: how the motors of a board turn its joints."""

    board: str
    kind: Literal["identity"]


class Sourced(Strict, frozen=True, kw_only=True):
    """A value and where it comes from."""

    value: float
    source: str


class MotorTable(Strict, frozen=True, kw_only=True):
    """Table [motors.<name>]."""

    supply_v: Sourced
    torque_constant_nm_a: Sourced
    resistance_ohm: Sourced
    gear: Sourced
    rotor_inertia_kg_m2: Sourced
    coulomb_nm: Sourced
    viscous_nms_rad: Sourced


class JointTable(Strict, frozen=True, kw_only=True):
    """Table [joints.<URDF joint>]."""

    board: str
    axis: int
    ticks_per_deg: float
    zero_deg: float
    limits_deg: tuple[float, float]
    limit_margin_deg: float
    hard_stops_deg: tuple[float, float]
    power_up_deg: float
    max_velocity_deg_s: float
    motor: str
    motor_polarity: Literal[1, -1]
    encoder: Literal["absolute", "incremental"]
    current_limit_ma: int
    pwm_limit: int
    position_pid: PositionPid
    calibration: Calibration
    torque_pid: TorquePid | None = None
    impedance: Impedance | None = None


class RowTable(Strict, frozen=True, kw_only=True):
    """[[rows]]: lower <= sum(coefficient * angle) <= upper, degrees."""

    name: str
    coefficients: dict[str, float]
    lower_deg: float = float("-inf")
    upper_deg: float = float("inf")


class RateTable(Strict, frozen=True, kw_only=True):
    """Table [rates.<stream>]."""

    virtual_hz: int
    live_hz: int


class HostTable(Strict, frozen=True, kw_only=True):
    """[host]: scales and time-outs that the host sets on every board."""

    velocity_shift: int
    speed_estimate_shift: int
    velocity_timeout_ms: int


class ReachTable(Strict, frozen=True, kw_only=True):
    """[reach]: the chain that reaching moves and the postures it starts from and prefers."""

    tip_frame: str
    parts: tuple[str, ...]
    sensor: str
    compliant: tuple[str, ...]
    home_deg: tuple[float, ...]
    park_deg: tuple[float, ...]
    rest_deg: tuple[float, ...]
    rest_weights: tuple[float, ...]
    rest_beta: float
    trajectory_time_s: float


class RobotFile(msgspec.Struct, frozen=True, kw_only=True):
    """A robot file that has passed every check."""

    path: Path
    robot: RobotTable
    buses: dict[str, BusTable]
    boards: dict[str, BoardTable]
    sensors: dict[str, SensorTable]
    virtual_sensors: dict[str, VirtualSensorTable]
    couplings: dict[str, CouplingTable]
    motors: dict[str, MotorTable]
    joints: dict[str, JointTable]
    parts: dict[str, tuple[str, ...]]
    rates: dict[str, RateTable]
    host: HostTable
    reach: ReachTable
    rows: tuple[RowTable, ...]

    @property
    def chain(self) -> tuple[str, ...]:
        """Joints of the reaching chain, base to tip: the order of every chain vector."""
        return tuple(joint for part in self.reach.parts for joint in self.parts[part])
