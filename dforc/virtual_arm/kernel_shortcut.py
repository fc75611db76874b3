"""Shorter ways along a path of postures, for numba."""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.virtual_arm.kernel_edge import Scene, march
from dforc.virtual_arm.kernel_planner import distance
from dforc.virtual_arm.kernel_random import uniform

MOST_LOOKS = 80  # postures of one shortcut
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
def shorten(
    scene: Scene, draws: Indices, path: Matrix, count: int, ends: Matrix
) -> tuple[int, int]:
    """Try one shortcut between two places at random: new count, and postures looked at."""
    metric, (a, b) = scene.moving.metric, (ends[0], ends[1])
    length = path_length(path, count, metric)
    before, behind = uniform(draws) * length, uniform(draws) * length
    if before > behind:
        before, behind = behind, before
    first = point_at(path, count, metric, before, a)
    last = point_at(path, count, metric, behind, b)
    if first == last or distance(metric, a, b) > WORTH * (behind - before):
        return count, 0
    free, _, looks = march(scene, a, b, MOST_LOOKS, False)
    if free < 1.0:
        return count, looks
    return cut(path, count, first, last, a, b), looks


@compiled
def straighten(
    scene: Scene, draws: Indices, path: Matrix, count: int, ends: Matrix, tries: int, looks: int
) -> tuple[int, int, int]:
    """Try shortcuts until the tries or the postures to look at are used up.

    Returns the new count of postures, the tries taken and the postures looked at.
    """
    looked, tried = 0, 0
    while tried < tries and looked < looks and count > 2:
        count, more = shorten(scene, draws, path, count, ends)
        looked += more
        tried += 1
    return count, tried, looked
