"""Counts how often joints are outside their limits, from the moment they may be held to them.

A joint is held to its limits from the first tick in which its board has called it calibrated and it
is inside them: before that it may stand anywhere, and calibration against a hard stop leaves the
limits on purpose.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

TOLERANCE_DEG = 0.2


class LimitCounter:
    """Ticks that each joint spent more than the tolerance outside its limits."""

    def __init__(self, limit_deg: Sequence[tuple[float, float]]) -> None:
        self.ticks = [0] * len(limit_deg)
        self.waiting = list(range(len(limit_deg)))  # joints that are not yet held to their limits
        self._inside = [(math.radians(low), math.radians(high)) for low, high in limit_deg]
        tolerance_rad = math.radians(TOLERANCE_DEG)
        self._low: Vector = np.array([low - tolerance_rad for low, _ in self._inside])
        self._high: Vector = np.array([high + tolerance_rad for _, high in self._inside])

    def admit(self, q_rad: Vector, is_calibrated: Callable[[int], bool]) -> None:
        """Hold those joints to their limits that are calibrated and inside them."""
        self.waiting = [
            i
            for i in self.waiting
            if not (is_calibrated(i) and self._inside[i][0] <= q_rad[i] <= self._inside[i][1])
        ]

    def step(self, q_rad: Vector) -> None:
        """Count one tick of every joint."""
        outside = (q_rad < self._low) | (q_rad > self._high)
        if outside.any():
            for i in np.flatnonzero(outside).tolist():
                if i not in self.waiting:
                    self.ticks[i] += 1
