"""Host side of the MAIS: the 15 Hall sensors of a hand, 8 bits each in two frames."""

from collections import deque
from collections.abc import Iterable

from hal.boards.board import Parts, Pulse
from hal.boards.sensor import KEPT_SAMPLES, MS, Group, SensorBoard
from hal.line import Handler
from hal.readings import HallSample
from hal.wire import analog, mais
from hal.wire.analog import TxMode
from hal.wire.can import CLASS_ANALOG_PERIODIC, frame_id
from hal.wire.mais import Resolution
from hal.wire.management import BoardType


class Mais(SensorBoard):
    """One MAIS. The hand's motor boards read its frames too and fault without them."""

    type_code = BoardType.MAIS
    overflow = analog.RECEIVE_OVERFLOW
    default_period_ms = 10

    def __init__(self, parts: Parts) -> None:
        super().__init__(parts)
        self._pulse = Pulse(parts.board.address, "Hall frames")
        self.pulses = (self._pulse,)
        self._samples: deque[HallSample] = deque(maxlen=KEPT_SAMPLES)
        self._first: tuple[int, ...] | None = None
        self._first_ns = 0

    def handlers(self) -> Iterable[tuple[int, Handler]]:
        """HES0 to HES6 and HES7 to HES14."""
        address = self.board.address
        return [
            (frame_id(CLASS_ANALOG_PERIODIC, address, mais.HALL_0_6.type), self.on_first),
            (frame_id(CLASS_ANALOG_PERIODIC, address, mais.HALL_7_14.type), self.on_second),
        ]

    def settings(self) -> Iterable[Group]:
        """Resolution, rate and stream."""
        address = self.board.address
        return [
            (analog.SET_RESOLUTION.request(address, Resolution.EIGHT_BITS),),
            (analog.SET_CANDATARATE.request(address, self.period_ms),),
            (analog.SET_TXMODE.request(address, TxMode.CALIBRATED),),
        ]

    def forget(self) -> None:
        """Drop a lone first frame."""
        self._first = None

    def take(self) -> list[HallSample]:
        """Samples since the previous call, oldest first."""
        samples = list(self._samples)
        self._samples.clear()
        return samples

    def on_first(self, data: bytes, stamp_ns: int) -> None:
        """First half of a sample."""
        if self._first is not None:
            self._faults.drop("first Hall frame without the second")
        self._first = mais.HALL_0_6.parse(data)
        self._first_ns = stamp_ns
        if self._first is None:
            self._faults.drop("HALL_0_6 of wrong length")

    def on_second(self, data: bytes, stamp_ns: int) -> None:
        """Second half: the pair is a sample, if both arrived within one period."""
        first, self._first = self._first, None
        second = mais.HALL_7_14.parse(data)
        if second is None:
            self._faults.drop("HALL_7_14 of wrong length")
        elif first is None or stamp_ns - self._first_ns > self.period_ms * MS:
            self._faults.drop("second Hall frame without the first")
        else:
            self._pulse.heard_ns = stamp_ns
            self._samples.append(HallSample(first + second, stamp_ns))
