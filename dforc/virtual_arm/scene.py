"""A limb among obstacles, as the planner and the search for postures look at it."""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import place_body
from dforc.collision.kernel_nearness import apart
from dforc.collision.kernel_shapes import nearest_on
from dforc.collision.obstacles import World, world_of
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.virtual_arm.kernel_edge import Scene
from dforc.virtual_arm.moving import moving_of

MOST_LOOKS = 60  # postures, at one step of a tree or one shortcut
BETWEEN_M = 0.004  # a distance may fall short of its margin by half of this between two looks
FINEST_M = 0.001  # unless the margin is smaller: then this
INSIDE_M = 1e-6  # a posture that is inside a margin may come nearer by this


class Surroundings:
    """Makes scenes of one limb, for other obstacles and postures of the rest of the body."""

    __slots__ = ("_empty", "mask")

    def __init__(self, body: Body, columns: Indices, mask: NDArray[np.bool_] | None = None) -> None:
        arrays, count = body.arrays, len(body.arrays.carriers)
        moving = moving_of(arrays, columns, mask)
        size = len(arrays.parents)
        self.mask = np.zeros(count, dtype=np.bool_)  # capsules that the limb keeps from obstacles
        self.mask[moving.capsules] = True
        self._empty = Scene(
            body=arrays._replace(pairs=moving.pairs),
            moving=moving,
            world=world_of(()),
            kept=np.zeros((len(moving.capsules), 0)),
            pairs_kept=np.zeros(len(moving.pairs)),
            between=BETWEEN_M,
            looks=MOST_LOOKS,
            misses=1,
            whole=np.zeros(size),
            frames=np.zeros((size, 12)),
            segments=np.zeros((count, 6)),
            speeds=np.zeros(len(moving.capsules)),
            pair_speeds=np.zeros(len(moving.pairs)),
        )

    @property
    def scene(self) -> Scene:
        """Without obstacles and margins; its scratch is shared by all scenes made here."""
        return self._empty

    def scene_of(
        self, world: World, others_q: Vector, margin_m: float, self_margin_m: float
    ) -> Scene:
        """Obstacles, and the joints that are not the limb's (N,)."""
        empty = self._empty
        radii, moving = empty.body.radii, empty.moving
        kept = radii[moving.capsules][:, None] + world.margins + margin_m
        pairs_kept = radii[moving.pairs].sum(axis=1) + self_margin_m
        empty.whole[:] = others_q
        between = max(FINEST_M, 2.0 * min(margin_m, self_margin_m, 0.5 * BETWEEN_M))
        return empty._replace(world=world, kept=kept, pairs_kept=pairs_kept, between=between)


def leavable(scene: Scene, q: Vector) -> Scene:
    """The scene with margins lowered, where q (n,) is inside of them, to what there is at q."""
    least = let_leave(scene, q, INSIDE_M)
    return scene._replace(between=min(scene.between, max(2.0 * least, FINEST_M)))


@compiled
def let_leave(scene: Scene, q: Vector, inside: float) -> float:
    """Lower what is to be kept to what there is at q; the least distance of surfaces there."""
    columns, world, moving = scene.moving.columns, scene.world, scene.moving
    radii = scene.body.radii
    for j in range(len(columns)):
        scene.whole[columns[j]] = q[j]
    place_body(scene.whole, scene.body, scene.frames, scene.segments)
    least = math.inf
    for i in range(len(moving.capsules)):
        capsule = moving.capsules[i]
        for o in range(len(world.kinds)):
            far, _, _, _, _ = nearest_on(o, world, scene.segments[capsule], scene.kept[i, o])
            if far - inside < scene.kept[i, o]:
                least = min(least, far - radii[capsule])
                scene.kept[i, o] = far - inside
    for i in range(len(moving.pairs)):
        first, second = moving.pairs[i, 0], moving.pairs[i, 1]
        far, _, _ = apart(scene.segments, first, second)
        if far - inside < scene.pairs_kept[i]:
            least = min(least, far - radii[first] - radii[second])
            scene.pairs_kept[i] = far - inside
    return least
