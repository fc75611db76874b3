"""A robot description turned into lines, boards, axes and sensors, wired together."""

from collections.abc import Mapping

from hal.axis import Axis
from hal.boards.board import HostBoard, Parts, Sensor
from hal.buses.bus import FrameBus
from hal.checks import check_boards, check_joints, check_settings, owner_of
from hal.couplings import coupled_axes
from hal.description import Board, Joint, RobotDescription
from hal.errors import DescriptionError
from hal.faults import FaultLog
from hal.inventory import Inventory
from hal.line import Line
from hal.readings import JointReadings
from hal.registry import board_type, motor_board_type
from hal.stalls import Stalls
from hal.suspects import suspect_boards, suspect_torques
from hal.torques import VirtualSensor
from hal.wire.motor_periodic import VELOCITY

SENSOR_KINDS = {
    "strain": ("force_torque",),
    "strain2": ("force_torque",),
    "mais": ("hall",),
    "mtb": ("skin",),
    "imu": ("imu",),
}


class Machine:
    """Everything that the parts of the HAL share; it does nothing by itself."""

    def __init__(self, description: RobotDescription, buses: Mapping[int, FrameBus]) -> None:
        """`buses` by bus number.

        Raises:
            DescriptionError: it is incomplete, ambiguous or not encodable.
        """
        self.description = description
        self.faults = FaultLog()
        self.stalls = Stalls()
        self.readings = JointReadings(tuple(joint.name for joint in description.joints))
        self.now_ns = 0
        check_boards(description, buses)
        check_joints(description)
        used = sorted({board.bus for board in description.boards})
        self.lines = {number: Line(number, buses[number], self.faults) for number in used}
        owners = [owner_of(description, joint) for joint in description.joints]
        self.axes = tuple(
            self._axis(i, joint, owners[i]) for i, joint in enumerate(description.joints)
        )
        check_settings(description, self.axes)
        self.boards = tuple(
            self._board(board, tuple(a for a in self.axes if owners[a.index] is board))
            for board in description.boards
        )
        self.sensors: dict[str, Sensor] = {
            board.name: board for board in self.boards if isinstance(board, Sensor)
        }
        self.virtual_sensors = self._virtual_sensors()
        for host_board in self.boards:
            self._join(host_board)
        suspect_boards(self.boards)
        suspect_torques(self.virtual_sensors)
        self.inventory = Inventory(self.boards, self.faults)

    def _axis(self, index: int, joint: Joint, board: Board) -> Axis:
        description = self.description
        kind = motor_board_type(board.type)
        count: float | None = None
        if board.broadcast[joint.address - board.address] & VELOCITY.mask_bit:
            count = kind.velocity_count(description.speed_estimate_shift)
        line = self.lines[joint.bus]
        shift, full_pwm = description.velocity_shift, kind.full_pwm
        return Axis(index, joint, line, self.readings, shift, count, full_pwm)

    def _board(self, board: Board, axes: tuple[Axis, ...]) -> HostBoard:
        places = [
            s for s in self.description.sensors if (s.bus, s.address) == (board.bus, board.address)
        ]
        parts = Parts(
            board=board,
            line=self.lines[board.bus],
            axes=axes,
            faults=self.faults,
            description=self.description,
            sensor=places[0] if places else None,
        )
        return board_type(board.type)(parts)

    def _join(self, board: HostBoard) -> None:
        """Let a board hear its bus, and its axes know which others move with them."""
        board.listen()
        first = board.board.address
        for address in range(first, first + board.addresses):
            board.line.share(address, first)
        coupled = coupled_axes(board.board, board.axes)
        for axis in coupled:
            axis.partners = tuple(other for other in coupled if other is not axis)

    def _virtual_sensors(self) -> tuple[VirtualSensor, ...]:
        sources: dict[tuple[int, int], list[Axis]] = {}
        for axis in self.axes:
            if axis.joint.torque_source is not None:
                key = (axis.joint.bus, axis.joint.torque_source.address)
                sources.setdefault(key, []).append(axis)
        return tuple(
            VirtualSensor(self.lines[bus], address, axes, self.faults, self.stalls)
            for (bus, address), axes in sources.items()
        )

    def torques_of(self, axis: Axis) -> VirtualSensor | None:
        """The virtual sensor that an axis takes its torque from."""
        for sensor in self.virtual_sensors:
            if axis in sensor.axes:
                return sensor
        return None

    def sensors_by_kind(self) -> dict[str, tuple[str, ...]]:
        """Names of the sensors that measure each kind of thing."""
        kinds: dict[str, tuple[str, ...]] = {}
        for name, sensor in self.sensors.items():
            measured = list(SENSOR_KINDS.get(sensor.board.type, ()))
            if sensor.board.type == "mtb" and sensor.board.frame:
                measured.append("inertial")
            for kind in measured:
                kinds[kind] = (*kinds.get(kind, ()), name)
        return kinds

    def indices(self, names: tuple[str, ...]) -> tuple[int, ...]:
        """Places of joints by name, all of them when no name is given.

        Raises:
            DescriptionError: unknown name; the known ones are listed.
        """
        known = self.readings.names
        if not names:
            return tuple(range(len(known)))
        for name in names:
            if name not in known:
                raise DescriptionError(f"unknown joint {name!r}; known: {', '.join(known)}")
        return tuple(known.index(name) for name in names)

    def receive(self, now_ns: int) -> None:
        """Take and decode what every bus has."""
        self.now_ns = now_ns
        for line in self.lines.values():
            line.receive(now_ns)

    def flush(self) -> None:
        """Send what is due on every bus."""
        for line in self.lines.values():
            line.flush()
