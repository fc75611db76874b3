"""STRAIN: six-axis force/torque sensor board (can-protocol 5).

Six raw words come in each millisecond; calibrated words go out, force before torque, each period.
DELIBERATE: SET_BOARD_ADX is acknowledged but the address stays: the emulated bus is wired by it.
"""

from collections.abc import Sequence

from firmware_sim.boards.board import BoardError
from firmware_sim.boards.sensor_board import SensorBoard
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
from hal.wire import analog
from hal.wire.can import Frame
from hal.wire.management import BoardType
from hal.wire.message import Command, PeriodicMessage

_POWER_ON_RESET = (1, 0, 0, 0, 0, 0)
_RESET_BY_LOADER = (0, 0, 0, 1, 0, 0)  # as observed behind a firmware download
_STREAMS = frozenset({analog.TxMode.CALIBRATED, analog.TxMode.RAW, analog.TxMode.BOTH})
_STOPPED = 0xFF  # any mode that is not one of analog.TxMode


class Strain(SensorBoard):
    """One STRAIN with the full scales of its sensor in the EEPROM.

    Inputs: `raw_adc`; `stuck_words` (channel: word) stand in for the words of a broken gauge;
    `frozen` repeats the words of the last sample forever, as after an internal error.
    """

    board_type = BoardType.STRAIN
    build = BUILD
    overflow: PeriodicMessage | None = analog.RECEIVE_OVERFLOW

    def __init__(self, spec: BoardSpec, full_scale: Sequence[float]) -> None:
        """`full_scale` in N, N, N, Nm, Nm, Nm; the EEPROM holds whole numbers."""
        super().__init__(spec)
        if len(full_scale) != analog.CHANNELS:
            raise BoardError(f"a STRAIN has six full scales, not {len(full_scale)}")
        self.raw_adc = [analog.ZERO_WORD] * analog.CHANNELS
        self.stuck_words: dict[int, int] = {}
        self.frozen = False
        self.eeprom = Eeprom(full_scale=[round(value) for value in full_scale])
        self.boot()

    def boot(self) -> None:
        """Take the EEPROM's settings and no sample yet."""
        self.memory = self.eeprom.copy()
        self.factory = is_factory(self.memory)
        self.mode = _STOPPED
        self.elapsed_ms = 0  # since the stream was started
        self.words = [analog.ZERO_WORD] * analog.CHANNELS  # last calibrated sample

    def stop(self) -> None:
        """Stop until the next SET_TXMODE."""
        self.mode = _STOPPED

    def wake(self) -> list[Frame]:
        """The reset cause."""
        cause = _RESET_BY_LOADER if self.is_from_loader else _POWER_ON_RESET
        return [analog.reset_cause(self._address, *cause)]

    def answer(self, code: int, data: bytes) -> list[Frame]:
        """Every SET is acknowledged with an empty frame, every GET answered, the rest is a BUG."""
        row = analog.COMMANDS.get(code)
        if row is None:
            return [analog.unknown_command(self._address, code)]
        outcome = answer(self, code, row.parse_request(data) or ())
        self.factory = is_factory(self.memory)
        return self.reply(row, outcome)

    def reply(self, row: Command, outcome: tuple[int, ...] | Answer) -> list[Frame]:
        """The frames that a command leads to."""
        if outcome is Answer.UNKNOWN:
            return [analog.unknown_command(self._address, row.code)]
        if outcome is Answer.ACKNOWLEDGED:
            return [analog.ack(self._address)]
        return [row.reply(self._address, *outcome)]

    def sample(self, sent: list[Frame]) -> None:
        """Send a sample each period."""
        if self.mode in _STREAMS:
            self.elapsed_ms += 1
            if self.elapsed_ms >= self.memory.period_ms:
                self.elapsed_ms = 0
                self._sample(sent)
        elif self.mode == analog.TxMode.SILENT:
            self._acquire()

    def _acquire(self) -> tuple[list[int], bool]:
        """Take a sample; the raw words, and whether one of them is saturated."""
        raw = self._raw() if self.stuck_words else self.raw_adc
        saturated = False
        if self.frozen:
            raw = self.words
        elif self.factory and passes_through(raw):
            self.words = raw.copy()
        else:
            saturated = min(raw) < SATURATED_BELOW or max(raw) > SATURATED_ABOVE
            if not saturated:
                self.words = calibrated_words(self.memory, raw)
        return raw, saturated

    def _sample(self, sent: list[Frame]) -> None:
        raw, saturated = self._acquire()
        address = self._address
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

    def _raw(self) -> list[int]:
        return [self.stuck_words.get(channel, word) for channel, word in enumerate(self.raw_adc)]
