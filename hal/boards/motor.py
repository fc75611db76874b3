"""Host side of the DSP motor boards: their broadcasts, replies, handshake and configuration."""

from collections.abc import Generator, Iterable

from hal.axis import Axis
from hal.boards.board import Parts, Pulse, ask, board_name, refusal, sent
from hal.boards.settings import address_settings, axis_settings
from hal.boards.status import StatusReader
from hal.boards.verify import verify
from hal.line import Handler, Trace
from hal.tasks import Sequence
from hal.wire import motor, motor_periodic
from hal.wire.can import CLASS_MOTOR_PERIODIC, CLASS_MOTOR_POLLING, HOST, Frame, frame_id
from hal.wire.modes import ControlMode, InteractionMode, reported_mode
from hal.wire.texts import PrintReader

AXES_PER_ADDRESS = 2
UNUSED = (
    2,
    4,
    5,
    8,
    9,
    10,
    11,
)  # broadcasts that are not read: taken, so that they do not count as unexpected
# A single BLL axis prints this when calibration switches it on, and goes on (can-protocol 10.2).
UNCALIBRATED = "calib failed, axis"
IMPLAUSIBLE = "POSITION that no joint gets to in its time"


class MotorBoard:
    """A board of two axes per address; subclasses say which type they are.

    Attributes:
        type_code: what the board reports in the handshake.
        addresses: how many consecutive addresses it owns.
        full_pwm: PWM count of a bridge that is always on.
        max_current_ma: largest current limit that the board accepts.
    """

    type_code: int
    addresses: int
    full_pwm: int
    max_current_ma: int

    def __init__(self, parts: Parts) -> None:
        self.board = parts.board
        self.line = parts.line
        self.axes = parts.axes
        self.trace = Trace(maxlen=8)
        self._faults = parts.faults
        self._parts = parts
        self._version: dict[int, tuple[int, ...]] = {}
        self._prints = PrintReader()
        first = parts.board.address
        self._pairs = tuple(
            AddressPair(self, address, parts) for address in range(first, first + self.addresses)
        )
        self.pulses: tuple[Pulse, ...] = tuple(pair.pulse for pair in self._pairs if any(pair.axes))

    @classmethod
    def velocity_count(cls, speed_estimate_shift: int) -> float:
        """What one count of a VELOCITY frame is, in ticks/ms."""
        raise NotImplementedError

    def listen(self) -> None:
        """Attach the handlers of every address."""
        for pair in self._pairs:
            for can_id, handler in pair.handlers():
                self.line.attach(can_id, handler, self.trace)

    def quiesce(self) -> Iterable[Frame]:
        """Mask 0 of the first address silences the whole board."""
        return [motor.SET_BCAST_POLICY.request(self.board.address, 0, 0)]

    def handshake(self) -> Sequence:
        """Protocol 1.6; without it the board never switches its bridges on."""
        address, code = self.board.address, motor.GET_FIRMWARE_VERSION.code
        self._version.clear()
        question = motor.GET_FIRMWARE_VERSION.request(address, 0, *motor.HOST_PROTOCOL)
        version = yield from ask(self.line, address, question, self._version, code)
        return refusal(self.board, self.type_code, version, motor.HOST_PROTOCOL)

    def write_settings(self, axis: int | None) -> None:
        """Queue settings; the masks go with every axis, because they belong to its address."""
        for pair in self._pairs:
            chosen = [a for a in pair.axes if a is not None and axis in (None, a.index)]
            for one in chosen:
                self._write_axis(one)
            if chosen or axis is None:
                self._write_address(pair.address)

    def _write_axis(self, axis: Axis) -> None:
        for row, values in axis_settings(axis, self._parts.description):
            axis.command(row, *values)

    def _write_address(self, address: int) -> None:
        for frame in address_settings(self.board, address):
            self.line.command(address, frame)

    def configure(self) -> Sequence:
        """All axes stiff, settings, all axes idle, then what the board knows of them.

        Stiff first: an axis that a previous host left compliant has no torques now and would fault.
        """
        for axis in self.axes:
            axis.command(motor.SET_INTERACTION_MODE, InteractionMode.STIFF)
        for axis in self.axes:
            self._write_axis(axis)
        yield from self._sent()
        reason = yield from self._verify()
        if reason:
            return f"{board_name(self.board)} does not keep its settings: {reason}"
        for pair in self._pairs:
            self._write_address(pair.address)
        for axis in self.axes:
            axis.wanted_mode = ControlMode.IDLE
            axis.command(motor.SET_CONTROL_MODE, ControlMode.FORCE_IDLE)
        yield from self._sent()
        reason = yield from self.read_back()
        return reason

    def _sent(self) -> Generator[None, None, None]:
        for pair in self._pairs:
            yield from sent(self.line, pair.address)

    def _verify(self) -> Sequence:
        """One axis after the other: both addresses of a board answer through one buffer."""
        reasons: list[str] = []
        for axis in self.axes:
            reason = yield from verify(axis, axis_settings(axis, self._parts.description))
            if reason:
                reasons.append(reason)
        return "; ".join(reasons)

    def read_back(self) -> Sequence:
        """Ask whether each axis is calibrated, and its modes."""
        for axis in self.axes:
            reason = yield from self._read_back_axis(axis)
            if reason:
                return f"{board_name(self.board)}: {reason}"
        return ""

    def _read_back_axis(self, axis: Axis) -> Sequence:
        question = motor.GET_CALIBRATION_STATUS
        axis.replies.clear()
        frame = question.request(axis.address, axis.number)
        answer = yield from ask(self.line, axis.address, frame, axis.replies, question.code)
        if answer is None:
            return f"{axis.name} does not answer"
        return ""

    def on_version(self, values: tuple[int, ...]) -> None:
        """The answer to the handshake."""
        self._version[motor.GET_FIRMWARE_VERSION.code] = values

    def on_print(self, data: bytes, stamp_ns: int) -> None:
        """A piece of a text that the board prints, reported when complete."""
        text = self._prints.add(data)
        if text is not None:
            if text.startswith(UNCALIBRATED) and any(axis.calibrating for axis in self.axes):
                return
            for axis in self.axes:
                axis.said, axis.said_ns = text, stamp_ns
            self._faults.report(stamp_ns, f"{board_name(self.board)} says: {text}", text)


