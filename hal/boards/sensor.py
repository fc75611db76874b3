"""What the host sides of all sensor boards share: handshake, settings, answers."""

from collections.abc import Iterable

from hal.boards.board import Parts, Pulse, ask, board_name, refusal, sent
from hal.line import Handler, Trace
from hal.tasks import Sequence
from hal.wire import analog
from hal.wire.analog import TxMode
from hal.wire.can import Frame
from hal.wire.management import BoardType
from hal.wire.message import PeriodicMessage

KEPT_SAMPLES = 256
MS = 1_000_000
HOST_PROTOCOL = analog.HOST_PROTOCOL

Group = tuple[Frame, ...]
"""Frames that leave together, because the first of them stops what the last one starts."""


class SensorBoard:
    """A board without axes; subclasses decode its frames. Frames count by class and address.

    Attributes:
        type_code: what the board reports in the handshake.
        default_period_ms: of its samples, where the robot file gives none.
    """

    type_code: BoardType
    addresses = 1
    full_pwm = 0  # it drives nothing
    max_current_ma = 0
    default_period_ms: int
    overflow: PeriodicMessage | None = None  # sent when the receive queue was full

    def __init__(self, parts: Parts) -> None:
        self.board = parts.board
        self.line = parts.line
        self.axes = parts.axes
        self.name = parts.board.name
        self.period_ms = parts.board.period_ms or self.default_period_ms
        self.pulses: tuple[Pulse, ...] = ()
        self.trace = Trace(maxlen=8)
        self._faults = parts.faults
        self._replies: dict[int, tuple[int, ...]] = {}

    @classmethod
    def velocity_count(cls, speed_estimate_shift: int) -> float:  # noqa: ARG003
        """It has no axes."""
        return 1.0

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """Identifiers of the samples, and who reads them."""
        raise NotImplementedError

    def settings(self) -> Iterable[Group]:
        """Everything that makes the board send as the robot file says, the stream last."""
        raise NotImplementedError

    def forget(self) -> None:
        """Drop what is half received: the board starts anew."""

    def listen(self) -> None:
        """Attach the handlers of samples and replies."""
        for can_id, handler in self.handlers():
            self.line.attach(can_id, handler, self.trace)
        self.line.attach(analog.reply_id(self.board.address), self.on_reply, self.trace)
        if self.overflow is not None:
            can_id, _ = self.overflow.frame(self.board.address)
            self.line.attach(can_id, self.on_overflow, self.trace)

    def quiesce(self) -> Iterable[Frame]:
        """Stop transmitting."""
        return [analog.SET_TXMODE.request(self.board.address, TxMode.SILENT)]

    def handshake(self) -> Sequence:
        """Type, firmware and protocol of the board."""
        address, code = self.board.address, analog.GET_FW_VERSION.code
        self._replies.clear()
        question = analog.GET_FW_VERSION.request(address, *HOST_PROTOCOL)
        version = yield from ask(self.line, address, question, self._replies, reply_key(code))
        return refusal(self.board, self.type_code, version, HOST_PROTOCOL)

    def write_settings(self, axis: int | None) -> None:
        """Queue the settings; a sensor has no axes."""
        if axis is None:
            for group in self.settings():
                self.line.command(self.board.address, *group)

    def configure(self) -> Sequence:
        """Send the settings; the last of them starts the stream."""
        self.forget()
        self.write_settings(None)
        yield from sent(self.line, self.board.address)
        return ""

    def read_back(self) -> Sequence:
        """Nothing of a running sensor can have changed."""
        return ""
        yield

    def on_reply(self, data: bytes, stamp_ns: int) -> None:
        """Answers; every SET is acknowledged with an empty frame, which says nothing."""
        if not data:
            return
        if analog.parse_reset_cause(data) is not None:
            self._on_restart(stamp_ns)
            return
        command = analog.COMMANDS.get(data[0])
        values = None if command is None else command.parse_reply(data)
        if command is None or values is None:
            self._faults.drop("undecodable reply of a sensor")
            return
        channel = values[0] if command is analog.GET_FULL_SCALES else 0
        self._replies[reply_key(command.code, channel)] = values

    def on_overflow(self, data: bytes, stamp_ns: int) -> None:
        """The board's receive queue was full: commands are lost."""
        if data:
            self._faults.drop("RECEIVE_OVERFLOW of wrong length")
            return
        text = f"{board_name(self.board)} has lost commands: its receive queue was full"
        self._faults.report(stamp_ns, text, text)

    def _on_restart(self, stamp_ns: int) -> None:
        self.forget()
        if any(pulse.heard_ns for pulse in self.pulses):  # else it has just been switched on
            text = f"{board_name(self.board)} has restarted"
            self._faults.report(stamp_ns, text, text)


def reply_key(code: int, channel: int = 0) -> int:
    """Where an answer is kept: the full scales of the channels apart from each other."""
    return code << 8 | channel
