"""Names of boards and joints, and physical values, for the frames of one robot.

A robot file tells which board sits at an address of a bus, which joint an axis is, and the factors
of its units; what it does not tell stays a raw number.
"""

from dataclasses import dataclass
from fnmatch import fnmatchcase

from hal.wire import analog, inertial, motor_periodic
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    class_of,
    low_of,
    source_of,
)
from hal.wire.catalogue import FORMS, POLLED_CLASSES, Decoded, decode
from hal.wire.layout import Field, OpenLayout
from services.cli.can_units import AxisScale, physical_text
from services.core.errors import ConfigError
from services.robotfile.robot_tables import RobotFile, VirtualSensorTable

TWO_ADDRESSES = "dc4"


@dataclass(frozen=True)
class NamedFrame:
    """A frame with everything that the robot file says about it."""

    bus: str
    board: str  # the one that sent it or that it is sent to
    joints: tuple[str, ...]  # of the axes that it speaks of
    decoded: Decoded
    address: int
    data: bytes

    @property
    def message(self) -> str:
        """Its name in the frame tables; "unknown" where they have none."""
        return "unknown" if self.decoded.form is None else self.decoded.form.name


class BusNames:
    """Names of everything on one bus of a robot."""

    def __init__(self, robot: RobotFile | None, bus: str) -> None:
        """`bus` is the key of the robot file's [buses]; without a robot nothing has a name."""
        self.bus = bus
        self._boards: dict[int, str] = {}
        self._joints: dict[tuple[int, int], str] = {}
        self._scales: dict[tuple[int, int], AxisScale] = {}
        self._virtual: dict[int, tuple[str, VirtualSensorTable]] = {}
        self._full_scales: dict[int, tuple[float, ...]] = {}
        if robot is not None and bus in robot.buses:
            self._read(robot)

    def _read(self, robot: RobotFile) -> None:
        addresses: dict[str, int] = {}
        for name, board in robot.boards.items():
            if board.bus == self.bus:
                addresses[name] = board.address
                self._boards[board.address] = name
                if board.type == TWO_ADDRESSES:
                    self._boards[board.address + 1] = name
        for name, virtual in robot.virtual_sensors.items():
            if virtual.bus == self.bus:
                self._virtual[virtual.address] = name, virtual
        for name, joint in robot.joints.items():
            if joint.board in addresses:
                place = addresses[joint.board] + joint.axis // 2, joint.axis % 2
                self._joints[place] = name
                self._scales[place] = AxisScale.of(robot, name)
        for sensor in robot.sensors.values():
            if sensor.board in addresses:
                self._full_scales[addresses[sensor.board]] = sensor.full_scale

    def board(self, address: int) -> str:
        """Name of the board at an address, or the address."""
        if address == HOST:
            return "host"
        if address in self._boards:
            return self._boards[address]
        virtual = self._virtual.get(address)
        return f"board {address}" if virtual is None else f"virtual {virtual[0]}"

    def joint(self, address: int, axis: int) -> str:
        """Name of a joint; empty for an axis that turns none."""
        return self._joints.get((address, axis), "")

    def place(self, joint: str) -> tuple[int, int] | None:
        """Address and axis of a joint; None when it is not on this bus."""
        for place, name in self._joints.items():
            if name == joint:
                return place
        return None

    def address(self, board: str) -> int | None:
        """First address of a board; None when it is not on this bus."""
        return min((a for a, name in self._boards.items() if name == board), default=None)

    def name(self, can_id: int, data: bytes) -> NamedFrame:
        """Everything that can be said about a frame."""
        decoded = decode(can_id, data)
        can_class, source, low = class_of(can_id), source_of(can_id), low_of(can_id)
        address = low if can_class in POLLED_CLASSES and source == HOST else source
        board = self.board(address)
        if can_class == CLASS_MANAGEMENT and low == EVERYBODY:
            board = "everybody"
        if can_class in POLLED_CLASSES:
            board = f"to {board}" if source == HOST else board
        joints = self._joints_of(can_class, address, decoded)
        return NamedFrame(self.bus, board, joints, decoded, address, data)

    def text(self, frame: NamedFrame) -> str:
        """Message, joint and values of a frame; its bytes where no table can read it."""
        decoded, address = frame.decoded, frame.address
        form = decoded.form
        if form is None or decoded.cause:
            name = "unknown" if form is None else f"{form.name} of wrong length"
            return f"{name}: {frame.data.hex(' ') or 'empty'}"
        parts = [form.name]
        if decoded.axis is not None:
            parts.append(self.joint(address, decoded.axis) or f"axis {decoded.axis}")
        if isinstance(form.layout, OpenLayout) and form.layout.is_opaque:
            return f"{' '.join(parts)} {bytes(decoded.values).hex(' ')}".rstrip()
        values = [
            self._value(frame, index, field)
            for index, field in enumerate(form.layout.fields[: len(decoded.values)])
        ]
        return f"{' '.join(parts)} {', '.join(values)}".rstrip()

    def _joints_of(self, can_class: int, address: int, decoded: Decoded) -> tuple[str, ...]:
        form, axes = decoded.form, _axes(can_class, decoded)
        if form is not None and form.row in (analog.FORCE, analog.TORQUE):
            virtual = self._virtual.get(address)
            first = 3 if form.row is analog.TORQUE else 0
            return () if virtual is None else virtual[1].channels[first : first + 3]
        names = (self.joint(address, axis) for axis in axes)
        return tuple(name for name in names if name)

    def _value(self, frame: NamedFrame, index: int, field: Field) -> str:
        decoded, address = frame.decoded, frame.address
        value = decoded.values[index]
        text = field.text(value)
        form = decoded.form
        assert form is not None
        if form.can_class == CLASS_ANALOG_PERIODIC and form.row in (analog.FORCE, analog.TORQUE):
            return text + self._channel(address, form.row is analog.TORQUE, index, value)
        axis = decoded.axis
        joint = ""
        if form.can_class == CLASS_MOTOR_PERIODIC and field.name[-1:] in ("0", "1"):
            axis = int(field.name[-1])
            joint = self.joint(address, axis)
        scale = self._scales.get((address, axis)) if axis is not None else None
        physical = physical_text(form, field, value, scale)
        if form.row is inertial.IMU_TRIPLE and index >= 2:
            physical = imu_text(decoded.values[1], value)
        said = " ".join(part for part in (joint, physical) if part)
        return f"{text} ({said})" if said else text

    def _channel(self, address: int, is_second: bool, index: int, word: int) -> str:
        if index > 2:
            return ""
        channel = index + 3 * is_second
        full_scale = self._full_scales.get(address)
        if full_scale is not None:
            unit = "Nm" if is_second else "N"
            return f" ({analog.to_physical(word, full_scale[channel]):.3g} {unit})"
        virtual = self._virtual.get(address)
        if virtual is None or channel >= len(virtual[1].channels):
            return ""
        torque_nm = analog.to_physical(word, virtual[1].full_scale_nm)
        return f" ({virtual[1].channels[channel]} {torque_nm:.3g} Nm)"


