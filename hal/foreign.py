"""Another host on the bus: frames that only the host may send, and that are not ours.

No bus hands us our own frames, so every frame from address 0 and every frame of our virtual torque
sensors is foreign. They are counted and reported once per second, and the settings that they may
have changed are written again.
"""

from functools import partial

from hal.line import Line, Trace
from hal.machine import Machine
from hal.setpoints import Setpoints
from hal.wire import analog
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    class_of,
    frame_id,
    low_of,
)
from hal.wire.frames import describe
from hal.wire.message import PolledMessage
from hal.wire.motor import (
    CALIBRATE_ENCODER,
    GET_CONTROL_MODE,
    GET_FIRMWARE_VERSION,
    GET_INTERACTION_MODE,
    HOST_PROTOCOL,
    SET_ENCODER_POSITION,
    SET_OFFSET_ABS_ENCODER,
    axis_of,
    command_of,
)

SETTLE_NS = 20_000_000  # an intruder usually sends several settings in a row
AGAIN_NS = 1_000_000_000  # never fight faster than this
REPORT_NS = 1_000_000_000
MOVES_ZERO = (CALIBRATE_ENCODER, SET_ENCODER_POSITION, SET_OFFSET_ABS_ENCODER)

Place = tuple[str, int | None]  # board, axis in the robot (None = the whole board)


class ForeignHost:
    """Listens for other hosts on every bus of a machine."""

    def __init__(self, machine: Machine, setpoints: tuple[Setpoints, ...]) -> None:
        self.count = 0
        self._machine = machine
        self._setpoints = setpoints
        self._trace = Trace(maxlen=1)
        self._reported = 0
        self._report_ns = 0
        self._example = ""
        self._spoilt: dict[Place, int] = {}  # when each may be written again
        self._written_ns: dict[Place, int] = {}
        for line in machine.lines.values():
            for can_class in (CLASS_MOTOR_POLLING, CLASS_ANALOG_POLLING, CLASS_MANAGEMENT):
                for destination in range(EVERYBODY + 1):
                    self._attach(line, frame_id(can_class, HOST, destination))
        for sensor in machine.virtual_sensors:
            for message in (analog.FORCE, analog.TORQUE):
                self._attach(
                    sensor.line, frame_id(CLASS_ANALOG_PERIODIC, sensor.address, message.type)
                )

    def _attach(self, line: Line, can_id: int) -> None:
        line.attach(can_id, partial(self._on_frame, line, can_id), self._trace)

    def _on_frame(self, line: Line, can_id: int, data: bytes, stamp_ns: int) -> None:
        self.count += 1
        self._example = f"bus {line.number}: {describe(can_id, data)}"
        if _only_asks(can_id, data):
            return
        if class_of(can_id) == CLASS_MOTOR_POLLING and command_of(data) in MOVES_ZERO:
            self._lose_zero(line, can_id, data, stamp_ns)
        for place in self._places(line, can_id, data):
            earliest_ns = self._written_ns.get(place, stamp_ns - AGAIN_NS) + AGAIN_NS
            self._spoilt.setdefault(place, max(stamp_ns + SETTLE_NS, earliest_ns))

    def _lose_zero(self, line: Line, can_id: int, data: bytes, stamp_ns: int) -> None:
        """The axis is no longer where it says: nothing that the host could write undoes that."""
        touched = (line, low_of(can_id), axis_of(data))
        for axis in self._machine.axes:
            if (axis.line, axis.address, axis.number) == touched:
                axis.set_calibrated(False)
                text = f"{axis.name}: another host has moved its encoder's zero, calibrate it again"
                self._machine.faults.report(stamp_ns, text, text)

    def _places(self, line: Line, can_id: int, data: bytes) -> list[Place]:
        """What a foreign frame may have changed."""
        can_class, destination = class_of(can_id), low_of(can_id)
        places: list[Place] = []
        for board in self._machine.boards:
            if board.line is not line:
                continue
            name = board.board.name
            if can_class == CLASS_MANAGEMENT and destination in (board.board.address, EVERYBODY):
                places.append((name, None))  # discovery: masks at zero, bridges off, stream stopped
            elif can_class == CLASS_ANALOG_POLLING and destination == board.board.address:
                places.append((name, None))
            elif can_class == CLASS_MOTOR_POLLING and data and board.axes:
                touched = (destination, axis_of(data))
                axes = [a.index for a in board.axes if (a.address, a.number) == touched]
                places += [(name, axis) for axis in axes]
                # The masks belong to the address, so a command for an unused axis may change them.
                if not axes and 0 <= destination - board.board.address < board.addresses:
                    places.append((name, None))
        return places

    def step(self, now_ns: int) -> None:
        """Report and write again what is due."""
        if self.count != self._reported and now_ns >= self._report_ns:
            new = self.count - self._reported
            self._reported = self.count
            self._report_ns = now_ns + REPORT_NS
            text = f"foreign host: {new} frames, the last on {self._example}"
            self._machine.faults.report(now_ns, text)
        if self._spoilt:
            for place in [place for place, due_ns in self._spoilt.items() if now_ns >= due_ns]:
                del self._spoilt[place]
                self._written_ns[place] = now_ns
                self._write(place)

    def _write(self, place: Place) -> None:
        name, axis = place
        for board in self._machine.boards:
            if board.board.name == name:
                board.write_settings(axis)
                for one in board.axes:
                    if axis in (None, one.index):
                        self._setpoints[one.index].write_again()
                        one.command(GET_CONTROL_MODE)
                        one.command(GET_INTERACTION_MODE)


def _only_asks(can_id: int, data: bytes) -> bool:
    """Whether a foreign frame is a question, which changes nothing."""
    can_class = class_of(can_id)
    command: PolledMessage | None = None
    if can_class == CLASS_MOTOR_POLLING:
        command = command_of(data)
    elif can_class == CLASS_ANALOG_POLLING and data:
        command = analog.COMMANDS.get(data[0])
    if command is GET_FIRMWARE_VERSION:
        # It is answered too, but a version that the board refuses keeps its bridges off.
        return GET_FIRMWARE_VERSION.parse_request(data) == HOST_PROTOCOL
    return command is not None and command.reply_layout is not None
