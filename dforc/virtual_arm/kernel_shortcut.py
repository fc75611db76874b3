"""Shorter ways along a path of postures, for numba."""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.virtual_arm.kernel_edge import Scene, march
from dforc.virtual_arm.kernel_planner import distance
from dforc.virtual_arm.kernel_random import uniform

ON_THE_WAY = 1e-12  # of a length, by which rounding makes a straight way longer
WORTH = 0.999  # of the length that is cut


@compiled
def path_length(path: Matrix, count: int, metric: Vector) -> float:
    """Length of the first `count` postures, in their metric."""
    length = 0.0
    for k in range(count - 1):
        length += distance(metric, path[k], path[k + 1])
    return length


@compiled
def point_at(path: Matrix, count: int, metric: Vector, along: float, q: Vector) -> int:
    """The posture so far along the path into q; the number of the edge it is on."""
    for k in range(count - 1):
        piece = distance(metric, path[k], path[k + 1])
        if along <= piece or k == count - 2:
            share = min(1.0, along / piece) if piece > 0.0 else 0.0
            for j in range(len(q)):
                q[j] = path[k, j] + share * (path[k + 1, j] - path[k, j])
            return k
        along -= piece
    return 0


@compiled
def cut(path: Matrix, count: int, first: int, last: int, a: Vector, b: Vector) -> int:
    """Go straight from a, on edge `first`, to b, on the later edge `last`; the new count."""
    fewer = last - first - 2
    if fewer < 0:
        for k in range(count - 1, last, -1):
            path[k - fewer] = path[k]
    else:
        for k in range(last + 1, count):
            path[k - fewer] = path[k]
    path[first + 1] = a
    path[first + 2] = b
    return count - fewer


@compiled
def choose_ends(
    draws: Indices, path: Matrix, count: int, metric: Vector, ends: Matrix
) -> tuple[int, int]:
    """Two places on a path at random, into `ends` (2, n), and their edges; 0, 0 if of no use."""
    length = path_length(path, count, metric)
    before, behind = uniform(draws) * length, uniform(draws) * length
    if before > behind:
        before, behind = behind, before
    first = point_at(path, count, metric, before, ends[0])
    last = point_at(path, count, metric, behind, ends[1])
    if distance(metric, ends[0], ends[1]) > WORTH * (behind - before):
        return 0, 0
    return first, last


@compiled
def tidy(path: Matrix, count: int, metric: Vector) -> int:
    """Leave out postures that are on the straight way between others; the new count."""
    kept = 1
    for k in range(1, count):
        if k < count - 1:
            before = distance(metric, path[kept - 1], path[k])
            behind = distance(metric, path[k], path[k + 1])
            through = distance(metric, path[kept - 1], path[k + 1])
            if before + behind <= through + ON_THE_WAY * (before + behind):
                continue
        path[kept] = path[k]
        kept += 1
    return kept


@compiled
def straighten(
    scene: Scene, draws: Indices, path: Matrix, count: int, ends: Matrix, tries: int, looks: int
) -> tuple[int, int, int]:
    """Try shortcuts until the tries or the postures to look at are used up.

    Returns the new count of postures, the tries taken and the postures looked at.
    """
    metric, looked, tried = scene.moving.metric, 0, 0
    count = tidy(path, count, metric)
    while tried < tries and looked < looks and count > 2:
        first, last = choose_ends(draws, path, count, metric, ends)
        tried += 1
        if first < last:
            free, _, more = march(scene, ends[0], ends[1])
            looked += more
            if free >= 1.0:
                count = cut(path, count, first, last, ends[0], ends[1])
    return tidy(path, count, metric), tried, looked
