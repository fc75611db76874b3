"""What obstacles ask of a point's acceleration and velocity, and the nearest one that obeys.

For numba. With the distance d, the outward normal n and the obstacle's velocity w, a point may
approach with n'(v - w) >= -gamma (d - margin): the velocity that is commanded keeps it in the
obstacle's frame. Its derivative in time, with one more rate kappa, is a row for the acceleration:
n'a >= kappa (n'w - gamma (d - margin) - n'v). An obstacle that moves has a second row: no contact
at the nearest approach within the next moments if both keep their velocities. Rows that exclude
each other are missed as little as can be.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.collision.kernel_shapes import point_distance
from dforc.collision.obstacles import World
from dforc.compiled import compiled
from dforc.quadratic_kernel import solve_factorised

APPROACH_PER_S = 4.0  # gamma
RESPONSE_PER_S = 12.0  # kappa
HARD_APPROACH_PER_S = 15.0  # gamma of the velocity that is commanded
HARD_SHARE = 0.5  # of the margin that this velocity keeps in any case
PUSH_M_S = 0.3  # fastest way out of a margin that was entered
REACH_M = 0.15  # farther obstacles ask nothing
MOVES_M_S = 0.02  # an obstacle that is slower stands still
AHEAD_S = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
AHEAD_PER_S = 4.0  # how fast the way around a moving obstacle is taken up
AHEAD_SLACK = 4.0  # this row is missed so many times before another is
MISS_PRICE = 60.0  # m/s^2: more than any acceleration costs
OUTWARD = 0.2  # cosine to the normal below which a way out leads through an obstacle
SWEEPS = 8


class Barrier(NamedTuple):
    """Room for the rows of m obstacles; distances are from their margins."""

    distances: Vector  # (m,)
    normals: Matrix  # (m, 3)
    C: Matrix  # (2 m + 1, 4) the last column is by how much rows may be missed
    lower: Vector  # (2 m + 1,)
    upper: Vector  # (2 m + 1,) inf
    L: Matrix  # (4, 4) Cholesky factor of the cost
    gradient: Vector  # (4,)
    room: Matrix  # (16, 4)


@compiled
def measure(barrier: Barrier, x: Vector, world: World) -> float:
    """Distance and normal of every obstacle; the smallest distance."""
    least = math.inf
    for i in range(len(world.kinds)):
        far = point_distance(
            world.kinds[i],
            world.sizes[i],
            world.rotations[i],
            world.centres[i],
            x,
            barrier.normals[i],
        )
        barrier.distances[i] = far - world.margins[i]
        least = min(least, barrier.distances[i])
    return least


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Inner product of two (3,)."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def slowest(spare: float, gamma: float) -> float:
    """Lowest speed away from an obstacle, with so much room beyond the margin."""
    return -gamma * spare if spare > 0.0 else min(PUSH_M_S, -gamma * spare)


@compiled
def approach_row(barrier: Barrier, row: int, i: int, v: Vector, world: World, margin: float) -> int:
    """The row of one obstacle as it stands; the number of rows."""
    n = barrier.normals[i]
    needed = dot(n, world.velocities[i]) + slowest(barrier.distances[i] - margin, APPROACH_PER_S)
    for k in range(3):
        barrier.C[row, k] = n[k]
    barrier.C[row, 3] = 1.0
    barrier.lower[row] = RESPONSE_PER_S * (needed - dot(n, v))
    return row + 1


@compiled
def ahead_row(
    barrier: Barrier, row: int, i: int, x: Vector, v: Vector, world: World, margin: float
) -> int:
    """The row of a moving obstacle's nearest approach; the number of rows."""
    w = world.velocities[i]
    place, normal = np.empty(3), np.empty(3)
    worst, when = 0.0, 0.0
    for ahead in AHEAD_S:
        for k in range(3):
            place[k] = x[k] + ahead * (v[k] - w[k])
        far = point_distance(
            world.kinds[i], world.sizes[i], world.rotations[i], world.centres[i], place, normal
        )
        spare = far - world.margins[i] - margin
        if spare < worst:
            worst, when = spare, ahead
            for k in range(3):
                barrier.C[row, k] = normal[k]
    if when == 0.0:
        return row
    barrier.C[row, 3] = AHEAD_SLACK
    barrier.lower[row] = -AHEAD_PER_S * worst / when
    return row + 1


@compiled
def fill_rows(
    barrier: Barrier, x: Vector, v: Vector, way_out: Vector, world: World, margin: float
) -> int:
    """Rows of all obstacles that are near or come near; their number.

    A point inside an obstacle leaves along `way_out`: obstacles that it leaves through are skipped.
    """
    row = 0
    for i in range(len(world.kinds)):
        w = world.velocities[i]
        speed = math.sqrt(dot(w, w))
        if barrier.distances[i] < 0.0 and dot(way_out, barrier.normals[i]) < OUTWARD:
            continue
        if barrier.distances[i] < REACH_M + speed / APPROACH_PER_S:
            row = approach_row(barrier, row, i, v, world, margin)
        if speed > MOVES_M_S and barrier.distances[i] > 0.0:
            row = ahead_row(barrier, row, i, x, v, world, margin)
    return row


@compiled
def obey(barrier: Barrier, rows: int, wanted: Vector, out: Vector) -> bool:
    """The acceleration nearest to the wanted one that keeps all rows, or misses them least."""
    for k in range(3):
        out[k] = wanted[k]
    worst = 0.0
    for i in range(rows):
        worst = max(worst, barrier.lower[i] - dot(barrier.C[i], wanted))
    if worst <= 0.0:
        return True
    barrier.C[rows, :3] = 0.0
    barrier.C[rows, 3], barrier.lower[rows] = 1.0, 0.0
    for k in range(3):
        barrier.gradient[k] = -wanted[k]
    barrier.gradient[3] = MISS_PRICE
    count = rows + 1
    room = barrier.room
    active = solve_factorised(
        barrier.L,
        barrier.gradient,
        barrier.C[:count],
        barrier.lower[:count],
        barrier.upper[:count],
        4,
        room[0],
        room[4:8],
        room[8:12],
        room[1:4],
        room[12:15],
    )
    if active < 0:
        return False
    for k in range(3):
        out[k] = room[0, k]
    return True


@compiled
def hold_back(barrier: Barrier, v: Vector, way_out: Vector, world: World, margin: float) -> bool:
    """Change the velocity so that it does not run into anything; whether it had to be."""
    is_changed = False
    for _ in range(SWEEPS):
        is_kept = True
        for i in range(len(world.kinds)):
            n, far = barrier.normals[i], barrier.distances[i]
            # Who is inside the solid itself leaves at the pace of the acceleration.
            if far > REACH_M or far + world.margins[i] < 0.0:
                continue
            if far < 0.0 and dot(way_out, n) < OUTWARD:
                continue
            needed = dot(n, world.velocities[i])
            needed += slowest(far - HARD_SHARE * margin, HARD_APPROACH_PER_S)
            short = needed - dot(n, v)
            if short > 1e-9:
                is_kept, is_changed = False, True
                for k in range(3):
                    v[k] += short * n[k]
        if is_kept:
            break
    return is_changed


def new_barrier(most: int) -> Barrier:
    """Room for so many obstacles."""
    return Barrier(
        distances=np.zeros(most),
        normals=np.zeros((most, 3)),
        C=np.zeros((2 * most + 1, 4)),
        lower=np.zeros(2 * most + 1),
        upper=np.full(2 * most + 1, np.inf),
        L=np.eye(4),
        gradient=np.zeros(4),
        room=np.zeros((16, 4)),
    )
