"""How far one solid is from parts of a body, for whoever judges a motion."""

from collections.abc import Sequence

import numpy as np

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import place_body
from dforc.collision.kernel_shapes import segment_distance
from dforc.collision.obstacles import Obstacle, world_of


class BodyClearance:
    """Of the capsules that some joints move."""

    def __init__(self, body: Body, joints: Sequence[str]) -> None:
        """`joints` of the body; their order is that of the postures."""
        self._body = body
        self._columns = body.columns(joints)
        self._moved = np.flatnonzero(body.moved_by(joints))
        self._q: Vector = np.zeros(len(body.joints))
        self._frames = np.zeros((len(body.joints), 12))
        self._segments = np.zeros((len(body.capsules), 6))
        self._normal: Vector = np.zeros(3)

    def of(self, q_rad: Vector, obstacle: Obstacle) -> float:
        """Distance [m] of the surfaces at a posture (n,); negative when they overlap.

        All other joints of the body are at zero; they move none of these capsules.
        """
        world = world_of([obstacle])
        self._q[self._columns] = q_rad
        place_body(self._q, self._body.arrays, self._frames, self._segments)
        least = np.inf
        for capsule in self._moved:
            a, b = self._segments[capsule, :3], self._segments[capsule, 3:]
            distance, _ = segment_distance(
                world.kinds[0],
                world.sizes[0],
                world.rotations[0],
                world.centres[0],
                a,
                b,
                self._normal,
            )
            least = min(least, float(distance) - float(self._body.arrays.radii[capsule]))
        return least - obstacle.margin_m
