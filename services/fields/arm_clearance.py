"""Distances of a limb's surfaces from the objects themselves, without the room around them."""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import proximities
from dforc.collision.obstacles import World
from dforc.virtual_arm.motion import MOST_SURFACES, SELF_REACH_M
from services.fields.mode import Surroundings


class ArmClearance:
    """Of all that a limb's joints move."""

    def __init__(self, body: Body, joints: tuple[str, ...]) -> None:
        """`joints` are the limb's, in the order of its postures."""
        self._body = body
        self._columns = body.columns(joints)
        self._mask = body.moved_by(joints)
        n, count = len(body.joints), len(body.capsules)
        self._q: Vector = np.zeros(n)
        self._frames = np.zeros((n, 12))
        self._segments = np.zeros((count, 6))
        self._distances: Vector = np.zeros(MOST_SURFACES)
        self._gradients = np.zeros((MOST_SURFACES, n))
        self._drifts: Vector = np.zeros(MOST_SURFACES)
        self._which = np.zeros((MOST_SURFACES, 2), dtype=np.int64)

    def of(
        self, q_rad: Vector, around: Surroundings, reach_m: float
    ) -> tuple[float, tuple[str, str]]:
        """The smallest [m], and between what; inf where nothing is nearer than `reach_m`."""
        self._q[:] = around.body_rad
        self._q[self._columns] = q_rad
        count = proximities(
            self._q,
            self._body.arrays,
            solids_of(around),
            self._mask,
            reach_m,
            SELF_REACH_M,
            self._frames,
            self._segments,
            self._distances,
            self._gradients,
            self._drifts,
            self._which,
        )
        if not count:
            return math.inf, ("", "")
        nearest = int(np.argmin(self._distances[:count]))
        capsule, other = (int(i) for i in self._which[nearest])
        names = self._body.capsules
        second = around.obstacles[other].name if other >= 0 else names[-1 - other]
        return float(self._distances[nearest]), (names[capsule], second)


def solids_of(around: Surroundings) -> World:
    """The obstacles where they are now, without what is kept around them."""
    world = around.world
    centres = np.array([one.place_m for one in around.obstacles], dtype=np.float64)
    return world._replace(
        centres=centres.reshape(-1, 3),
        velocities=np.zeros_like(world.velocities),
        margins=np.zeros_like(world.margins),
    )
