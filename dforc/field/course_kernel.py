"""The way that a point takes: straight where it sees the goal, else along a path kept fresh.

For numba. Searches run in the background, so many cells per step, from the obstacles as they were
when a search began; meanwhile the last path is followed as far as it is seen. A goal that is not
reached with a comfortable clearance is tried with smaller ones on finer grids.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.kernel_shapes import is_segment_free, point_distance, world_distance
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.field.guide_kernel import (
    CLOSED_NODES,
    EXHAUSTED,
    FOUND,
    IDLE,
    SEARCHING,
    STATE,
    Search,
    advance,
    begin,
    lay_grid,
    length_between,
    sight_from,
)
from dforc.field.steer_kernel import steer, trace

Indices = NDArray[np.int64]

# Places in `marks`.
USED, LEVEL, TRIED, COUNT, TOTAL, UNREACHABLE, STEPS, CUT = 0, 1, 2, 3, 4, 5, 6, 7
MARKS = 8
# Columns of `levels`.
MARGIN, SIGHT_M, CLEARANCE_M, CELL_M, FARTHEST_M = 0, 1, 2, 3, 4

STALE_M = 0.004  # what may move that far without a new search
STALE_TURN = 0.02  # change of an entry of an obstacle's rotation
PAD_M = 0.08  # of the grid around hand, goal and obstacles
LEAD_S = 0.3  # a moving obstacle is in the way where it is, and where it will be then
LEAD_M_S = 0.03  # for slower ones that is the same
MOST_CELLS = 6000  # of a search: then a finer one is tried first
NOT_CUT, WAS_CUT, UNCUT = 0, 1, 2  # CUT: none was, one was, and this one will not be
BACK_AFTER = 400  # cells; a longer search is also made from the hand, which may be what is enclosed
OBSTACLES = 10  # so many more obstacles halve the cells that a step may cost
CARRIED_SHARE = 2.0  # clearances: nearer places of a path go with a moving obstacle


class Course(NamedTuple):
    """A path, and the search for the next."""

    search: Search
    back: Search  # from the hand
    path: Matrix  # (p, 4)
    marks: Indices  # (MARKS,)
    goal: Vector  # (3,) of the search
    basis: World  # room for 2 m obstacles: as the search knows them, then where they will be
    # (levels, 5) margin of the barrier, sight, clearance, cell, and the grid beyond both ends [m]
    levels: Matrix


@compiled
def is_stale(course: Course, goal: Vector, world: World) -> bool:
    """Whether the last search began in a world that was noticeably different."""
    basis, count = course.basis, len(world.kinds)
    if course.marks[COUNT] != count or length_between(goal, course.goal) > STALE_M:
        return True
    for i in range(count):
        if world.kinds[i] != basis.kinds[i]:
            return True
        change = length_between(world.centres[i], basis.centres[i])
        change = max(change, abs(world.margins[i] - basis.margins[i]))
        for k in range(3):
            change = max(change, abs(world.sizes[i, k] - basis.sizes[i, k]))
        if change > STALE_M:
            return True
        for k in range(9):
            if abs(world.rotations[i, k] - basis.rotations[i, k]) > STALE_TURN:
                return True
    return False


@compiled
def copy_obstacle(world: World, i: int, basis: World, at: int, lead: float) -> None:
    """Put an obstacle, as it will be after `lead` seconds, into the search's world."""
    basis.kinds[at] = world.kinds[i]
    basis.margins[at], basis.reaches[at] = world.margins[i], world.reaches[i]
    for k in range(3):
        basis.sizes[at, k] = world.sizes[i, k]
        basis.velocities[at, k] = world.velocities[i, k]
        basis.centres[at, k] = world.centres[i, k] + lead * world.velocities[i, k]
    for k in range(9):
        basis.rotations[at, k] = world.rotations[i, k]


@compiled
def first_of(basis: World, total: int) -> World:
    """The obstacles that are in use."""
    return World(
        basis.kinds[:total],
        basis.sizes[:total],
        basis.rotations[:total],
        basis.centres[:total],
        basis.velocities[:total],
        basis.margins[:total],
        basis.reaches[:total],
    )


@compiled
def freeze(course: Course, goal: Vector, x: Vector, world: World) -> None:
    """Keep the obstacles for a search: as they are and, off both ends, as they will be."""
    count = len(world.kinds)
    for i in range(count):
        copy_obstacle(world, i, course.basis, i, 0.0)
    total = count
    for i in range(count):
        if length_between(world.velocities[i], np.zeros(3)) < LEAD_M_S:
            continue
        copy_obstacle(world, i, course.basis, total, LEAD_S)
        total += 1
    clearance = course.levels[0, CLEARANCE_M]
    led = first_of(course.basis, total)
    if total > count and min(world_distance(goal, led), world_distance(x, led)) < clearance:
        total = count
    course.marks[COUNT], course.marks[TOTAL] = count, total
    for k in range(3):
        course.goal[k] = goal[k]


