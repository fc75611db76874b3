"""The position reference of one axis: minimum-jerk moves, integrated velocity, direct set-points.

Ticks and milliseconds (can-protocol 2.2, commands 27, 28, 46, 62, 74, 86); its millisecond is
compiled (kernel_reference.py).
"""

from firmware_sim.boards.fields import (
    ACCELERATION,
    ACTIVE,
    DELTA,
    DURATION,
    ELAPSED,
    FRACTION,
    HIGH,
    LOW,
    PROGRESS,
    REFERENCE,
    VELOCITY,
    VELOCITY_AGE,
    VELOCITY_SHIFT,
    VELOCITY_TARGET,
    VELOCITY_TIMEOUT,
)
from firmware_sim.boards.kernel_reference import advance
from firmware_sim.boards.view import Flag, View, Word

DEFAULT_LIMIT_TICKS = 5000
DEFAULT_VELOCITY_SHIFT = 4
DEFAULT_VELOCITY_TIMEOUT_MS = 2000


class Reference(View):
    """Where the axis should be; `active` while that moves by itself."""

    __slots__ = ()

    ticks = Word(REFERENCE)
    low = Word(LOW)
    high = Word(HIGH)
    active = Flag(ACTIVE)
    velocity = Word(VELOCITY)  # (tick/ms) * 2^velocity_shift
    velocity_target = Word(VELOCITY_TARGET)
    velocity_shift = Word(VELOCITY_SHIFT)
    velocity_timeout_ms = Word(VELOCITY_TIMEOUT)
    acceleration = Word(ACCELERATION)  # (tick/ms^2) * 2^velocity_shift

    def boot(self) -> None:
        """Limits and scales before configuration."""
        self.low = -DEFAULT_LIMIT_TICKS
        self.high = DEFAULT_LIMIT_TICKS
        self.velocity_shift = DEFAULT_VELOCITY_SHIFT
        self.velocity_timeout_ms = DEFAULT_VELOCITY_TIMEOUT_MS
        self.acceleration = 0
        self.hold(0)

    def hold(self, ticks: int) -> None:
        """Stand at `ticks`: moves and velocities are forgotten."""
        self.ticks = ticks
        self.active = False
        self.velocity = 0
        self.velocity_target = 0
        self.words[VELOCITY_AGE] = 0
        self.words[FRACTION] = 0
        self._stop_move()

    def set_direct(self, ticks: int) -> None:
        """Jump to a set-point, inside the limits."""
        self.ticks = self._inside(ticks)

    def start_move(self, target: int, speed: int) -> None:
        """Minimum-jerk move from the present reference; `speed` in 10 ticks/s, at least 1."""
        self._stop_move()
        delta = self._inside(target) - self.ticks
        self.words[DELTA] = delta
        self.words[DURATION] = 100 * abs(delta) // max(speed, 1)
        self.active = True

    def start_velocity(self, velocity: int, acceleration: int) -> None:
        """Ramp to a velocity; each call restarts the time-out."""
        self.velocity_target = velocity
        self.acceleration = acceleration
        self.words[VELOCITY_AGE] = 0
        self.active = True

    def set_velocity_shift(self, bits: int) -> None:
        """Change the scale of velocities (0..16); the fraction kept so far has no meaning in it."""
        self.velocity_shift = bits
        self.words[FRACTION] = 0

    def advance(self) -> None:
        """One millisecond of whatever moves, for laws that are not compiled."""
        advance(self.row)

    def _inside(self, ticks: int) -> int:
        return max(self.low, min(self.high, ticks))

    def _stop_move(self) -> None:
        for place in (DELTA, PROGRESS, ELAPSED, DURATION):
            self.words[place] = 0
