"""From a finished search to a direction: the taut string from a place, and how far it is seen.

For numba. A path is a table (p, 4): places from the hand's end to the goal, and from each how far
the goal is.
"""

import math

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.collision.kernel_shapes import is_segment_free
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.field.guide_kernel import (
    AT_GOAL,
    CLOSED,
    NOBODY,
    RUN,
    SEEN,
    SIGHT,
    SIZE,
    Search,
    length_between,
    place_of,
    range_around,
    sight_from,
)

HALVINGS = 10  # of the leg that is seen in part


@compiled
def nearest_node(search: Search, x: Vector, world: World) -> int:
    """The closed node that a place sees with the shortest way to the goal; or NOBODY."""
    counts = search.counts
    spare = sight_from(x, world, search.numbers[SIGHT])
    best, least = NOBODY, math.inf
    place = np.empty(3)
    seen = counts[SEEN]
    if seen >= AT_GOAL:  # the node that the hand saw may be seen from here, too
        place_of(search, seen, place)
        if is_segment_free(place, x, world, min(spare, sight_from(place, world, spare))):
            best, least = seen, length_between(place, x)
            least += 0.0 if seen == AT_GOAL else search.costs[seen]
    (i0, i1), (j0, j1) = range_around(search, x, 0), range_around(search, x, 1)
    k0, k1 = range_around(search, x, 2)
    for i in range(i0, i1):
        for j in range(j0, j1):
            for k in range(k0, k1):
                node = (i * counts[SIZE + 1] + j) * counts[SIZE + 2] + k
                if search.marks[node] != counts[RUN] or search.states[node] != CLOSED:
                    continue
                place_of(search, node, place)
                total = search.costs[node] + length_between(place, x)
                if total < least and is_segment_free(place, x, world, spare):
                    best, least = node, total
    return best


@compiled
def trace(search: Search, x: Vector, world: World, path: Matrix) -> int:
    """The path from near a place to the goal; its number of places, 0 if the search knows none."""
    node = nearest_node(search, x, world)
    if node < AT_GOAL:
        return 0
    used = 0
    while used < len(path):
        place_of(search, node, path[used, :3])
        path[used, 3] = 0.0 if node == AT_GOAL else search.costs[node]
        used += 1
        if node == AT_GOAL:
            break
        node = search.parents[node]
    return used


@compiled
def steer(path: Matrix, used: int, x: Vector, world: World, sight: float, out: Vector) -> float:
    """Unit vector to the farthest place on a path that is seen, and the way to go; inf if none."""
    spare = sight_from(x, world, sight)
    seen = used - 1 if spare >= 0.0 else -1
    while seen >= 0:
        # The goal may be nearer to an obstacle than the string is.
        needed = spare
        if path[seen, 3] == 0.0:
            needed = min(spare, sight_from(path[seen, :3], world, sight))
        if is_segment_free(x, path[seen, :3], world, needed):
            break
        seen -= 1
    if seen < 0:
        out[:] = 0.0
        return math.inf
    share = 0.0
    ahead = np.empty(3)
    if seen + 1 < used:
        share = seen_share(path[seen], path[seen + 1], x, world, spare, ahead)
    last = min(seen + 1, used - 1)
    leg = length_between(path[seen, :3], path[last, :3])
    for k in range(3):
        ahead[k] = path[seen, k] + share * (path[last, k] - path[seen, k])
    length = length_between(x, ahead)
    for k in range(3):
        out[k] = (ahead[k] - x[k]) / length if length > 0.0 else 0.0
    return length + (1.0 - share) * leg + float(path[last, 3])


@compiled
def seen_share(a: Vector, b: Vector, x: Vector, world: World, spare: float, ahead: Vector) -> float:
    """How far from a towards b a leg is seen from x; a is seen and b is not."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        for k in range(3):
            ahead[k] = a[k] + middle * (b[k] - a[k])
        if is_segment_free(x, ahead, world, spare):
            low = middle
        else:
            high = middle
    return low
