"""Distance to a goal around obstacles on a grid, in steps of a bounded number of cells, for numba.

Lazy Theta* (Nash, Koenig, Tovey 2010) from the goal to the hand: a node's parent is any node that
it sees, so a chain of parents is a taut string and not a staircase. Nodes are at least `clearance`
from every obstacle; whoever sees each other does so with `sight` to spare, which is a little less.
Sight is exact (dforc.collision), so nothing thin is jumped over, however coarse the grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.kernel_shapes import is_segment_free, world_distance
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.field.heap_kernel import lift, pop

Indices = NDArray[np.int64]

# Places in `numbers`: the grid, the two clearances, both ends, the shortest length known.
ORIGIN, CELL, CLEARANCE, SIGHT, GOAL, HAND, BEST = 0, 3, 4, 5, 6, 9, 12
NUMBERS = 13
# Places in `counts`.
SIZE, RUN, WAITING, STATE, CLOSED_NODES, SEEN = 0, 3, 4, 5, 6, 7
COUNTS = 8

IDLE, SEARCHING, FOUND, EXHAUSTED = 0, 1, 2, 3  # STATE
BLOCKED, FREE, OPEN, CLOSED = 0, 1, 2, 3  # of a node that this search has touched
AT_GOAL = -1  # parent of nodes that see the goal
NOBODY = -2
NEAR_CELLS = 2  # nodes around an end, each way, that may be joined to it
ROUNDING_M = 1e-9


class Search(NamedTuple):
    """One search; N nodes at most."""

    numbers: Vector  # (NUMBERS,)
    counts: Indices  # (COUNTS,)
    marks: Indices  # (N,) the search that touched the node last
    states: Indices  # (N,)
    parents: Indices  # (N,)
    costs: Vector  # (N,) length of the string from the goal [m]
    rooms: Vector  # (N,) distance from the nearest obstacle's margin [m]
    heap: Indices  # (N,) nodes, the most promising first
    keys: Vector  # (N,) cost and distance from the hand, of each node
    ranks: Indices  # (N,) place of each open node in the heap
    ends: Matrix  # (4, 3) room for places


@compiled
def lay_grid(search: Search, low: Vector, high: Vector, cell: float) -> float:
    """Put the grid over a box, with larger cells where it would have too many; the cell [m]."""
    numbers, counts = search.numbers, search.counts
    most = len(search.marks)
    while True:
        total = 1
        for k in range(3):
            counts[SIZE + k] = math.ceil((high[k] - low[k]) / cell - ROUNDING_M) + 1
            total *= counts[SIZE + k]
        if total <= most:
            break
        cell *= 1.05
    for k in range(3):
        numbers[ORIGIN + k] = low[k]
    numbers[CELL] = cell
    return cell


@compiled
def place_of(search: Search, node: int, out: Vector) -> None:
    """Where a node, or the goal, is."""
    numbers, counts = search.numbers, search.counts
    if node == AT_GOAL:
        for k in range(3):
            out[k] = numbers[GOAL + k]
        return
    plane = counts[SIZE + 1] * counts[SIZE + 2]
    out[0] = numbers[ORIGIN] + numbers[CELL] * (node // plane)
    out[1] = numbers[ORIGIN + 1] + numbers[CELL] * (node % plane // counts[SIZE + 2])
    out[2] = numbers[ORIGIN + 2] + numbers[CELL] * (node % counts[SIZE + 2])


@compiled
def length_between(a: Vector, b: Vector) -> float:
    """Length of b - a."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    return math.sqrt(x * x + y * y + z * z)


@compiled
def sight_from(x: Vector, world: World, sight: float) -> float:
    """What a line from here can have to spare: `sight`, or less if here is nearer to something."""
    return min(sight, world_distance(x, world) - ROUNDING_M)


@compiled
def range_around(search: Search, x: Vector, k: int) -> tuple[int, int]:
    """Nodes near a place along axis k: the first, and one behind the last."""
    at = math.floor((x[k] - search.numbers[ORIGIN + k]) / search.numbers[CELL])
    return max(0, at - NEAR_CELLS + 1), min(search.counts[SIZE + k], at + NEAR_CELLS + 1)


@compiled
def touch(search: Search, node: int, world: World) -> int:
    """State of a node; its distance from the obstacles is looked up at the first touch."""
    if search.marks[node] != search.counts[RUN]:
        here = search.ends[3]
        place_of(search, node, here)
        search.marks[node] = search.counts[RUN]
        search.rooms[node] = world_distance(here, world)
        is_free = search.rooms[node] >= search.numbers[CLEARANCE]
        search.states[node] = FREE if is_free else BLOCKED
        search.costs[node] = math.inf
    return int(search.states[node])


@compiled
def offer(search: Search, node: int, place: Vector, parent: int, cost: float) -> None:
    """Give a node this parent if that makes its string shorter."""
    if cost >= search.costs[node] - ROUNDING_M:
        return
    numbers, counts = search.numbers, search.counts
    search.costs[node], search.parents[node] = cost, parent
    search.keys[node] = cost + length_between(place, numbers[HAND : HAND + 3])
    if search.states[node] != OPEN:
        search.states[node] = OPEN
        search.heap[counts[WAITING]] = node
        search.ranks[node] = counts[WAITING]
        counts[WAITING] += 1
    lift(search.heap, search.keys, search.ranks, search.ranks[node])