class AddressPair:
    """The two axes behind one address; None where the robot uses no axis."""

    __slots__ = ("_board", "_faults", "_first", "_second", "_status", "address", "axes", "pulse")

    def __init__(self, board: MotorBoard, address: int, parts: Parts) -> None:
        self.address = address
        self.axes: list[Axis | None] = [None] * AXES_PER_ADDRESS
        for axis in parts.axes:
            if axis.address == address:
                self.axes[axis.number] = axis
        self._first, self._second = self.axes
        self.pulse = Pulse(address, "POSITION")
        self._board = board
        self._faults = parts.faults
        self._status = StatusReader(parts, self.axes, board.trace)

    def handlers(self) -> list[tuple[int, Handler]]:
        """Identifiers that this address sends with, and who reads them."""
        periodic: dict[int, Handler] = {
            motor_periodic.POSITION.type: self.on_position,
            motor_periodic.VELOCITY.type: self.on_velocity,
            motor_periodic.STATUS.type: self._status.on_status,
            motor_periodic.ADDITIONAL_STATUS.type: self.on_additional_status,
            motor_periodic.PRINT.type: self._board.on_print,
            **dict.fromkeys(UNUSED, _ignore),
        }
        table = [
            (frame_id(CLASS_MOTOR_PERIODIC, self.address, kind), handler)
            for kind, handler in periodic.items()
        ]
        reply_id = frame_id(CLASS_MOTOR_POLLING, self.address, HOST)
        return [*table, (reply_id, self.on_reply)]

    def on_position(self, data: bytes, stamp_ns: int) -> None:
        """POSITION: one tick count per axis, each 4 or 5 ms."""
        values = motor_periodic.POSITION.parse(data)
        if values is None:
            self._faults.drop("POSITION of wrong length")
            return
        self.pulse.heard_ns = stamp_ns
        if self._first is not None and not self._first.on_position(values[0], stamp_ns):
            self._faults.drop(IMPLAUSIBLE)
        if self._second is not None and not self._second.on_position(values[1], stamp_ns):
            self._faults.drop(IMPLAUSIBLE)

    def on_velocity(self, data: bytes, stamp_ns: int) -> None:  # noqa: ARG002  (a handler)
        """VELOCITY: the accelerations are never updated by the firmware."""
        values = motor_periodic.VELOCITY.parse(data)
        if values is None:
            self._faults.drop("VELOCITY of wrong length")
            return
        if self._first is not None:
            self._first.on_velocity(values[0])
        if self._second is not None:
            self._second.on_velocity(values[1])

    def on_additional_status(self, data: bytes, stamp_ns: int) -> None:  # noqa: ARG002  (a handler)
        """ADDITIONAL_STATUS: interaction modes, when one has changed and each 5 s."""
        values = motor_periodic.ADDITIONAL_STATUS.parse(data)
        if values is None:
            self._faults.drop("ADDITIONAL_STATUS of wrong length")
            return
        for axis, interaction in zip(self.axes, values, strict=True):
            if axis is not None:
                axis.on_interaction(interaction)

    def on_reply(self, data: bytes, stamp_ns: int) -> None:
        """An answer to a GET of this host (or of another one: it is as true)."""
        command = motor.command_of(data)
        values = None if command is None else command.parse_reply(data)
        if command is None or values is None:
            self._faults.drop("undecodable reply of a motor board")
            return
        if command is motor.GET_FIRMWARE_VERSION:
            self._board.on_version(values)
            return
        axis = self.axes[motor.axis_of(data)]
        if axis is None:
            self._faults.drop("reply about an axis that the robot does not use")
            return
        axis.replies[command.code] = values
        if command is motor.GET_CONTROL_MODE:
            self._status.on_mode(axis, values[0], stamp_ns)
        elif command is motor.GET_INTERACTION_MODE:
            axis.on_interaction(values[0])
        elif command is motor.GET_CALIBRATION_STATUS:
            axis.set_calibrated(values[0] != 0)
            self._status.on_mode(axis, reported_mode(values[1]), stamp_ns)
            axis.on_interaction(values[2])


def _ignore(data: bytes, stamp_ns: int) -> None:
    """A broadcast that the HAL has no use for."""
