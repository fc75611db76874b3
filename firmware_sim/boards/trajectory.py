"""The position reference of one axis: minimum-jerk moves, integrated velocity, direct set-points.

Ticks and milliseconds, integers throughout (can-protocol 2.2, commands 27, 28, 46, 62, 74, 86).
"""

from firmware_sim.boards.law import divide, shift_right

DEFAULT_LIMIT_TICKS = 5000
DEFAULT_VELOCITY_SHIFT = 4
DEFAULT_VELOCITY_TIMEOUT_MS = 2000


class Reference:
    """Where the axis should be; `active` while that moves by itself."""

    __slots__ = (
        "_delta",
        "_duration_ms",
        "_elapsed_ms",
        "_fraction",
        "_progress",
        "_velocity_age_ms",
        "acceleration",
        "active",
        "high",
        "low",
        "ticks",
        "velocity",
        "velocity_shift",
        "velocity_target",
        "velocity_timeout_ms",
    )

    def __init__(self) -> None:
        self.ticks = 0
        self.low = -DEFAULT_LIMIT_TICKS
        self.high = DEFAULT_LIMIT_TICKS
        self.velocity_shift = DEFAULT_VELOCITY_SHIFT
        self.velocity_timeout_ms = DEFAULT_VELOCITY_TIMEOUT_MS
        self.acceleration = 0  # (tick/ms^2) * 2^velocity_shift
        self._delta = self._progress = self._elapsed_ms = self._duration_ms = 0  # of the move
        self.hold(0)

    def hold(self, ticks: int) -> None:
        """Stand at `ticks`: moves and velocities are forgotten."""
        self.ticks = ticks
        self.active = False
        self.velocity = 0  # (tick/ms) * 2^velocity_shift
        self.velocity_target = 0
        self._velocity_age_ms = 0
        self._fraction = 0  # of a tick, in 2^-velocity_shift
        self._stop_move()

    def set_direct(self, ticks: int) -> None:
        """Jump to a set-point, inside the limits."""
        self.ticks = self._inside(ticks)

    def start_move(self, target: int, speed: int) -> None:
        """Minimum-jerk move from the present reference; `speed` in 10 ticks/s, at least 1."""
        self._stop_move()
        self._delta = self._inside(target) - self.ticks
        self._duration_ms = 100 * abs(self._delta) // max(speed, 1)
        self.active = True

    def start_velocity(self, velocity: int, acceleration: int) -> None:
        """Ramp to a velocity; each call restarts the time-out."""
        self.velocity_target = velocity
        self.acceleration = acceleration
        self._velocity_age_ms = 0
        self.active = True

    def set_velocity_shift(self, bits: int) -> None:
        """Change the scale of velocities (0..16); the fraction kept so far has no meaning in it."""
        self.velocity_shift = bits
        self._fraction = 0

    def advance(self) -> None:
        """One millisecond of whatever moves."""
        if self._delta:
            self._advance_move()
        if self.velocity or self.velocity_target:
            self._advance_velocity()
        self.active = bool(self._delta or self.velocity or self.velocity_target)

    def _advance_move(self) -> None:
        self._elapsed_ms += 1
        t = self._elapsed_ms
        total = self._duration_ms
        if t >= total:
            progress = self._delta
        else:
            # delta * (10 s^3 - 15 s^4 + 6 s^5) with s = t / total
            shape = t**3 * (10 * total * total - 15 * t * total + 6 * t * t)
            progress = divide(self._delta * shape, total**5)
        self.ticks += progress - self._progress
        self._progress = progress
        if t >= total:
            self._stop_move()

    def _advance_velocity(self) -> None:
        self._velocity_age_ms += 1
        if self._velocity_age_ms > self.velocity_timeout_ms:
            self.velocity_target = 0
        change = self.velocity_target - self.velocity
        ramp = max(self.acceleration, 1)
        self.velocity += max(-ramp, min(ramp, change))
        self._fraction += self.velocity
        step = shift_right(self._fraction, self.velocity_shift)
        self._fraction -= step << self.velocity_shift
        before = self.ticks
        if step > 0:  # a reference that starts outside the limits may come back, not go further out
            self.ticks = min(before + step, max(before, self.high))
        elif step < 0:
            self.ticks = max(before + step, min(before, self.low))

    def _inside(self, ticks: int) -> int:
        return max(self.low, min(self.high, ticks))

    def _stop_move(self) -> None:
        self._delta = 0
        self._progress = 0
        self._elapsed_ms = 0
        self._duration_ms = 0
