"""A way for a limb from one posture to one of several others, without touching anything."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body
from dforc.collision.obstacles import World
from dforc.ik.kernel_chain import Indices
from dforc.limits import JointLimits
from dforc.virtual_arm.kernel_edge import march
from dforc.virtual_arm.kernel_planner import (
    ACTIVE,
    FROM,
    GOAL,
    GOALS,
    LOOKED,
    MET,
    NOWHERE,
    USED_UP,
    grow,
    trace,
    trees_of,
)
from dforc.virtual_arm.kernel_random import room_of, seeds
from dforc.virtual_arm.kernel_shortcut import path_length, straighten
from dforc.virtual_arm.scene import Surroundings, leavable

MOST_NODES = 4000  # of each tree
MOST_LOOKS = 40000  # postures, for one plan
SHORTCUTS = 80  # tries
MOST_GOALS = 16
CLOSELY = 2  # Scene.misses


class PlanState(StrEnum):
    """How far a plan is."""

    SEARCHING = "searching"
    FOUND = "found"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Stretch:
    """How much of a path is free: edges and the share of the last one."""

    reached: float  # the path is free up to here, in edges from its first posture
    blocked: bool  # something stops it there; if not, and more is left, the budget was used up
    looks: int


class PosturePlanner:
    """RRT-Connect in slices, then shortcuts; the same for the same seed and calls."""

    def __init__(
        self,
        body: Body,
        columns: Indices,
        limits: JointLimits,
        seed: int = 0,
        mask: NDArray[np.bool_] | None = None,
        most_looks: int = MOST_LOOKS,
    ) -> None:
        """Args: mask says which capsules count against obstacles; all that the limb moves if None.

        A plan fails once it has looked at `most_looks` postures.
        """
        self._seed, self._most_looks = seed, most_looks
        self._surroundings = Surroundings(body, columns, mask)
        self._scene = self._surroundings.scene
        self._room = room_of(limits)
        self._trees = trees_of(limits.n, MOST_NODES)
        self._way = np.zeros((2 * MOST_NODES + SHORTCUTS + 2, limits.n))
        self._ends = np.zeros((2, limits.n))
        self._count, self._tries, self._state = 0, 0, PlanState.FAILED

    def begin(
        self,
        q_start: Vector,
        goals: Matrix,
        world: World,
        others_q: Vector,
        margin_m: float,
        self_margin_m: float,
        seed: int | None = None,
    ) -> None:
        """Plan from q_start (n,) to any of the postures goals (g, n); the best ones first.

        Margins between what is nearer than that at the start are lowered to what is there, for
        those obstacles or capsules only. Goals inside their margins are left out.

        Args:
            q_start: inside the limits.
            goals: inside the limits.
            world: stays as it is now for this plan.
            others_q: the whole body's posture (N,).
            margin_m: between the body and obstacles, beyond their own.
            self_margin_m: between parts of the body.
            seed: another than the planner's own, for another attempt.
        """
        scene = self._surroundings.scene_of(world, others_q, margin_m, self_margin_m)
        self._scene = leavable(scene, q_start)
        trees = self._trees
        trees.nodes[0, 0] = q_start
        free = [q for q in goals[:MOST_GOALS] if self._is_free(q)]
        for k, q in enumerate(free):
            trees.nodes[1, k] = q
        trees.parents[0, 0] = NOWHERE
        trees.parents[1, : len(free)] = NOWHERE
        trees.counts[:] = 1, len(free)
        trees.state[:2] = seeds(self._seed if seed is None else seed)
        trees.state[ACTIVE], trees.state[FROM], trees.state[LOOKED] = 1, NOWHERE, 0
        trees.state[GOAL], trees.state[GOALS] = 0, len(free)
        self._count, self._tries = 0, 0
        self._state = PlanState.SEARCHING if free else PlanState.FAILED

    def advance(self, looks: int) -> PlanState:
        """Go on until about so many more postures have been looked at."""
        if self._state is not PlanState.SEARCHING:
            return self._state
        trees = self._trees
        if not self._count:
            before = int(trees.state[LOOKED])
            found = grow(self._scene, self._room, trees, looks, self._most_looks)
            looks -= int(trees.state[LOOKED]) - before
            if found == USED_UP:
                self._state = PlanState.FAILED
            if found != MET:
                return self._state
            self._count = int(trace(trees, self._way))
        self._straighten(looks)
        return self._state

    @property
    def path(self) -> Matrix:
        """Postures (k, n) from the start to a goal; straight between them. Empty if not found."""
        count = self._count if self._state is PlanState.FOUND else 0
        path: Matrix = self._way[:count].copy()
        return path

    @property
    def nodes(self) -> int:
        """Postures in both trees."""
        return int(self._trees.counts.sum())

    @property
    def looks(self) -> int:
        """Postures looked at for this plan."""
        return int(self._trees.state[LOOKED])

    def length(self, path: Matrix) -> float:
        """Length of a path in the planner's metric: about the metres that the limb moves."""
        return float(path_length(path, len(path), self._scene.moving.metric))

    def free_along(
        self,
        path: Matrix,
        begin: float,
        world: World,
        others_q: Vector,
        margin_m: float,
        self_margin_m: float,
        looks: int,
    ) -> Stretch:
        """How far a path (k, n) is free from `begin` on, counted in edges, by looks at most.

        Margins are lowered to what there is at `begin`, as for a plan. It is free to its end if
        `reached` is k - 1. If neither that nor blocked, go on from `reached`.
        """
        scene = self._surroundings.scene_of(world, others_q, margin_m, self_margin_m)
        last = len(path) - 1
        edge = min(int(begin), max(0, last - 1))
        share, used = begin - edge, 0
        here = path[edge] + share * (path[min(edge + 1, last)] - path[edge])
        scene = leavable(scene, here)
        while edge < last:
            scene = scene._replace(looks=looks - used, misses=CLOSELY)
            free, blocked, more = march(scene, here, path[edge + 1])
            used += more
            if free < 1.0:
                return Stretch(edge + share + free * (1.0 - share), bool(blocked), used)
            edge, share, here = edge + 1, 0.0, path[edge + 1]
            if used >= looks:
                break
        return Stretch(float(edge), False, used)

    def is_path_free(
        self,
        path: Matrix,
        begin: float,
        world: World,
        others_q: Vector,
        margin_m: float,
        self_margin_m: float,
        looks: int,
    ) -> bool:
        """Whether nothing stops a path as far as so many looks tell."""
        return not self.free_along(
            path, begin, world, others_q, margin_m, self_margin_m, looks
        ).blocked

    def free_length(
        self,
        q_a: Vector,
        q_b: Vector,
        world: World,
        others_q: Vector,
        margin_m: float,
        self_margin_m: float,
        looks: int,
    ) -> float:
        """Which share (0 to 1) of the straight way from q_a to q_b is free; as `free_along`."""
        both = np.stack([q_a, q_b])
        return self.free_along(both, 0.0, world, others_q, margin_m, self_margin_m, looks).reached

    def _is_free(self, q: Vector) -> bool:
        free, _, _ = march(self._scene, q, q)
        return bool(free >= 1.0)

    def _straighten(self, looks: int) -> None:
        trees = self._trees
        count, tried, looked = straighten(
            self._scene,
            trees.state,
            self._way,
            self._count,
            self._ends,
            SHORTCUTS - self._tries,
            max(looks, 0),
        )
        self._count = int(count)
        self._tries += int(tried)
        trees.state[LOOKED] += looked
        if self._tries >= SHORTCUTS or self._count <= 2:
            self._state = PlanState.FOUND
