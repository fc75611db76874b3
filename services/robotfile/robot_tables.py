"""The schema of a robot file, one class per table. Units are in the keys; angles are degrees."""

from pathlib import Path
from typing import Literal

import msgspec

from hal.description import Calibration, Impedance, PositionPid, TorquePid
from services.robotfile.limbs import Limb, LimbPart, LimbTip, with_both_arms

BoardTypeName = Literal["bll", "bll_ie", "bll_dc", "dc4", "strain", "strain2", "mais", "mtb", "imu"]


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
    simulated: bool = True  # boards on it that do not say otherwise are emulated here


class BoardTable(Strict, frozen=True, kw_only=True):
    """Table [boards.<name>]."""

    bus: str
    address: int
    type: BoardTypeName
    firmware: str
    # Position, status, overflow, prints as on robots. DELIBERATE: velocity too, which they lack.
    broadcast: int = 0x75
    part: str = ""  # or a group of its own that a board without motors belongs to
    frame: str = ""  # URDF link that an inertial sensor sits on
    period_ms: int = 0  # of what a sensor board sends; 0 = the type's own
    required: bool = True  # False: the robot starts without it
    coupled: bool = True  # False: its motors turn one joint each, in firmware and plant
    faithful: bool = True  # False: emulated without the quirks of the real firmware
    simulated: bool | None = None  # None: as its bus


class SiteBusTable(Strict, frozen=True, kw_only=True):
    """[buses.<name>] of a site file: one line says where the bus is and whether it is real."""

    channel: str = ""
    simulated: bool


class SiteStartTable(Strict, frozen=True, kw_only=True):
    """[start] of a site file: what the robot may do without."""

    allow_missing: bool  # start with the boards that answer, as if none were required


class SiteBoardTable(Strict, frozen=True, kw_only=True):
    """[boards.<name>] of a site file: a board that is not as its bus."""

    simulated: bool


class SiteSensorTable(Strict, frozen=True, kw_only=True):
    """[sensors.<name>] of a site file: what `ulna dynamics identify` found of this very sensor."""

    gain: tuple[float, ...]


class SensorTable(Strict, frozen=True, kw_only=True):
    """[sensors.<name>]: an FT sensor."""

    frame: str
    board: str
    behind: str = ""  # joint behind which the frame is put, where the model has none
    contact_frame: str = ""  # where what touches the limb beyond is assumed; empty = the frame
    contact_on_n: float = 4.0  # a contact begins: above what weight and motion are uncertain by
    contact_off_n: float = 2.5  # and ends
    contact_learned_on_n: float = 2.5  # it begins at best, where a learner takes off what is not
    full_scale: tuple[float, float, float, float, float, float]
    gain: tuple[float, ...] = ()  # what a reading is multiplied with, 36 numbers by rows; () = one


class VirtualSensorTable(Strict, frozen=True, kw_only=True):
    """[virtual_sensors.<name>]: joint torques that the host broadcasts."""

    bus: str
    address: int
    full_scale_nm: float
    channels: tuple[str, ...]


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


class FingerTable(Strict, frozen=True, kw_only=True):
    """One finger joint that a hand motor's tendon pulls; `hall` are its channels on the MAIS."""

    name: str
    range_deg: tuple[float, float]
    hall: tuple[int, ...]


class JointTable(Strict, frozen=True, kw_only=True):
    """Table [joints.<name>]: the URDF's name for a joint of the model.

    mechanism: body = a joint of the model; single = it turns an inertia of its own; tendon = it
    pulls the `fingers`.
    """

    board: str
    axis: int
    ticks_per_deg: float
    zero_deg: float
    limits_deg: tuple[float, float]
    limit_margin_deg: float
    hard_stops_deg: tuple[float, float]
    power_up_deg: float
    park_deg: float  # where it is brought to before it is switched off
    max_velocity_deg_s: float
    motor: str
    motor_polarity: Literal[1, -1]
    encoder: Literal["absolute", "incremental", "hall"]
    current_limit_ma: int
    pwm_limit: int
    position_pid: PositionPid
    calibration: Calibration
    torque_pid: TorquePid | None = None
    impedance: Impedance | None = None
    mechanism: Literal["body", "single", "tendon"] = "body"
    inertia_kg_m2: float = 0.0
    fingers: tuple[FingerTable, ...] = ()


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


