"""Whether the newest reading of a force/torque sensor may be used, and if not, why.

Every check is against the newest reading alone or the one before, so a fault shows in the very tick
in which it is in the data. The one exception is a frozen sensor: a quiet one may repeat itself by
chance, so the sensor's own board is believed at once, and equal readings after FROZEN_READINGS.

A reading that is flagged must not reach filters, offsets or estimates; `valid` says so.
"""

import math
from collections.abc import Sequence
from typing import Literal

Flag = Literal["nan", "inf", "saturated", "frozen", "late", "reordered", "missing"]

LATE_S = 0.02
MISSING_S = 0.1  # the boards' limit for torques
# Gauges whose noise is a third of their step show all six channels equal in 6 % of the pairs of
# readings, in 4 of 10 000 runs of five and in 8 of 10 million runs of ten.
FROZEN_READINGS = 10
RECOVERY_READINGS = 2


class SensorWatch:
    """Of one sensor. `check` once per tick, with the newest reading or None.

    After a fault the sensor is valid again with the second good reading in a row: the first may be
    a saturated amplifier's way back.
    """

    __slots__ = (
        "_equal",
        "_fresh_s",
        "_full_scale",
        "_good",
        "_last",
        "_late_s",
        "_missing_s",
        "_recovery",
        "_stamp_s",
        "counts",
        "flags",
    )

    def __init__(
        self,
        *,
        full_scale: Sequence[float] = (math.inf,) * 6,
        late_s: float = LATE_S,
        missing_s: float = MISSING_S,
        recovery_readings: int = RECOVERY_READINGS,
    ) -> None:
        """Nothing read yet: missing.

        Args:
            full_scale: largest readable value per channel (6,) in N, Nm; at it the sensor is
                saturated even if its board does not say so.
            late_s: an older reading is late.
            missing_s: an older one is as good as none.
            recovery_readings: good ones in a row after a fault, the last of them valid.
        """
        self._full_scale = tuple(full_scale)
        self._late_s = late_s
        self._missing_s = missing_s
        self._fresh_s = min(late_s, missing_s)
        self._recovery = recovery_readings
        self._last: tuple[float, ...] | None = None
        self._stamp_s = -math.inf
        self._equal = 0
        self._good = recovery_readings - 1  # the first reading counts
        self.flags: tuple[Flag, ...] = ("missing",)
        self.counts: dict[Flag, int] = {}  # ticks per cause

    @property
    def valid(self) -> bool:
        """The newest reading may be used."""
        return self._good >= self._recovery

    def check(
        self,
        wrench: Sequence[float] | None,
        age_s: float,
        saturated: bool = False,
        frozen: bool = False,
        stamp_s: float | None = None,
    ) -> tuple[Flag, ...]:
        """Flags of this tick, none when all is well. Look at `valid` for the result.

        Args:
            wrench: newest reading (6,), None where there is none in this tick.
            age_s: since its arrival, or since the last arrival.
            saturated: the board says so.
            frozen: the board says so.
            stamp_s: when it was taken, to tell an old reading that overtook a newer one, and to
                tell the same reading seen twice from a frozen sensor. None: arrivals are in order
                and each tick brings a new one.
        """
        if age_s <= self._fresh_s and (
            wrench is None or self._goes_on(wrench, saturated or frozen, stamp_s)
        ):
            self.flags = ()
            return ()
        return self._judge(wrench, age_s, saturated, frozen, stamp_s)

    def _goes_on(self, wrench: Sequence[float], said_bad: bool, stamp_s: float | None) -> bool:
        """Whether a valid sensor's reading is plainly good; then it is taken in. Quick."""
        x, y, z, mx, my, mz = reading = tuple(wrench)
        a, b, c, d, e, f = self._full_scale
        plain = (
            self._good >= self._recovery
            and not said_bad
            and (stamp_s is None or stamp_s > self._stamp_s)
            and reading != self._last
            # Neither holds of what is not finite.
            and (-a < x < a and -b < y < b and -c < z < c)
            and (-d < mx < d and -e < my < e and -f < mz < f)
        )
        if plain:
            self._equal = 0
            self._last = reading
            if stamp_s is not None:
                self._stamp_s = stamp_s
        return plain

    def _judge(
        self,
        wrench: Sequence[float] | None,
        age_s: float,
        saturated: bool,
        frozen: bool,
        stamp_s: float | None,
    ) -> tuple[Flag, ...]:
        """`check` in full."""
        flags: list[Flag] = []
        if not age_s <= self._missing_s or (wrench is None and age_s > self._late_s):
            flags.append("missing")
        elif age_s > self._late_s:
            flags.append("late")
        is_new = wrench is not None and (stamp_s is None or stamp_s > self._stamp_s)
        if wrench is not None:
            flags += self._of_values(wrench, saturated)
            if is_new:
                reading = tuple(wrench)
                self._equal = self._equal + 1 if reading == self._last else 0
                self._last = reading
            elif stamp_s is not None and stamp_s < self._stamp_s:
                flags.append("reordered")
            if frozen or self._equal >= FROZEN_READINGS - 1:
                flags.append("frozen")
        if is_new and stamp_s is not None:
            self._stamp_s = stamp_s
        self._conclude(tuple(flags), is_new=is_new)
        return self.flags

    def _conclude(self, flags: tuple[Flag, ...], *, is_new: bool) -> None:
        self.flags = flags
        for flag in flags:
            self.counts[flag] = self.counts.get(flag, 0) + 1
        if flags:
            self._good = 0
        elif is_new:
            self._good = min(self._good + 1, self._recovery)

    def _of_values(self, wrench: Sequence[float], saturated: bool) -> list[Flag]:
        flags: list[Flag] = []
        if any(map(math.isnan, wrench)):
            flags.append("nan")
        if any(map(math.isinf, wrench)):
            flags.append("inf")
        elif saturated or any(
            abs(value) >= most for value, most in zip(wrench, self._full_scale, strict=True)
        ):
            flags.append("saturated")
        return flags
