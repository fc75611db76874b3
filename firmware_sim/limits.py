"""Counts how often joints are outside their limits, from the moment they may be held to them.

A joint is held to its limits from the first tick in which its board has called it calibrated and it
is inside them: before that it may stand anywhere, and calibration against a hard stop leaves the
limits on purpose.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Switches = NDArray[np.bool_]

TOLERANCE_DEG = 0.2


class LimitCounter:
    """Ticks that each joint spent more than the tolerance outside its limits."""

    def __init__(self, limit_deg: Sequence[tuple[float, float]]) -> None:
        self.ticks = [0] * len(limit_deg)
        self._held: Switches = np.zeros(len(limit_deg), dtype=np.bool_)
        inside = np.radians(np.array(limit_deg).reshape(-1, 2))
        self._inside = inside.T.copy()
        tolerance_rad = math.radians(TOLERANCE_DEG)
        self._low: Vector = inside[:, 0] - tolerance_rad
        self._high: Vector = inside[:, 1] + tolerance_rad
        self.all_held = False

    @property
    def waiting(self) -> list[int]:
        """Joints that are not yet held to their limits."""
        waiting: list[int] = np.flatnonzero(~self._held).tolist()
        return waiting

    def admit(self, q_rad: Vector, calibrated: Switches) -> None:
        """Hold those joints to their limits that are calibrated and inside them."""
        low, high = self._inside
        self._held |= calibrated & (q_rad >= low) & (q_rad <= high)
        self.all_held = bool(self._held.all())

    def step(self, q_rad: Vector) -> None:
        """Count one tick of every joint."""
        outside = (q_rad < self._low) | (q_rad > self._high)
        outside &= self._held
        if outside.any():
            for i in np.flatnonzero(outside).tolist():
                self.ticks[i] += 1
