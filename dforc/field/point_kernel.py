"""One step of the point's field, for numba.

Far from obstacles the acceleration is eq. 3 in the target's frame, K (x_t - x) - D (v - v_t), which
is D (v_nominal - v) with v_nominal = (K / D) (x_t - x) + v_t. Around obstacles v_nominal follows
the course with the same speed law, in the length that is left. The acceleration is low-passed,
corrected by the barrier, low-passed again; the velocity that comes out is checked once more.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Vector
from dforc.collision.kernel_shapes import world_distance
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.field.barrier_kernel import Barrier, dot, fill_rows, hold_back, measure, obey
from dforc.field.course_kernel import (
    LEVEL,
    MARGIN,
    UNREACHABLE,
    USED,
    Course,
    follow,
)
from dforc.field.guide_kernel import length_between
from dforc.field.refuge_kernel import refuge

Indices = NDArray[np.int64]

# What the point is doing.
REACHING, SEARCHING_WAY, CANNOT_REACH, NEAREST_PLACE, LEAVING, ARRIVED = 0, 1, 2, 3, 4, 5

LEAVE_M_S = 0.15  # out of an obstacle that the point is in
NEAR_SHARE = 0.5  # how quickly the margin grows with the distance from a goal that is within it
NEAR_M = 1e-3  # room to such a goal


class Law(NamedTuple):
    """Constants of the field."""

    stiffness: float  # K [N/m]
    damping: float  # D [Ns/m]
    speed: float  # of the way to the goal [m/s]
    escape: float  # of anything [m/s]
    acceleration: float  # [m/s^2]
    hard_acceleration: float  # before an obstacle [m/s^2]
    jerk: float  # [m/s^3]
    wanted_s: float  # time constant of the wanted acceleration
    given_s: float  # and of the one that the barrier has corrected
    tightest: float  # distance from an obstacle that is kept in any case [m]
    arrived: float  # [m]
    cells: int  # of a search, per step


class Point(NamedTuple):
    """The point and all room that a step needs."""

    x: Vector  # (3,) [m]
    v: Vector  # (3,) [m/s]
    wanted: Vector  # (3,) acceleration before the barrier [m/s^2]
    given: Vector  # (3,) and behind it
    nominal: Vector  # (3,) velocity of the field [m/s]
    aim: Vector  # (3,) where it goes: the goal, or the nearest safe place [m]
    way_out: Vector  # (3,) unit vector out of the obstacle that it is in, or zero
    figures: Vector  # (2,) distance from the nearest obstacle and way to go [m]
    status: Indices  # (1,)
    course: Course
    barrier: Barrier


@compiled
def choose_aim(point: Point, goal: Vector, velocity: Vector, world: World, law: Law) -> bool:
    """The goal, or the nearest place that is safe; into `velocity` (3,) how that one moves."""
    toward = np.empty(3)
    for k in range(3):
        toward[k] = point.aim[k] - goal[k]
    far = refuge(goal, world, law.tightest, toward, point.aim)
    if far == 0.0:
        return True
    if far == math.inf:
        velocity[:] = 0.0
        return False
    # Across the way out it goes with the goal, along it with the obstacle.
    nearest, least = -1, math.inf
    normal = np.empty(3)
    for i in range(len(world.kinds)):
        away = abs(length_between(point.aim, world.centres[i]) - world.reaches[i])
        if away < least:
            nearest, least = i, away
    for k in range(3):
        normal[k] = (point.aim[k] - goal[k]) / far
    along = dot(normal, velocity) - dot(normal, world.velocities[nearest])
    for k in range(3):
        velocity[k] -= along * normal[k]
    return False


@compiled
def margin_here(point: Point, world: World, law: Law) -> float:
    """The barrier's margin: the level's, less near an aim that is within it."""
    course = point.course
    margin = course.levels[course.marks[LEVEL], MARGIN]
    room = world_distance(point.aim, world) - NEAR_M
    room += NEAR_SHARE * length_between(point.aim, point.x)
    return float(min(margin, max(law.tightest, room)))


@compiled
def set_nominal(point: Point, velocity: Vector, world: World, law: Law, dt: float) -> None:
    """The velocity that the field wants, not looking at what is near."""
    nominal, course = point.nominal, point.course
    direction = np.empty(3)
    length = follow(course, point.x, point.aim, world, law.cells, dt, direction)
    point.figures[1] = length
    if length == math.inf:
        if course.marks[UNREACHABLE]:
            nominal[:] = 0.0
        return  # the last velocity is held until the search has found a way
    speed = min(law.stiffness / law.damping * length, law.speed)
    if course.marks[USED] == 1:
        for k in range(3):
            nominal[k] = speed * direction[k] + velocity[k]
        return
    last = course.path[course.marks[USED] - 1]
    before = course.path[course.marks[USED] - 2]
    leg = length_between(last, before)
    if leg > 0.0:  # the way grows as the goal goes on along the last leg
        for k in range(3):
            speed += velocity[k] * (last[k] - before[k]) / leg
    for k in range(3):
        nominal[k] = max(0.0, speed) * direction[k]


@compiled
def leave(point: Point, world: World, law: Law) -> None:
    """The velocity out of an obstacle, by the shortest way."""
    place, preferred = np.empty(3), point.way_out.copy()
    far = refuge(point.x, world, law.tightest, preferred, place)
    for k in range(3):
        if far < math.inf:
            point.way_out[k] = (place[k] - point.x[k]) / far
        point.nominal[k] = LEAVE_M_S * point.way_out[k]


@compiled
def bounded(vector: Vector, most: float) -> None:
    """Shorten a vector to a length."""
    size = math.sqrt(dot(vector, vector))
    if size > most:
        for k in range(3):
            vector[k] *= most / size


@compiled
def want(point: Point, law: Law, dt: float) -> None:
    """The acceleration towards the nominal velocity, smooth."""
    change = np.empty(3)
    for k in range(3):
        change[k] = law.damping * (point.nominal[k] - point.v[k])
    bounded(change, law.acceleration)
    share = 1.0 - math.exp(-dt / law.wanted_s)
    for k in range(3):
        change[k] = share * (change[k] - point.wanted[k])
    bounded(change, law.jerk * dt)
    for k in range(3):
        point.wanted[k] += change[k]


@compiled
def move(point: Point, world: World, margin: float, law: Law, dt: float) -> None:
    """Let the barrier correct the acceleration, and move by one step."""
    barrier, x, v = point.barrier, point.x, point.v
    corrected, before = np.empty(3), v.copy()
    rows = fill_rows(barrier, x, v, point.way_out, world, margin)
    if not obey(barrier, rows, point.wanted, corrected):
        for k in range(3):
            corrected[k] = -law.damping * v[k]
    bounded(corrected, law.hard_acceleration)
    share = 1.0 - math.exp(-dt / law.given_s)
    for k in range(3):
        point.given[k] += share * (corrected[k] - point.given[k])
        v[k] += dt * point.given[k]
    bounded(v, law.escape)
    if hold_back(barrier, v, point.way_out, world, margin):
        bounded(v, law.escape)
    for k in range(3):
        point.given[k] = (v[k] - before[k]) / dt
        x[k] += dt * v[k]
    bounded(point.given, law.hard_acceleration)


@compiled
def step(
    point: Point, goal: Vector, goal_velocity: Vector, world: World, law: Law, dt: float
) -> int:
    """Move the point by one period; what it is doing."""
    velocity = goal_velocity.copy()
    point.figures[0] = measure(point.barrier, point.x, world)
    if point.figures[0] < 0.0:
        point.aim[:] = goal
        leave(point, world, law)
        margin, status = law.tightest, LEAVING
    else:
        point.way_out[:] = 0.0
        is_goal = choose_aim(point, goal, velocity, world, law)
        set_nominal(point, velocity, world, law, dt)
        margin = margin_here(point, world, law)
        status = status_of(point, is_goal, law)
    want(point, law, dt)
    move(point, world, margin, law, dt)
    point.status[0] = status
    return status


@compiled
def status_of(point: Point, is_goal: bool, law: Law) -> int:
    """What the point is doing, outside obstacles."""
    if point.course.marks[UNREACHABLE]:
        return CANNOT_REACH
    if not is_goal:
        return NEAREST_PLACE
    if point.figures[1] == math.inf:
        return SEARCHING_WAY
    return ARRIVED if point.figures[1] <= law.arrived else REACHING