def imu_text(sensor: int, value: int) -> str:
    """Physical value of one component of an IMU_TRIPLE."""
    units = {0: "m/s^2", 1: "uT", 2: "deg/s", 3: "deg", 5: "m/s^2", 6: "m/s^2"}
    if sensor not in units:
        return ""
    scale = inertial.COUNTS_PER_UNIT[inertial.ImuKind(sensor)]
    return f"{value / scale:.4g} {units[sensor]}"


def _axes(can_class: int, decoded: Decoded) -> tuple[int, ...]:
    """Axes of the address that a frame speaks of."""
    if can_class == CLASS_MOTOR_POLLING:
        return () if decoded.axis is None else (decoded.axis,)
    if can_class == CLASS_MOTOR_PERIODIC:
        silent = decoded.form is not None and decoded.form.row is motor_periodic.PRINT
        return () if silent else (0, 1)
    return ()


@dataclass(frozen=True)
class Selection:
    """What to show; empty = everything. Boards and messages may have * and ?."""

    boards: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    messages: tuple[str, ...] = ()
    bad_only: bool = False

    def takes(self, frame: NamedFrame) -> bool:
        """Whether a frame is among them."""
        board = frame.board.removeprefix("to ")
        return (
            (not self.boards or _matches(board, self.boards))
            and (not self.joints or bool(set(self.joints) & set(frame.joints)))
            and (not self.messages or _matches(frame.message, self.messages))
            and (not self.bad_only or bool(frame.decoded.cause))
        )


def check_selection(selection: Selection, robot: RobotFile) -> None:
    """Refuse what can never be shown.

    Raises:
        ConfigError: the robot has no such joint or board, or the frame tables no such message.
    """
    for pattern in selection.boards:
        if not any(
            _matches(board, (pattern,)) for board in (*robot.boards, *robot.virtual_sensors)
        ):
            known = ", ".join(robot.boards)
            raise ConfigError(f"{robot.robot.name} has no board {pattern!r}; known: {known}")
    messages = {form.name for form in FORMS} | {"unknown"}
    for pattern in selection.messages:
        if not any(_matches(message, (pattern,)) for message in messages):
            raise ConfigError(
                f"no message {pattern!r}; docs/protocol.md (ulna can docs) lists them"
            )
    for joint in selection.joints:
        if joint not in robot.joints:
            known = ", ".join(robot.joints)
            raise ConfigError(f"{robot.robot.name} has no joint {joint!r}; known: {known}")


def _matches(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name.lower(), pattern.lower()) for pattern in patterns)
