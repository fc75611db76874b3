"""Velocity of an object from its last two positions."""

import numpy as np

from dforc.arrays import Matrix, Vector


class ObjectTracker:
    """Without a filter."""

    def __init__(self) -> None:
        self._time_s = 0.0
        self._place_m: Vector | None = None
        self._velocity_m_s: Vector = np.zeros(3)

    def update(self, time_s: float, place_m: Vector, covariance_m2: Matrix | None) -> None:  # noqa: ARG002
        """It is there."""
        if self._place_m is not None and time_s > self._time_s:
            self._velocity_m_s = (place_m - self._place_m) / (time_s - self._time_s)
        self._time_s, self._place_m = time_s, place_m

    def at(self, time_s: float) -> tuple[Vector, Vector, float]:
        """Place, velocity and sigma."""
        assert self._place_m is not None
        place: Vector = self._place_m + (time_s - self._time_s) * self._velocity_m_s
        return place, self._velocity_m_s, 0.0
