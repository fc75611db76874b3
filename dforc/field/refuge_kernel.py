"""The nearest place that is clear of all obstacles, for numba.

Rays leave in fixed directions, along the normals and towards a preferred place; the shortest way
out is then narrowed down around its own direction. Along a ray the way to the clearance still
missing is never jumped over, so a ray finds its first clear place.
"""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.collision.kernel_shapes import point_distance, world_distance
from dforc.collision.obstacles import World
from dforc.compiled import compiled

FARTHEST_M = 1.0
SHORTEST_STEP_M = 1e-4
MOST_STEPS = 400
ROUNDS, FIRST_TURN = 8, 0.35  # of narrowing down; the first turns by about 20 degrees


@compiled
def way_out(x: Vector, world: World, clearance: float, direction: Vector, at_most: float) -> float:
    """How far along a direction the first place with the clearance is; inf beyond `at_most`."""
    place = np.empty(3)
    far = 0.0
    for _ in range(MOST_STEPS):
        for k in range(3):
            place[k] = x[k] + far * direction[k]
        missing = clearance - world_distance(place, world)
        if missing <= 0.0:
            return far
        far += max(missing, SHORTEST_STEP_M)
        if far > at_most:
            break
    return math.inf


@compiled
def unit(direction: Vector) -> bool:
    """Scale to length 1; False for the zero vector."""
    size = math.sqrt(direction[0] ** 2 + direction[1] ** 2 + direction[2] ** 2)
    if size <= 1e-12:
        return False
    for k in range(3):
        direction[k] /= size
    return True


@compiled
def shorter(
    x: Vector, world: World, clearance: float, trial: Vector, best: Vector, least: float
) -> float:
    """Keep a direction if its way out is shorter than the best one's."""
    if not unit(trial):
        return least
    far = way_out(x, world, clearance, trial, min(least, FARTHEST_M))
    if far < least - 1e-6:
        best[:] = trial
        return far
    return least


@compiled
def refuge(x: Vector, world: World, clearance: float, preferred: Vector, out: Vector) -> float:
    """Nearest place with the clearance, into `out`; its distance, or inf if there is none near.

    Of places equally near the one towards `preferred` (a direction, or zero) is taken.
    """
    out[:] = x
    if world_distance(x, world) >= clearance:
        return 0.0
    best = np.zeros(3)
    least = look_around(x, world, clearance, preferred, best)
    if least < math.inf:
        least = narrow_down(x, world, clearance, best, least)
        for k in range(3):
            out[k] = x[k] + least * best[k]
    return least


@compiled
def look_around(
    x: Vector, world: World, clearance: float, preferred: Vector, best: Vector
) -> float:
    """The best of the preferred direction, the normals and 26 fixed directions; its way out."""
    trial, normal = np.empty(3), np.empty(3)
    trial[:] = preferred
    least = shorter(x, world, clearance, trial, best, math.inf)
    for i in range(len(world.kinds)):
        far = point_distance(
            world.kinds[i], world.sizes[i], world.rotations[i], world.centres[i], x, normal
        )
        if far - world.margins[i] < clearance:
            trial[:] = normal
            least = shorter(x, world, clearance, trial, best, least)
    for i in range(-1, 2):
        for j in range(-1, 2):
            for k in range(-1, 2):
                trial[0], trial[1], trial[2] = i, j, k
                least = shorter(x, world, clearance, trial, best, least)
    return least


@compiled
def narrow_down(x: Vector, world: World, clearance: float, best: Vector, least: float) -> float:
    """Turn the best direction while that shortens its way out."""
    turn = FIRST_TURN
    centre, trial = np.empty(3), np.empty(3)
    for _ in range(ROUNDS):
        centre[:] = best
        for axis in range(3):
            for side in (-1.0, 1.0):
                trial[:] = centre
                trial[axis] += side * turn
                least = shorter(x, world, clearance, trial, best, least)
        turn *= 0.6
    return least