@compiled
def start_search(course: Course, goal: Vector, x: Vector, world: World, level: int) -> None:
    """Look for a way with the clearance of a level."""
    freeze(course, goal, x, world)
    basis = first_of(course.basis, course.marks[TOTAL])
    levels, low, high = course.levels, np.empty(3), np.empty(3)
    farthest = levels[level, FARTHEST_M]
    for k in range(3):
        least, most = min(goal[k], x[k]), max(goal[k], x[k])
        low[k], high[k] = least - PAD_M, most + PAD_M
        for i in range(len(basis.kinds)):
            reach = basis.reaches[i] + basis.margins[i] + PAD_M
            low[k] = min(low[k], max(basis.centres[i, k] - reach, least - farthest))
            high[k] = max(high[k], min(basis.centres[i, k] + reach, most + farthest))
    clearance, sight, cell = (
        levels[level, CLEARANCE_M],
        levels[level, SIGHT_M],
        levels[level, CELL_M],
    )
    course.marks[TRIED], course.marks[STEPS] = level, 0
    lay_grid(course.search, low, high, cell)
    begin(course.search, goal, x, basis, clearance, sight)
    lay_grid(course.back, low, high, cell)
    begin(course.back, x, goal, basis, clearance, sight)


@compiled
def spend(course: Course, basis: World, cells: int) -> int:
    """Spend cells on the search; FOUND, EXHAUSTED if either end is enclosed, or SEARCHING."""
    state = advance(course.search, basis, cells)
    closed = course.search.counts[CLOSED_NODES]
    if state != SEARCHING or closed < BACK_AFTER:
        return state
    if advance(course.back, basis, cells) == EXHAUSTED:
        return EXHAUSTED
    if closed > MOST_CELLS and course.marks[CUT] != UNCUT:
        course.marks[CUT] = WAS_CUT
        return EXHAUSTED
    return SEARCHING


@compiled
def go_on(course: Course, x: Vector, goal: Vector, world: World, cells: int, dt: float) -> None:
    """Spend the step's cells on the search, and take over what it finds."""
    marks = course.marks
    basis = first_of(course.basis, marks[TOTAL])
    marks[STEPS] += 1
    state = spend(course, basis, max(1, cells * OBSTACLES // (OBSTACLES + len(basis.kinds))))
    if state == FOUND:
        used = trace(course.search, x, basis, course.path)
        if used == 0:  # the point has gone elsewhere meanwhile
            start_search(course, goal, x, world, marks[TRIED])
            return
        marks[USED], marks[LEVEL], marks[UNREACHABLE] = used, marks[TRIED], 0
        carry(course, basis, marks[STEPS] * dt)
    elif state == EXHAUSTED:
        if marks[CUT] != UNCUT and marks[TRIED] + 1 < len(course.levels):
            start_search(course, goal, x, world, marks[TRIED] + 1)
        elif marks[CUT] == WAS_CUT:
            marks[CUT] = UNCUT
            start_search(course, goal, x, world, 0)
        else:
            marks[USED], marks[UNREACHABLE] = 0, 1
            course.search.counts[STATE] = EXHAUSTED


@compiled
def carry(course: Course, world: World, dt: float) -> None:
    """Let what is close to moving obstacles on the path go with them for a while."""
    path, marks = course.path, course.marks
    near = CARRIED_SHARE * course.levels[marks[LEVEL], CLEARANCE_M]
    normal = np.empty(3)
    for i in range(len(world.kinds)):
        w = world.velocities[i]
        if length_between(w, np.zeros(3)) < LEAD_M_S:
            continue
        for j in range(marks[USED] - 1):
            far = point_distance(
                world.kinds[i],
                world.sizes[i],
                world.rotations[i],
                world.centres[i],
                path[j, :3],
                normal,
            )
            if far - world.margins[i] < near:
                for k in range(3):
                    path[j, k] += dt * w[k]


@compiled
def sees_goal(course: Course, x: Vector, goal: Vector, world: World) -> bool:
    """Whether nothing is between here and the goal."""
    spare = sight_from(x, world, course.levels[0, SIGHT_M])
    spare = min(spare, sight_from(goal, world, spare))
    return spare > 0.0 and is_segment_free(x, goal, world, spare)


@compiled
def follow(
    course: Course, x: Vector, goal: Vector, world: World, cells: int, dt: float, out: Vector
) -> float:
    """Unit vector of the way to the goal, and how far it is; inf where none is known (yet)."""
    marks, path = course.marks, course.path
    if sees_goal(course, x, goal, world):
        path[0, :3], path[0, 3] = goal, 0.0
        marks[USED], marks[LEVEL], marks[UNREACHABLE] = 1, 0, 0
        course.search.counts[STATE] = IDLE
        length = length_between(x, goal)
        for k in range(3):
            out[k] = (goal[k] - x[k]) / length if length > 0.0 else 0.0
        return length
    carry(course, world, dt)
    if course.search.counts[STATE] == SEARCHING:
        go_on(course, x, goal, world, cells, dt)
    length = along(course, x, goal, world, out)
    if course.search.counts[STATE] != SEARCHING:
        is_lost = length == math.inf and not marks[UNREACHABLE]
        if is_lost or is_stale(course, goal, world):
            marks[CUT] = NOT_CUT
            start_search(course, goal, x, world, 0)
    return length


@compiled
def along(course: Course, x: Vector, goal: Vector, world: World, out: Vector) -> float:
    """Unit vector along the path that is known, to where the goal is now; inf if it is not seen."""
    marks, path = course.marks, course.path
    out[:] = 0.0
    if marks[USED] == 0:
        return math.inf
    last = marks[USED] - 1
    if path[last, 3] == 0.0:
        path[last, :3] = goal
    return steer(path, marks[USED], x, world, course.levels[marks[LEVEL], SIGHT_M], out)
