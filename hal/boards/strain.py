"""Host side of the STRAIN force/torque sensor: pairs of frames, full scales, supervision."""

from collections import deque
from collections.abc import Iterable

from hal.boards.board import Parts, Pulse, ask, board_name, sent
from hal.boards.sensor import KEPT_SAMPLES, MS, Group, SensorBoard, reply_key
from hal.boards.supervision import Supervision
from hal.line import Handler
from hal.readings import ForceTorqueSample
from hal.tasks import Sequence
from hal.wire import analog
from hal.wire.analog import TxMode
from hal.wire.can import CLASS_ANALOG_PERIODIC, frame_id
from hal.wire.management import BoardType
from hal.wire.message import PeriodicMessage

HALF_RANGE = 0x8000


class Strain(SensorBoard):
    """One sensor. `full_scale` is what the sensor itself says, N and Nm."""

    type_code = BoardType.STRAIN
    overflow: PeriodicMessage | None = analog.RECEIVE_OVERFLOW
    default_period_ms = 1

    def __init__(self, parts: Parts) -> None:
        super().__init__(parts)
        self.full_scale = (1.0,) * analog.CHANNELS
        if parts.sensor is not None:
            self.name = parts.sensor.name
            self.full_scale = parts.sensor.full_scale
        self._pulse = Pulse(parts.board.address, "force and torque frames")
        self.pulses = (self._pulse,)
        self.supervision = Supervision(self.name, parts.faults)
        self._samples: deque[ForceTorqueSample] = deque(maxlen=KEPT_SAMPLES)
        self._force: tuple[int, ...] | None = None
        self._force_data = b""
        self._force_ns = 0
        self._pair_ns = self.period_ms * MS
        self._scale = _scales(self.full_scale)

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """Force and torque."""
        address = self.board.address
        return [
            (frame_id(CLASS_ANALOG_PERIODIC, address, analog.FORCE.type), self.on_force),
            (frame_id(CLASS_ANALOG_PERIODIC, address, analog.TORQUE.type), self.on_torque),
        ]

    def settings(self) -> Iterable[Group]:
        """Rate and stream."""
        address = self.board.address
        return [
            (analog.SET_CANDATARATE.request(address, self.period_ms),),
            (analog.SET_TXMODE.request(address, TxMode.CALIBRATED),),
        ]

    def forget(self) -> None:
        """Drop a lone force frame; nothing is known to be frozen."""
        self._force = None
        self.supervision.forget()

    def configure(self) -> Sequence:
        """Full scales are read, never written; then the stream is started."""
        address = self.board.address
        scales: list[float] = []
        self.forget()
        self._replies.clear()
        for channel in range(analog.CHANNELS):
            key = reply_key(analog.GET_FULL_SCALES.code, channel)
            question = analog.GET_FULL_SCALES.request(address, channel)
            answer = yield from ask(self.line, address, question, self._replies, key)
            if answer is None or not answer[1]:
                return f"{board_name(self.board)} does not tell the full scale of channel {channel}"
            scales.append(float(answer[1]))
        self._take_full_scale(scales)
        self.write_settings(None)
        yield from sent(self.line, address)
        return ""

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
            self._lost("force frame without its torque frame", stamp_ns)
        self._force = analog.FORCE.parse(data)
        self._force_data = data
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
            self._lost("torque frame without its force frame", stamp_ns)
            return
        if stamp_ns - self._force_ns > self._pair_ns:
            self._lost("force and torque frames more than one period apart", stamp_ns)
            return
        self._pulse.heard_ns = stamp_ns
        a, b, c, d, e, f = self._scale
        watch = self.supervision
        saturated = bool(force[3] or torque[3])
        channels = watch.saturation(force[3], torque[3], stamp_ns) if saturated else ()
        frozen = not saturated and watch.is_frozen(self._force_data, data, stamp_ns)
        self._samples.append(
            ForceTorqueSample(
                ((force[0] - 32768) * a, (force[1] - 32768) * b, (force[2] - 32768) * c),
                ((torque[0] - 32768) * d, (torque[1] - 32768) * e, (torque[2] - 32768) * f),
                stamp_ns,
                saturated,
                channels,
                frozen,
            )
        )

    def _lost(self, cause: str, stamp_ns: int) -> None:
        self.supervision.lost(cause, stamp_ns, running=bool(self._pulse.heard_ns))


def _scales(full_scale: tuple[float, ...]) -> tuple[float, ...]:
    """Physical value of one count, per channel."""
    return tuple(value / HALF_RANGE for value in full_scale)


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
