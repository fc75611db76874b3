"""What surrounds the emulated robot: somebody's hands, and somebody who writes down the truth.

It acts on the plant between two milliseconds, beside the stack and its messages.
"""

from collections.abc import Sequence

import numpy as np

from dforc.arrays import Matrix, Vector
from firmware_sim.rig import Rig
from services.experiments.loops.limbs import Point

TICK_S = 0.001
HAND_N_M = 1500.0  # a firm grip
HAND_NS_M = 80.0
STRONGEST_N = 60.0


class Grip:
    """A hand that holds a point of the robot: a spring and a damper to where the hand is."""

    def __init__(self, point: Point, columns: Sequence[int]) -> None:
        """`columns` of the point's joints among the rig's."""
        self.point = point
        self.force_n: Vector = np.zeros(3)
        self._columns = list(columns)
        self._target_m: Vector | None = None
        self.speed_m_s: Vector = np.zeros(3)  # of the hand

    def tick(self, rig: Rig) -> None:
        """Push for the coming millisecond."""
        q, dq = rig.plant.q_rad[self._columns], rig.plant.dq_rad_s[self._columns]
        place = self.point.place_m(q)
        if self._target_m is None:
            self._target_m = place.copy()
        self._target_m += TICK_S * self.speed_m_s
        slip = self.speed_m_s - self.point.jacobian(q) @ dq
        force = HAND_N_M * (self._target_m - place) + HAND_NS_M * slip
        size = float(np.linalg.norm(force))
        self.force_n = force * min(1.0, STRONGEST_N / max(size, 1e-9))
        rig.push(self.force_n.tolist(), TICK_S, self.point.frame, self.point.point_m)


class World:
    """Grips, pushes, and every joint's true angle each millisecond."""

    def __init__(self) -> None:
        self.grips: list[Grip] = []
        self._rig: Rig | None = None
        self._angles: list[Vector] = []

    def surround(self, rig: Rig) -> None:
        """Take the robot that is to be watched."""
        self._rig = rig

    @property
    def rig(self) -> Rig:
        """The robot."""
        assert self._rig is not None, "nobody has called surround()"
        return self._rig

    def tick(self) -> None:
        """Between two milliseconds."""
        self._angles.append(self.rig.plant.q_rad.copy())
        for grip in self.grips:
            grip.tick(self.rig)

    def grip(self, point: Point) -> Grip:
        """Begin to hold a point where it is."""
        grip = Grip(point, self.columns(point.joints))
        self.grips.append(grip)
        return grip

    def let_go(self) -> None:
        """End every grip."""
        self.grips.clear()

    def columns(self, joints: Sequence[str]) -> list[int]:
        """Where joints stand in the truth."""
        names = self.rig.joints
        return [names.index(joint) for joint in joints]

    @property
    def ticks(self) -> int:
        """Milliseconds watched so far."""
        return len(self._angles)

    def angles(self, joints: Sequence[str], first: int, last: int) -> Matrix:
        """True angles (rad), a row for each millisecond from `first` up to `last`."""
        rows: Matrix = np.array(self._angles[first:last])[:, self.columns(joints)]
        return rows

    def mean(self, joints: Sequence[str], seconds: float) -> Vector:
        """Mean angles (rad) over the last moments."""
        mean: Vector = self.angles(joints, self.ticks - round(seconds / TICK_S), self.ticks).mean(0)
        return mean
