"""Axes whose boards run elsewhere: the plant follows what their POSITION frames say.

An axis follows as a stiff, critically damped servo with no limit on its torque: between frames it
goes on at a filtered speed. The others move as if that axis were as heavy as a wall.
"""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import AxisSpec
from hal.wire.can import Received
from hal.wire.motor_periodic import POSITION

Vector = NDArray[np.float64]
Indices = NDArray[np.intp]

WALL_KG_M2 = 1e6
FOLLOW_RAD_S = 40.0  # bandwidth: one tick of an encoder pulls with 2.5 rad/s2
SPEED_TIME_S = 0.015  # of the filter on the speed between frames
SILENCE_TICKS = 50  # after this long without a frame an axis stands still
JUMP_RAD = math.radians(5.0)  # more than that between two frames is another zero, not a motion


class Driven:
    """The driven axes among `axes`: targets in, accelerations out.

    A hand's position is what this plant's own Hall sensors say: a driven tendon stays where it is.
    """

    def __init__(self, axes: Sequence[AxisSpec], step_s: float) -> None:
        at = [i for i, axis in enumerate(axes) if axis.driven]
        chosen = [axes[i] for i in at]
        self.at: Indices = np.array(at, dtype=np.intp)
        self._step_s = step_s
        self._target: Vector = np.radians([axis.start_deg for axis in chosen])
        self._speed: Vector = np.zeros(len(chosen))
        self._age: Vector = np.zeros(len(chosen))
        self._known: set[int] = set()
        self._jumped: set[int] = set()
        self._heard: dict[tuple[int, int], list[tuple[int, AxisSpec]]] = {}
        for k, axis in enumerate(chosen):
            if axis.mechanism != "tendon" and axis.ticks_per_deg:
                place = (axis.bus, POSITION.frame(axis.address, 0, 0)[0])
                self._heard.setdefault(place, []).append((k, axis))
        self.buses = frozenset(bus for bus, _ in self._heard)

    def listen(self, received: Mapping[int, Iterable[Received]]) -> None:
        """Take the POSITION frames of boards that are elsewhere."""
        for bus in self.buses & received.keys():
            for can_id, data, _ in received[bus]:
                axes = self._heard.get((bus, can_id))
                values = POSITION.parse(data) if axes else None
                if axes and values is not None:
                    for k, axis in axes:
                        self._hear(k, values[axis.axis] / axis.ticks_per_deg - axis.zero_deg)

    def _hear(self, k: int, angle_deg: float) -> None:
        angle = math.radians(angle_deg)
        moved = angle - self._target[k]
        seconds = max(float(self._age[k]), 1.0) * self._step_s
        self._age[k] = 0
        self._target[k] = angle
        if k not in self._known or abs(moved) > JUMP_RAD:
            self._known.add(k)
            self._jumped.add(k)
            self._speed[k] = 0.0
            return
        share = seconds / (seconds + SPEED_TIME_S)
        self._speed[k] += share * (moved / seconds - self._speed[k])

    def follow(self, x: Vector, dx: Vector) -> Vector:
        """Accelerations (of `at`) that bring the axes to where they are in this step.

        The first frame of an axis, and one from another zero, set its coordinate instead.
        """
        for k in self._jumped:
            x[self.at[k]], dx[self.at[k]] = self._target[k], 0.0
        self._jumped.clear()
        goal = self._target + self._speed * (self._age * self._step_s)
        self._age += 1
        self._speed[self._age > SILENCE_TICKS] = 0.0
        ddx: Vector = FOLLOW_RAD_S**2 * (goal - x[self.at])
        ddx += 2.0 * FOLLOW_RAD_S * (self._speed - dx[self.at])
        return ddx
