"""What happens to one emulated board, a line for each change, from what it sends and its axes."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from hal.wire import analog, motor
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_INERTIAL_PERIODIC,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    CLASS_SKIN_PERIODIC,
    HOST,
    Frame,
    class_of,
    frame_id,
    low_of,
    source_of,
)
from hal.wire.message import CODE_MASK
from hal.wire.modes import ControlMode, reported_mode
from hal.wire.motor_periodic import POSITION, STATUS, axis_fault_text, board_status_text

PERIODIC = (
    CLASS_MOTOR_PERIODIC,
    CLASS_ANALOG_PERIODIC,
    CLASS_SKIN_PERIODIC,
    CLASS_INERTIAL_PERIODIC,
)
QUIET_TICKS = 500  # the slowest stream comes each 255 ms; STATUS alone is no stream
AXES_PER_ADDRESS = 2


class WatchedAxis(Protocol):
    """What is read of an axis."""

    mode: int
    calibrated: bool


class Watch:
    """Follows one board; `look` once per tick."""

    def __init__(
        self, addresses: Sequence[int], axes: Sequence[WatchedAxis], joints: Mapping[int, str]
    ) -> None:
        """`joints` by axis of the board; an axis that moves none goes by its number."""
        self._addresses = tuple(addresses)
        self._axes = tuple(axes)
        self._names = [joints.get(axis, f"axis {axis}") for axis in range(len(self._axes))]
        self._modes: list[int] = [ControlMode.IDLE] * len(self._axes)
        self._calibrated = [False] * len(self._axes)
        self._faults = dict.fromkeys(range(len(self._axes)), "")
        self._positions: dict[int, tuple[int, ...]] = {}
        self._board_text = ""
        self._quiet_ticks = QUIET_TICKS
        self._handshake = ""
        self._replies = {
            frame_id(CLASS_MOTOR_POLLING, addresses[0], HOST): motor.GET_FIRMWARE_VERSION,
            frame_id(CLASS_ANALOG_POLLING, addresses[0], HOST): analog.GET_FW_VERSION,
        }

    def look(self, sent: Sequence[Frame]) -> list[str]:
        """Sentences about what has changed in this tick; `sent` is what the board sent in it."""
        lines: list[str] = []
        self._quiet_ticks += 1
        if sent:
            for can_id, data in sent:
                lines += self._on_frame(can_id, data)
        if self._quiet_ticks == QUIET_TICKS:
            self._handshake = ""
            lines.append("streams stopped")
        for number, axis in enumerate(self._axes):
            if axis.mode != self._modes[number] or axis.calibrated != self._calibrated[number]:
                lines += self._on_axis(number, axis)
        return lines

    def state(self) -> str:
        """The board as it is now, in one line."""
        streams = "silent" if self._quiet_ticks >= QUIET_TICKS else "streaming"
        axes = [
            f"{name} {_words(mode)}{self._ticks(number)}"
            for number, (name, mode) in enumerate(zip(self._names, self._modes, strict=True))
        ]
        return ", ".join([streams, *axes])

    def _ticks(self, number: int) -> str:
        values = self._positions.get(self._addresses[number // AXES_PER_ADDRESS])
        return "" if values is None else f" at {values[number % AXES_PER_ADDRESS]} ticks"

    def _on_frame(self, can_id: int, data: bytes) -> Iterator[str]:
        kind = class_of(can_id)
        if kind == CLASS_MOTOR_PERIODIC and low_of(can_id) == STATUS.type:
            yield from self._on_status(source_of(can_id), data)
        elif kind in PERIODIC:
            if self._quiet_ticks >= QUIET_TICKS:
                yield "streams started"
            self._quiet_ticks = 0
            if kind == CLASS_MOTOR_PERIODIC and low_of(can_id) == POSITION.type:
                self._positions[source_of(can_id)] = POSITION.parse(data) or (0, 0)
        elif can_id in self._replies:
            command = self._replies[can_id]
            if data and data[0] & CODE_MASK == command.code:
                yield from self._on_handshake(command.parse_reply(data))

    def _on_handshake(self, version: tuple[int, ...] | None) -> Iterator[str]:
        """A host that asks again gets an answer, and we keep quiet about it."""
        if version is None:
            return
        *_, major, minor, accepted = version
        text = f"handshake {'accepted' if accepted else 'refused'}, protocol {major}.{minor}"
        if text != self._handshake:
            self._handshake = text
            yield text

    def _on_status(self, source: int, data: bytes) -> Iterator[str]:
        values = STATUS.parse(data)
        if values is None or source not in self._addresses:
            return
        first = AXES_PER_ADDRESS * self._addresses.index(source)
        for number, bits in ((first, values[0]), (first + 1, values[2])):
            text = axis_fault_text(bits)
            if text != self._faults[number]:
                self._faults[number] = text
                yield f"{self._names[number]}: {text or 'fault gone'}"
        text = board_status_text(values[5])
        if text != self._board_text:
            self._board_text = text
            if text:
                yield text

    def _on_axis(self, number: int, axis: WatchedAxis) -> Iterator[str]:
        name, mode = self._names[number], reported_mode(axis.mode)
        if mode != self._modes[number]:
            yield f"{name}: {_words(self._modes[number])} -> {_words(mode)}"
        if axis.calibrated and not self._calibrated[number]:
            yield f"{name}: calibrated"
        self._modes[number], self._calibrated[number] = mode, bool(axis.calibrated)


def _words(mode: int) -> str:
    known = mode in set(ControlMode)
    return ControlMode(mode).name.lower().replace("_", " ") if known else f"mode {mode:#04x}"