class LimbTable(Strict, frozen=True, kw_only=True):
    """[limbs.<name>]: a chain of parts, base to tip, and the postures that it prefers."""

    tip_frame: str
    parts: tuple[str, ...]
    sensor: str
    compliant: tuple[str, ...]
    home_deg: tuple[float, ...]
    rest_deg: tuple[float, ...]
    rest_weights: tuple[float, ...]
    rest_beta: float
    trajectory_time_s: float


class ReachTable(Strict, frozen=True, kw_only=True):
    """[reach]: what the main job moves."""

    limb: str


class RobotFile(msgspec.Struct, frozen=True, kw_only=True):
    """A robot file that has passed every check."""

    path: Path
    robot: RobotTable
    buses: dict[str, BusTable]
    boards: dict[str, BoardTable]
    sensors: dict[str, SensorTable]
    virtual_sensors: dict[str, VirtualSensorTable]
    motors: dict[str, MotorTable]
    joints: dict[str, JointTable]
    parts: dict[str, tuple[str, ...]]
    selections: dict[str, tuple[str, ...]]
    rates: dict[str, RateTable]
    host: HostTable
    limb_tables: dict[str, LimbTable]
    main_job: ReachTable
    rows: tuple[RowTable, ...]
    allow_missing: bool = False  # the site's word: start with the boards that answer

    @property
    def reach(self) -> LimbTable:
        """The limb of the main job, whether or not its parts are in use."""
        return self.limb_tables[self.main_job.limb]

    @property
    def chain(self) -> tuple[str, ...]:
        """Joints of the main job's limb, base to tip: the order of its chain vectors."""
        return tuple(joint for part in self.reach.parts for joint in self.parts[part])

    @property
    def limbs(self) -> dict[str, Limb]:
        """The limbs whose parts are all in use, and both arms as one where there are both."""
        return with_both_arms(
            {
                name: self._limb(name, table)
                for name, table in self.limb_tables.items()
                if set(table.parts) <= set(self.parts)
            }
        )

    @property
    def groups(self) -> tuple[str, ...]:
        """Parts, and what boards without motors say that they belong to."""
        named = dict.fromkeys(board.part for board in self.boards.values() if board.part)
        return tuple(dict.fromkeys((*self.parts, *named)))

    @property
    def can_reach(self) -> bool:
        """Whether every part of the main job's limb is among the parts in use."""
        return set(self.reach.parts) <= set(self.parts)

    def is_simulated(self, board: str) -> bool:
        """Whether a board is emulated by this stack; else it is on its bus by itself."""
        table = self.boards[board]
        return self.buses[table.bus].simulated if table.simulated is None else table.simulated

    def axis_place(self, joint: str) -> tuple[int, int, int]:
        """Bus number, address and axis (0 or 1) of a joint."""
        table = self.joints[joint]
        board = self.boards[table.board]
        number = self.buses[board.bus].number
        return number, board.address + table.axis // 2, table.axis % 2

    def _limb(self, name: str, table: LimbTable) -> Limb:
        parts, start = {}, 0
        for part in table.parts:
            end = start + len(self.parts[part])
            parts[part] = LimbPart(
                home_deg=table.home_deg[start:end],
                rest_deg=table.rest_deg[start:end],
                rest_weights=table.rest_weights[start:end],
            )
            start = end
        return Limb(
            name=name,
            tips=(LimbTip(limb=name, frame=table.tip_frame, sensor=table.sensor),),
            parts=parts,
            compliant=table.compliant,
            rest_beta=table.rest_beta,
            trajectory_time_s=table.trajectory_time_s,
        )
