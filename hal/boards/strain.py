"""Host side of the STRAIN force/torque sensor: pairs of frames, full scales, saturation."""

from collections import deque
from collections.abc import Iterable

from hal.boards.board import Parts, Pulse, ask, board_name, refusal, sent
from hal.line import Trace
from hal.readings import ForceTorqueSample
from hal.tasks import Sequence
from hal.wire import analog
from hal.wire.analog import TxMode
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame, frame_id
from hal.wire.management import BoardType

PERIOD_MS = 1
PAIR_NS = PERIOD_MS * 1_000_000
KEPT_SAMPLES = 256
HOST_PROTOCOL = (1, 0)
HALF_RANGE = 0x8000
CHANNEL_NAMES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")


class Strain:
    """One sensor. `full_scale` is what the sensor itself says, N and Nm."""

    type_code = BoardType.STRAIN
    addresses = 1

    def __init__(self, parts: Parts) -> None:
        self.board = parts.board
        self.line = parts.line
        self.axes = parts.axes
        self.name = parts.board.name if parts.sensor is None else parts.sensor.name
        self.full_scale = (1.0,) * analog.CHANNELS
        if parts.sensor is not None:
            self.full_scale = parts.sensor.full_scale
        self.trace = Trace(maxlen=8)
        self.pulses: tuple[Pulse, ...] = (Pulse(parts.board.address, "force and torque frames"),)
        self._parts = parts
        self._faults = parts.faults
        self._replies: dict[int, tuple[int, ...]] = {}
        self._samples: deque[ForceTorqueSample] = deque(maxlen=KEPT_SAMPLES)
        self._force: tuple[int, ...] | None = None
        self._force_ns = 0
        self.saturated_samples = 0
        self._scale = _scales(self.full_scale)

    @classmethod
    def velocity_count(cls, speed_estimate_shift: int) -> float:  # noqa: ARG003
        """It has no axes."""
        return 1.0

    def listen(self) -> None:
        """Attach the handlers of force, torque and replies."""
        address = self.board.address
        for kind, handler in (
            (analog.FORCE.type, self.on_force),
            (analog.TORQUE.type, self.on_torque),
        ):
            self.line.attach(frame_id(CLASS_ANALOG_PERIODIC, address, kind), handler, self.trace)
        self.line.attach(analog.reply_id(address), self.on_reply, self.trace)

    def quiesce(self) -> Iterable[Frame]:
        """Stop transmitting."""
        return [analog.SET_TXMODE.request(self.board.address, TxMode.SILENT)]

    def handshake(self) -> Sequence:
        """Type, firmware and protocol of the sensor."""
        address, code = self.board.address, analog.GET_FW_VERSION.code
        self._replies.clear()
        question = analog.GET_FW_VERSION.request(address, *HOST_PROTOCOL)
        version = yield from ask(self.line, address, question, self._replies, _key(code))
        return refusal(self.board, self.type_code, version, HOST_PROTOCOL)

    def write_settings(self, axis: int | None) -> None:
        """Queue rate and stream; a sensor has no axes."""
        if axis is None:
            address = self.board.address
            self.line.command(address, analog.SET_CANDATARATE.request(address, PERIOD_MS))
            self.line.command(address, analog.SET_TXMODE.request(address, TxMode.CALIBRATED))

    def configure(self) -> Sequence:
        """Full scales are read, never written; then the stream is started."""
        address = self.board.address
        scales: list[float] = []
        self._replies.clear()
        for channel in range(analog.CHANNELS):
            key = _key(analog.GET_FULL_SCALES.code, channel)
            question = analog.GET_FULL_SCALES.request(address, channel)
            answer = yield from ask(self.line, address, question, self._replies, key)
            if answer is None or not answer[1]:
                return f"{board_name(self.board)} does not tell the full scale of channel {channel}"
            scales.append(float(answer[1]))
        self._take_full_scale(scales)
        self.write_settings(None)
        yield from sent(self.line, address)
        return ""

    def read_back(self) -> Sequence:
        """Nothing of a running sensor can have changed."""
        return ""
        yield

    def _take_full_scale(self, scales: list[float]) -> None:
        fx, fy, fz, tx, ty, tz = scales
        found = (fx, fy, fz, tx, ty, tz)
        if found != self.full_scale:
            text = (
                f"{board_name(self.board)} has full scales {_text(found)}; "
                f"the robot file says {_text(self.full_scale)}: the sensor's are used"
            )
            self._faults.report(self.line.now_ns, text)
        self.full_scale = found
        self._scale = _scales(found)

    def take(self) -> list[ForceTorqueSample]:
        """Samples since the previous call, oldest first."""
        samples = list(self._samples)
        self._samples.clear()
        return samples

    def on_force(self, data: bytes, stamp_ns: int) -> None:
        """First half of a sample."""
        if self._force is not None:
            self._faults.drop("force frame without its torque frame")
        self._force = analog.FORCE.parse(data)
        self._force_ns = stamp_ns
        if self._force is None:
            self._faults.drop("FORCE of wrong length")

    def on_torque(self, data: bytes, stamp_ns: int) -> None:
        """Second half: the pair is a sample, if both arrived within one period."""
        force, self._force = self._force, None
        torque = analog.TORQUE.parse(data)
        if torque is None:
            self._faults.drop("TORQUE of wrong length")
            return
        if force is None:
            self._faults.drop("torque frame without its force frame")
            return
        if stamp_ns - self._force_ns > PAIR_NS:
            self._faults.drop("force and torque frames more than one period apart")
            return
        self.pulses[0].heard_ns = stamp_ns
        a, b, c, d, e, f = self._scale
        saturated = bool(force[3] or torque[3])
        channels = self._saturation(force[3], torque[3], stamp_ns) if saturated else ()
        self._samples.append(
            ForceTorqueSample(
                ((force[0] - 32768) * a, (force[1] - 32768) * b, (force[2] - 32768) * c),
                ((torque[0] - 32768) * d, (torque[1] - 32768) * e, (torque[2] - 32768) * f),
                stamp_ns,
                saturated,
                channels,
            )
        )

    def _saturation(self, force: int, torque: int, stamp_ns: int) -> tuple[int, ...]:
        channels = analog.saturation_states(force) + analog.saturation_states(torque)
        which = [n for n, state in zip(CHANNEL_NAMES, channels, strict=True) if state]
        self.saturated_samples += 1
        text = f"{self.name} saturated: {', '.join(which) or 'channel not told'}"
        self._faults.report(stamp_ns, text, f"{self.name} saturated")
        return channels

    def on_reply(self, data: bytes, stamp_ns: int) -> None:
        """Answers; every SET is acknowledged with an empty frame, which says nothing."""
        if not data:
            return
        if analog.parse_reset_cause(data) is not None:
            if any(pulse.heard_ns for pulse in self.pulses):  # else it has just been switched on
                text = f"{board_name(self.board)} has restarted"
                self._faults.report(stamp_ns, text, text)
            return
        command = analog.COMMANDS.get(data[0])
        values = None if command is None else command.parse_reply(data)
        if command is None or values is None:
            self._faults.drop("undecodable reply of a sensor")
            return
        channel = values[0] if command is analog.GET_FULL_SCALES else 0
        self._replies[_key(command.code, channel)] = values


def _key(code: int, channel: int = 0) -> int:
    """Where an answer is kept: the full scales of the channels apart from each other."""
    return code << 8 | channel


def _scales(full_scale: tuple[float, ...]) -> tuple[float, ...]:
    """Physical value of one count, per channel."""
    return tuple(value / HALF_RANGE for value in full_scale)


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
