"""Counts how often joints are outside their limits, from the moment they may be held to them.

A joint is held to its limits once its board has called it calibrated and it has come to rest inside
them: before that it may stand anywhere or still be falling, as an unpowered wrist does, and
calibration against a hard stop leaves the limits on purpose.
"""

import math
from collections.abc import Sequence

TOLERANCE_DEG = 0.2
REST_RAD_S = 0.02


class LimitCounter:
    """Ticks that each joint spent more than the tolerance outside its limits."""

    def __init__(self, limit_deg: Sequence[tuple[float, float]]) -> None:
        self.ticks = [0] * len(limit_deg)
        self._inside = [(math.radians(low), math.radians(high)) for low, high in limit_deg]
        tolerance_rad = math.radians(TOLERANCE_DEG)
        self._low = [low - tolerance_rad for low, _ in self._inside]
        self._high = [high + tolerance_rad for _, high in self._inside]
        self._waiting = list(range(len(limit_deg)))

    @property
    def waiting(self) -> bool:
        """True while some joint is not yet held to its limits."""
        return bool(self._waiting)

    def admit(
        self, q_rad: Sequence[float], dq_rad_s: Sequence[float], calibrated: Sequence[bool]
    ) -> None:
        """Hold those joints to their limits that are calibrated and at rest inside them."""
        self._waiting = [
            i
            for i in self._waiting
            if not (
                calibrated[i]
                and abs(dq_rad_s[i]) <= REST_RAD_S
                and self._inside[i][0] <= q_rad[i] <= self._inside[i][1]
            )
        ]

    def step(self, q_rad: Sequence[float]) -> None:
        """Count one tick of every joint."""
        for low, angle, high in zip(self._low, q_rad, self._high, strict=True):
            if not low <= angle <= high:
                self._count(q_rad)
                return

    def _count(self, q_rad: Sequence[float]) -> None:
        for i, (low, angle, high) in enumerate(zip(self._low, q_rad, self._high, strict=True)):
            if not low <= angle <= high and i not in self._waiting:
                self.ticks[i] += 1
