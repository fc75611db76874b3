"""Distance to a goal around obstacles, and the direction that shortens it.

The search costs a bounded number of cells per call and goes on where it stopped. It answers for the
obstacles as they were when it was set; what it cannot reach it says is infinitely far.
"""

import math
from enum import IntEnum

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.collision.kernel_shapes import is_segment_free
from dforc.collision.obstacles import World
from dforc.errors import DforcError
from dforc.field.guide_kernel import (
    CLOSED_NODES,
    COUNTS,
    EXHAUSTED,
    FOUND,
    IDLE,
    NUMBERS,
    SEARCHING,
    SIGHT,
    STATE,
    Search,
    advance,
    begin,
    lay_grid,
    sight_from,
)
from dforc.field.steer_kernel import steer, trace

MOST_NODES = 120_000  # 8 MB
MOST_PLACES = 64  # of a path; what is beyond is only a length
SIGHT_SHARE = 0.8  # of the clearance of the nodes: what lines between them keep


class GuideError(DforcError, ValueError):
    """A box or a cell that makes no grid."""


class GuideState(IntEnum):
    """What the search knows."""

    IDLE = IDLE
    SEARCHING = SEARCHING
    FOUND = FOUND
    UNREACHABLE = EXHAUSTED


def new_search(most_nodes: int = MOST_NODES) -> Search:
    """Room for a search of so many nodes."""
    counts = np.zeros(COUNTS, dtype=np.int64)
    tables = [np.zeros(most_nodes, dtype=np.int64) for _ in range(5)]
    numbers = [np.zeros(most_nodes) for _ in range(3)]
    return Search(
        numbers=np.zeros(NUMBERS),
        counts=counts,
        marks=tables[0],
        states=tables[1],
        parents=tables[2],
        costs=numbers[0],
        rooms=numbers[1],
        heap=tables[3],
        keys=numbers[2],
        ranks=tables[4],
        ends=np.zeros((4, 3)),
    )


def frozen(world: World) -> World:
    """A copy of the obstacles as they are now."""
    return World(
        kinds=world.kinds.copy(),
        sizes=world.sizes.copy(),
        rotations=world.rotations.copy(),
        centres=world.centres.copy(),
        velocities=world.velocities.copy(),
        margins=world.margins.copy(),
        reaches=world.reaches.copy(),
    )


class Guide:
    """One goal at a time in one box."""

    def __init__(
        self, low_m: ArrayLike, high_m: ArrayLike, cell_m: float, most_nodes: int = MOST_NODES
    ) -> None:
        """Take the box's corners; cells grow where there would be more than `most_nodes`.

        Raises:
            GuideError: a box without inside, or a cell that is not positive.
        """
        low, high = finite_vector("low_m", low_m, 3), finite_vector("high_m", high_m, 3)
        if not (high > low).all() or not 0.0 < cell_m < math.inf:
            raise GuideError(f"no grid from {low} to {high} with cells of {cell_m} m")
        self._search = new_search(most_nodes)
        self._world: World | None = None
        self._goal = np.zeros(3)
        self.cell_m = lay_grid(self._search, low, high, cell_m)

    def set(self, goal_m: ArrayLike, hand_m: ArrayLike, world: World, inflate_m: float) -> None:
        """Begin a search for the way to a goal, `inflate_m` off the obstacles; forget the last.

        It looks towards the hand first, and ends when it has the way from there.
        """
        self._goal = finite_vector("goal_m", goal_m, 3)
        hand = finite_vector("hand_m", hand_m, 3)
        self._world = frozen(world)
        begin(self._search, self._goal, hand, self._world, inflate_m, SIGHT_SHARE * inflate_m)

    @property
    def state(self) -> GuideState:
        """What the search knows by now."""
        return GuideState(int(self._search.counts[STATE]))

    @property
    def cells(self) -> int:
        """How many cells the search has closed."""
        return int(self._search.counts[CLOSED_NODES])

    def advance(self, cells: int) -> GuideState:
        """Close up to so many cells more."""
        if self._world is not None:
            advance(self._search, self._world, cells)
        return self.state

    def direction(self, x_m: ArrayLike) -> tuple[Vector, float]:
        """Unit vector (3,) along the way from here, and how far the goal is; inf if none is known.

        The zero vector where no way is known, and at the goal.
        """
        out = np.zeros(3)
        if self._world is None:
            return out, math.inf
        x = finite_vector("x_m", x_m, 3)
        sight = float(self._search.numbers[SIGHT])
        path, used = self.path(x)
        return out, steer(path, used, x, self._world, sight, out)

    def path(self, x_m: Vector) -> tuple[Matrix, int]:
        """Places from near here to the goal (p, 4), with the way to go; how many rows count."""
        path = np.empty((MOST_PLACES, 4))
        if self._world is None:
            return path, 0
        numbers = self._search.numbers
        spare = min(
            sight_from(x_m, self._world, numbers[SIGHT]),
            sight_from(self._goal, self._world, numbers[SIGHT]),
        )
        if spare > 0.0 and is_segment_free(x_m, self._goal, self._world, spare):
            path[0, :3], path[0, 3] = self._goal, 0.0
            return path, 1
        return path, trace(self._search, x_m, self._world, path)
