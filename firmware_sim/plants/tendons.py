"""Hands: motors that wind tendons, each over one finger joint or several in series.

A joint stands where its spring holds the tendon's pull, between its hard stops:

    angle = low + (tension - preload) / spring, held inside [low, high]
    wound = sum of the angles + tension / tendon stiffness, slack below the sum of the open joints

Fingers weigh nothing here, so tension and angles follow from what is wound: a piecewise linear
table per tendon. Beyond the last stop the motor runs on against the stretching tendon; below the
first it unwinds a slack one. An object in the hand is a stop of one joint, closer than its own.
Radians, N m; the pulleys of a tendon have the same radius.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import AxisSpec, FingerSpec

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

TENDON_NM_RAD = 0.5  # assumed, as is the preload: what an open finger's spring already pulls
PRELOAD_RAD = 0.3
FAR_NM = 1e3
TOP_BYTE = 255.0


class Tendons:
    """All tendons of a robot: tables of what is wound, and finger angles from tensions."""

    def __init__(self, axes: Sequence[AxisSpec]) -> None:
        self.fingers: tuple[FingerSpec, ...] = tuple(f for axis in axes for f in axis.fingers)
        self._of = np.array([i for i, axis in enumerate(axes) for _ in axis.fingers], dtype=np.intp)
        self._low: Vector = np.radians([finger.range_deg[0] for finger in self.fingers])
        self._high: Vector = np.radians([finger.range_deg[1] for finger in self.fingers])
        self._stop = self._high.copy()
        self._compliance: Vector = np.array([1.0 / f.spring_nm_rad for f in self.fingers])
        self._weight = _weights(axes)
        n, corners = len(axes), 3 + 2 * max((len(axis.fingers) for axis in axes), default=0)
        # Corners of the tables: what is wound, and there tension, its slope, angle, its slope.
        self.wound_rad: Matrix = np.full((n, corners), np.inf)
        self.table: NDArray[np.float64] = np.zeros((n, corners, 4))
        for i in range(n):
            self._tabulate(i)

    def finger_rad(self, tension_nm: Vector) -> Vector:
        """Angle of every finger joint under these tensions."""
        angles: Vector = (tension_nm[self._of] * self._compliance) - PRELOAD_RAD
        angles += self._low
        np.minimum(angles, self._stop, out=angles)
        return np.maximum(angles, self._low, out=angles)

    def wound_at(self, index: int, angle_rad: float) -> float:
        """What has to be wound for the fingers of one tendon to stand at an angle."""
        corners = self.table[index, 1:, 2]
        known = np.isfinite(self.wound_rad[index, 1:])
        return float(np.interp(angle_rad, corners[known], self.wound_rad[index, 1:][known]))

    def block(self, name: str, angle_rad: float | None) -> None:
        """Put an object before a finger joint, at an angle; None takes it away.

        Raises:
            KeyError: there is no such finger joint.
        """
        names = [finger.name for finger in self.fingers]
        if name not in names:
            raise KeyError(name)
        k = names.index(name)
        free = self._high[k]
        self._stop[k] = free if angle_rad is None else min(max(angle_rad, self._low[k]), free)
        self._tabulate(int(self._of[k]))

    def _tabulate(self, index: int) -> None:
        """Work out the corners of one tendon; before the first it is slack."""
        own = np.flatnonzero(self._of == index)
        low, stop, compliance = self._low[own], self._stop[own], self._compliance[own]
        leaves = PRELOAD_RAD / compliance
        stops = leaves + (stop - low) / compliance
        tensions = np.array(sorted({0.0, *leaves.tolist(), *stops.tolist(), FAR_NM}))
        pulled = tensions[:, None] * compliance - PRELOAD_RAD + low
        angles = np.clip(pulled, low, stop)
        wound = angles.sum(axis=1) + tensions / TENDON_NM_RAD
        seen = angles @ self._weight[own]
        last = len(tensions) - 1  # the far corner only gives the slope before it
        self.wound_rad[index] = np.inf
        self.wound_rad[index, 0] = -np.inf
        self.table[index] = 0.0
        self.table[index, 0, 2] = seen[0]
        self.wound_rad[index, 1 : last + 1] = wound[:-1]
        self.table[index, 1 : last + 1, 0] = tensions[:-1]
        self.table[index, 1 : last + 1, 1] = np.diff(tensions) / np.diff(wound)
        self.table[index, 1 : last + 1, 2] = seen[:-1]
        self.table[index, 1 : last + 1, 3] = np.diff(seen) / np.diff(wound)


class Halls:
    """The Hall sensors of the hands: finger angles in, bytes of the MAIS boards out.

    The bytes of an axis add up to its position: (degrees + zero) x ticks per degree (5.4, 11.2).
    """

    def __init__(self, axes: Sequence[AxisSpec]) -> None:
        fingers = [(axis, finger) for axis in axes for finger in axis.fingers]
        seen = {(axis.bus, channel): axis for axis, finger in fingers for channel in finger.hall}
        self.places: tuple[tuple[int, int], ...] = tuple(sorted(seen))  # bus, channel
        self._per_rad: Matrix = np.zeros((len(seen), len(fingers)))
        self._level: Vector = np.zeros(len(seen))
        for row, place in enumerate(self.places):
            axis = seen[place]
            shared = sum(other is axis for other in seen.values())
            self._level[row] = axis.zero_deg * axis.ticks_per_deg / shared + 0.5  # rounds
            for column, (owner, finger) in enumerate(fingers):
                if owner.bus == place[0] and place[1] in finger.hall:
                    self._per_rad[row, column] = math.degrees(axis.ticks_per_deg)

    def read(self, finger_rad: Vector) -> list[int]:
        """One byte per place."""
        value = self._per_rad @ finger_rad
        value += self._level
        np.minimum(value, TOP_BYTE, out=value)
        np.maximum(value, 0.0, out=value)
        values: list[int] = value.astype(np.int64).tolist()
        return values


def _weights(axes: Sequence[AxisSpec]) -> Vector:
    """How much each finger joint counts in its axis's angle: as often as a Hall sensor sees it."""
    weights: list[float] = []
    for axis in axes:
        halls = [float(len(finger.hall)) for finger in axis.fingers]
        weights += halls if any(halls) else [1.0] * len(halls)
    return np.array(weights)
