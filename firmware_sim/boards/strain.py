"""STRAIN: six-axis force/torque sensor board (can-protocol 5).

Six raw words come in each millisecond; calibrated words go out, force before torque, each period.
"""

from collections import Counter, deque
from collections.abc import Sequence

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES, BoardError
from firmware_sim.boards.strain_calibration import (
    SATURATED_ABOVE,
    SATURATED_BELOW,
    Eeprom,
    calibrated_words,
    channel_states,
    is_factory,
    passes_through,
)
from firmware_sim.boards.strain_commands import BUILD, Answer, answer
from firmware_sim.description import BoardSpec
from hal.wire import analog, management
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    EVERYBODY,
    HOST,
    Frame,
    class_of,
    low_of,
    source_of,
)

_POWER_ON_RESET = (1, 0, 0, 0, 0, 0)
_STREAMS = frozenset({analog.TxMode.CALIBRATED, analog.TxMode.RAW, analog.TxMode.BOTH})
_STOPPED = 0xFF  # any mode that is not one of analog.TxMode


class Strain:
    """One STRAIN with the full scales of its sensor in the EEPROM."""

    def __init__(self, spec: BoardSpec, full_scale: Sequence[float]) -> None:
        """`full_scale` in N, N, N, Nm, Nm, Nm; the EEPROM holds whole numbers."""
        if len(full_scale) != analog.CHANNELS:
            raise BoardError(f"a STRAIN has six full scales, not {len(full_scale)}")
        self.addresses: tuple[int, ...] = (spec.address,)
        self.ports: tuple[AxisPort, ...] = ()
        self.axes: tuple[Axis, ...] = ()
        self.raw_adc = [analog.ZERO_WORD] * analog.CHANNELS
        self.bus_off = False
        self.powered = True
        self.dropped: Counter[str] = Counter()
        self.version = spec.firmware
        self.eeprom = Eeprom(full_scale=[round(value) for value in full_scale])
        self._received: deque[tuple[int, bytes]] = deque()
        self._boot()

    def _boot(self) -> None:
        self.memory = self.eeprom.copy()
        self._factory = is_factory(self.memory)
        self.mode = _STOPPED
        self.elapsed_ms = 0  # since the stream was started
        self.words = [analog.ZERO_WORD] * analog.CHANNELS  # last calibrated sample
        self._announced = False
        self._received.clear()

    def power_cycle(self) -> None:
        """Boot again from the EEPROM."""
        self.powered = True
        self._boot()

    def accepts(self, can_id: int) -> bool:
        """Commands of class 2 to this board, and class 7 from the host."""
        kind = class_of(can_id)
        if kind == CLASS_ANALOG_POLLING:
            return low_of(can_id) == self.addresses[0]
        to_us = low_of(can_id) in (self.addresses[0], EVERYBODY)
        return kind == CLASS_MANAGEMENT and to_us and source_of(can_id) == HOST

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Queue a frame for the next tick."""
        if self.bus_off or not self.powered:
            return
        if len(self._received) >= RECEIVE_FIFO_FRAMES:
            self.dropped["overrun"] += 1
        elif not self.accepts(can_id):
            self.dropped["address"] += 1
        else:
            self._received.append((can_id, data))

    def tick(self) -> list[Frame]:
        """One millisecond: answer what came in, then send a sample when its time has come."""
        if not self.powered:
            return []
        sent: list[Frame] = []
        if not self._announced:
            self._announced = True
            sent.append(analog.reset_cause(self.addresses[0], *_POWER_ON_RESET))
        while self._received:
            sent += self._respond(*self._received.popleft())
        if self.mode in _STREAMS:
            self.elapsed_ms += 1
            if self.elapsed_ms >= self.memory.period_ms:
                self.elapsed_ms = 0
                self._sample(sent)
        return [] if self.bus_off else sent

    def _respond(self, can_id: int, data: bytes) -> list[Frame]:
        address = self.addresses[0]
        if can_id >> 8 == CLASS_MANAGEMENT:
            if data[:1] != b"\xff":
                self.dropped["management"] += 1
                return []
            self.mode = _STOPPED  # a discovery stops the stream until the next TXMODE
            board_type = management.BoardType.STRAIN
            return [management.DISCOVER.reply(address, board_type, *self.version, BUILD)]
        if not data:
            self.dropped["length"] += 1
            return []
        row = analog.COMMANDS.get(data[0])
        if row is None:
            return [analog.unknown_command(address, data[0])]
        outcome = answer(self, row.code, row.parse_request(data) or ())
        self._factory = is_factory(self.memory)
        if outcome is Answer.UNKNOWN:
            return [analog.unknown_command(address, data[0])]
        if outcome is Answer.ACKNOWLEDGED:
            return [analog.ack(address)]
        return [row.reply(address, *outcome)]

    def _sample(self, sent: list[Frame]) -> None:
        raw = self.raw_adc
        address = self.addresses[0]
        saturated = False
        if self._factory and passes_through(raw):
            self.words = raw.copy()
        else:
            saturated = min(raw) < SATURATED_BELOW or max(raw) > SATURATED_ABOVE
            if not saturated:
                self.words = calibrated_words(self.memory, raw)
        words = raw if self.mode == analog.TxMode.RAW else self.words
        marks: tuple[int | None, int | None] = (None, None)
        if saturated:
            states = channel_states(raw)
            marks = analog.saturation_byte(*states[:3]), analog.saturation_byte(*states[3:])
        fx, fy, fz, tx, ty, tz = words
        sent.append(analog.FORCE.frame(address, fx, fy, fz, marks[0]))
        sent.append(analog.TORQUE.frame(address, tx, ty, tz, marks[1]))
        if self.mode == analog.TxMode.BOTH:
            fx, fy, fz, tx, ty, tz = raw
            sent.append(analog.RAW_FORCE.frame(address, fx, fy, fz, marks[0]))
            sent.append(analog.RAW_TORQUE.frame(address, tx, ty, tz, marks[1]))