@compiled
def begin(
    search: Search, goal: Vector, hand: Vector, world: World, clearance: float, sight: float
) -> None:
    """Start a search; the grid is laid. `world` must stay as it is until the search ends."""
    numbers, counts = search.numbers, search.counts
    for k in range(3):
        numbers[GOAL + k], numbers[HAND + k] = goal[k], hand[k]
    numbers[CLEARANCE], numbers[SIGHT], numbers[BEST] = clearance, sight, math.inf
    counts[RUN] += 1
    counts[WAITING], counts[CLOSED_NODES], counts[STATE] = 0, 0, SEARCHING
    counts[SEEN] = NOBODY
    spare = sight_from(goal, world, sight)
    both = min(spare, sight_from(hand, world, sight))
    if spare < 0.0 or (both >= 0.0 and is_segment_free(goal, hand, world, both)):
        if spare >= 0.0:
            counts[SEEN], numbers[BEST] = AT_GOAL, length_between(goal, hand)
        return  # with no node to look at: the next step ends the search
    place = search.ends[0]
    (i0, i1), (j0, j1) = range_around(search, goal, 0), range_around(search, goal, 1)
    k0, k1 = range_around(search, goal, 2)
    for i in range(i0, i1):
        for j in range(j0, j1):
            for k in range(k0, k1):
                node = (i * counts[SIZE + 1] + j) * counts[SIZE + 2] + k
                if touch(search, node, world) != FREE:
                    continue
                place_of(search, node, place)
                if is_segment_free(place, numbers[GOAL : GOAL + 3], world, spare):
                    offer(search, node, place, AT_GOAL, length_between(place, goal))


@compiled
def sees_near(search: Search, a: int, b: int, world: World) -> bool:
    """Whether two nodes see each other: at once where their own distances leave no doubt."""
    pa, pb = search.ends[1], search.ends[2]
    place_of(search, a, pa)
    place_of(search, b, pb)
    least = 0.5 * (search.rooms[a] + search.rooms[b] - length_between(pa, pb))
    return least >= search.numbers[SIGHT] or is_segment_free(pa, pb, world, search.numbers[SIGHT])


@compiled
def settle(search: Search, node: int, place: Vector, world: World) -> None:
    """Close a node: if it does not see its parent, the best closed neighbour becomes that."""
    search.states[node] = CLOSED
    search.counts[CLOSED_NODES] += 1
    parent = search.parents[node]
    if parent == AT_GOAL:
        spare = sight_from(search.numbers[GOAL : GOAL + 3], world, search.numbers[SIGHT])
    else:
        spare = search.numbers[SIGHT]
    other = search.ends[1]
    place_of(search, parent, other)
    if is_segment_free(place, other, world, spare):
        return
    search.costs[node] = math.inf
    counts, cell = search.counts, search.numbers[CELL]
    width, depth = counts[SIZE + 1], counts[SIZE + 2]
    x, y, z = node // (width * depth), node // depth % width, node % depth
    for i in range(max(0, x - 1), min(counts[SIZE], x + 2)):
        for j in range(max(0, y - 1), min(width, y + 2)):
            for k in range(max(0, z - 1), min(depth, z + 2)):
                near = (i * width + j) * depth + k
                if near == node or search.marks[near] != counts[RUN]:
                    continue
                far = cell * math.sqrt((i - x) ** 2 + (j - y) ** 2 + (k - z) ** 2)
                cost = search.costs[near] + far
                if search.states[near] != CLOSED or cost >= search.costs[node]:
                    continue
                if sees_near(search, near, node, world):
                    search.costs[node], search.parents[node] = cost, near


@compiled
def spread(search: Search, node: int, world: World) -> None:
    """Offer a closed node's parent to its neighbours."""
    counts = search.counts
    width, depth = counts[SIZE + 1], counts[SIZE + 2]
    x, y, z = node // (width * depth), node // depth % width, node % depth
    parent = search.parents[node]
    from_place, place = np.empty(3), np.empty(3)
    place_of(search, parent, from_place)
    cost = 0.0 if parent == AT_GOAL else search.costs[parent]
    for i in range(max(0, x - 1), min(counts[SIZE], x + 2)):
        for j in range(max(0, y - 1), min(width, y + 2)):
            for k in range(max(0, z - 1), min(depth, z + 2)):
                near = (i * width + j) * depth + k
                state = touch(search, near, world)
                if state in (BLOCKED, CLOSED):
                    continue
                place_of(search, near, place)
                total = cost + length_between(from_place, place)
                if total < search.costs[near] - ROUNDING_M and sees_near(search, node, near, world):
                    offer(search, near, place, parent, total)


@compiled
def meet_hand(search: Search, node: int, place: Vector, world: World, spare: float) -> None:
    """Join the hand to a closed node that it sees."""
    numbers = search.numbers
    hand = numbers[HAND : HAND + 3]
    total = search.costs[node] + length_between(place, hand)
    if spare < 0.0 or total >= numbers[BEST]:
        return
    if is_segment_free(place, hand, world, spare):
        numbers[BEST], search.counts[SEEN] = total, node


@compiled
def advance(search: Search, world: World, cells: int) -> int:
    """Close up to so many nodes; the state of the search."""
    counts = search.counts
    place = np.empty(3)
    spare = sight_from(search.numbers[HAND : HAND + 3], world, search.numbers[SIGHT])
    for _ in range(cells):
        if counts[STATE] != SEARCHING:
            break
        if counts[WAITING] == 0:
            counts[STATE] = FOUND if search.numbers[BEST] < math.inf else EXHAUSTED
            break
        if search.keys[search.heap[0]] >= search.numbers[BEST]:
            counts[STATE] = FOUND
            break
        node = pop(search.heap, search.keys, search.ranks, counts[WAITING])
        counts[WAITING] -= 1
        place_of(search, node, place)
        settle(search, node, place, world)
        if search.costs[node] == math.inf:
            search.states[node] = FREE
            continue
        meet_hand(search, node, place, world, spare)
        spread(search, node, world)
    return int(counts[STATE])
