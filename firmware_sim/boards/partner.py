"""What a shoulder board hears of its partner board: duties, positions, and silence.

Frames come every 4 ms; in between, each value goes on as it went between the last two frames
(can-protocol 9.4). The sheet does not say how the boards extrapolate: here a straight line, for at
most as long as those two frames were apart.
"""

from firmware_sim.boards.hardware import PartnerSpec
from firmware_sim.boards.law import divide
from hal.wire import motor_periodic
from hal.wire.can import CLASS_MOTOR_PERIODIC, frame_id

WATCHDOG_MS = 100  # cycles without a frame until the partner counts as silent

Two = tuple[int, int]


class _Track:
    """Two numbers that come in frames and are wanted each millisecond."""

    __slots__ = ("_age_ms", "_delta", "_last", "_period_ms", "now", "silent_ms")

    def __init__(self) -> None:
        self.now: Two = (0, 0)
        self._last: Two | None = None
        self._delta: Two = (0, 0)
        self._period_ms = 1
        self._age_ms = 0
        self.silent_ms = 0

    def hear(self, first: int, second: int) -> None:
        """A frame: its values hold in this millisecond."""
        last = self._last
        if last is None or self.silent_ms >= WATCHDOG_MS:  # no line across a silence
            last = first, second
        self._delta = (first - last[0], second - last[1])
        self._period_ms = max(self._age_ms + 1, 1)
        self._last = first, second
        self._age_ms = -1
        self.silent_ms = 0

    def advance(self) -> None:
        """One millisecond."""
        self.silent_ms = min(self.silent_ms + 1, WATCHDOG_MS)
        self._age_ms += 1
        if self._last is None:
            return
        age, period = min(self._age_ms, self._period_ms), self._period_ms
        first, second = self._last
        self.now = (
            first + divide(self._delta[0] * age, period),
            second + divide(self._delta[1] * age, period),
        )


class PartnerLink:
    """One board's ear for the other. `on_frame` before `advance` in each millisecond."""

    __slots__ = ("_duties", "_duty_id", "_position_id", "_positions", "axes")

    def __init__(self, spec: PartnerSpec) -> None:
        self.axes = spec.axes
        self._duty_id = _id(spec.address, motor_periodic.PID_VAL.type)
        self._position_id = (
            _id(spec.address, motor_periodic.POSITION.type) if spec.needs_position else None
        )
        self.boot()

    def boot(self) -> None:
        """Nothing heard yet."""
        self._duties = _Track()
        self._positions = _Track()

    def accepts(self, can_id: int) -> bool:
        """True for the partner's frames that the hardware filter lets in."""
        return can_id in (self._duty_id, self._position_id)

    def on_frame(self, can_id: int, data: bytes) -> bool:
        """Take a frame in; False when its length is wrong."""
        if can_id == self._duty_id:
            values = motor_periodic.PID_VAL.parse(data)
            if values is None:
                return False
            self._duties.hear(values[2], values[3])
            return True
        values = motor_periodic.POSITION.parse(data)
        if values is None:
            return False
        self._positions.hear(values[0], values[1])
        return True

    def advance(self) -> None:
        """One millisecond."""
        self._duties.advance()
        self._positions.advance()

    @property
    def duties(self) -> Two:
        """PWM applied to the partner's motors now."""
        return self._duties.now

    @property
    def positions(self) -> Two:
        """Joint positions of the partner now, ticks."""
        return self._positions.now

    @property
    def silent(self) -> bool:
        """True when a frame that is needed did not come for 100 cycles."""
        needs_position = self._position_id is not None
        return self._duties.silent_ms >= WATCHDOG_MS or (
            needs_position and self._positions.silent_ms >= WATCHDOG_MS
        )


def _id(address: int, kind: int) -> int:
    return frame_id(CLASS_MOTOR_PERIODIC, address, kind)
