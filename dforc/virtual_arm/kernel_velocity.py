"""The quadratic program of one step of the virtual arm, for numba: joint speeds for its tasks.

Cost: (J dq - v)' W (J dq - v) of the hands and (dq - dq_w)' P (dq - dq_w) of the posture.
Kept: speeds of the joints, limits and rows (not faster than they can be braked), and for every
surface that is near the speed towards it. What cannot be kept is missed by as little as can be:
first the arm leaves margins more slowly, and comes nearer to nothing for it; only if something
comes nearer by itself are all surfaces missed, by the same speed.
"""

from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.quadratic_kernel import solve_quadratic

QP_ROOM_ROWS = 7
MISS_WEIGHT = 1e9  # (m/s)^-2 of speed by which the surfaces are missed, against 1e4 of the hand's
LIMIT_1_S = 12.0  # largest speed towards a limit, over the distance left
RETURN_RAD_S = 0.3  # fastest way back inside of a limit
AS_WANTED, FASTER, EASED, MISSED, STOPPED = 0, 1, 2, 3, 4  # how an answer came about


class Wishes(NamedTuple):
    """What is wanted of hands and posture: least squares, for r rows and n joints."""

    J: Matrix  # (r, n) of all hands' tasks
    v: Vector  # (r,) their speeds
    weights: Vector  # (r,), 0 where nothing is wanted
    dq: Vector  # (n,) of the posture
    posture: Vector  # (n,) its weights, all positive


class Keeping(NamedTuple):
    """What has to be kept: limits and rows as JointLimits has them, speeds, surfaces."""

    C: Matrix  # (n + m, n)
    lower: Vector
    upper: Vector
    speeds: Vector  # (n,) largest of each joint
    gradients: Matrix  # (>= k, n) of the distances to surfaces
    floors: Vector  # (>= k,) their least speed
    pushes: Vector  # (>= k,) what of it leads out of a margin, 0 where there is room


class Room(NamedTuple):
    """Scratch of the program, for n joints, m rows and k surfaces."""

    missed: Vector  # (k,)
    H: Matrix  # (n + 1, n + 1)
    g: Vector  # (n + 1,)
    C: Matrix  # (n + m + k + 1, n + 1)
    lower: Vector
    upper: Vector
    work: Matrix


def room_of(n: int, m: int, k: int) -> Room:
    """Scratch for the largest program."""
    size, rows = n + 1, n + m + k + 1
    return Room(
        np.zeros(k),
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros((rows, size)),
        np.zeros(rows),
        np.zeros(rows),
        np.zeros((QP_ROOM_ROWS + 3 * size, size)),
    )


@compiled
def _cost(wishes: Wishes, H: Matrix, g: Vector) -> None:
    """Fill H (both halves) and g of the joints' part."""
    n = len(wishes.dq)
    for j in range(n):
        g[j] = -wishes.posture[j] * wishes.dq[j]
        for k in range(n):
            H[j, k] = 0.0
        H[j, j] = wishes.posture[j]
    for r in range(len(wishes.v)):
        weight = wishes.weights[r]
        if weight == 0.0:
            continue
        for j in range(n):
            scaled = weight * wishes.J[r, j]
            g[j] -= scaled * wishes.v[r]
            for k in range(j + 1):
                H[j, k] += scaled * wishes.J[r, k]
    for j in range(n):
        for k in range(j):
            H[k, j] = H[j, k]


@compiled
def _towards(left: float, rate: float, back: float, period_s: float) -> float:
    """Largest speed towards a bound that is `left` away; negative, back inside, beyond it."""
    if left >= 0.0:
        return min(rate, 1.0 / period_s) * left
    return max(left / period_s, -back)


@compiled
def _bounds(q: Vector, keeping: Keeping, count: int, period_s: float, room: Room) -> None:
    """All constraints but the last: joints and rows, then `count` surfaces."""
    n, C = len(q), keeping.C
    for i in range(len(C)):
        value, fastest = 0.0, 0.0
        for j in range(n):
            value += C[i, j] * q[j]
            fastest += abs(C[i, j]) * keeping.speeds[j]
            room.C[i, j] = C[i, j]
        room.C[i, n] = 0.0
        above = _towards(keeping.upper[i] - value, LIMIT_1_S, RETURN_RAD_S, period_s)
        below = _towards(value - keeping.lower[i], LIMIT_1_S, RETURN_RAD_S, period_s)
        room.upper[i] = min(fastest, above)
        room.lower[i] = -min(fastest, below)
    for k in range(count):
        row = len(C) + k
        for j in range(n):
            room.C[row, j] = keeping.gradients[k, j]
        room.C[row, n] = 0.0
        room.lower[row] = keeping.floors[k]
        room.upper[row] = np.inf


@compiled
def _smoothly(dq_before: Vector, step: float, low: Vector, high: Vector) -> None:
    """Narrow the joints' bounds to a change of speed, where that leaves anything."""
    for j in range(len(dq_before)):
        slow, fast = low[j], high[j]
        if dq_before[j] - step <= fast:
            low[j] = max(slow, dq_before[j] - step)
        if dq_before[j] + step >= slow:
            high[j] = min(fast, dq_before[j] + step)


@compiled
def _solve_missing(first: int, count: int, most: float, room: Room) -> int:
    """The program with one more unknown: by how much, `most` at most, surfaces are missed.

    `room.missed` says by which share of that each of them is.
    """
    n = len(room.g) - 1
    last = first + count
    for j in range(n):
        room.H[n, j] = 0.0
        room.H[j, n] = 0.0
        room.C[last, j] = 0.0
    room.H[n, n] = MISS_WEIGHT
    room.g[n] = 0.0
    for k in range(count):
        room.C[first + k, n] = room.missed[k]
    room.C[last, n] = 1.0
    room.lower[last] = 0.0
    room.upper[last] = most
    used = last + 1
    return solve_quadratic(
        room.H, room.g, room.C[:used], room.lower[:used], room.upper[:used], room.work
    )


@compiled
def choose_velocity(
    q: Vector,
    dq_before: Vector,
    acceleration: float,
    period_s: float,
    wishes: Wishes,
    keeping: Keeping,
    count: int,
    room: Room,
    dq: Vector,
) -> int:
    """Joint speeds dq (n,) of the next period, and how they came about.

    Args:
        q: posture (n,).
        dq_before: speeds of the period before (n,).
        acceleration: [rad/s^2] of all joints, unless surfaces need more.
        period_s: of a step.
        wishes: the cost.
        keeping: the constraints.
        count: surfaces.
        room: scratch.
        dq: the answer.
    """
    n, m = len(q), len(keeping.C)
    used = m + count
    _cost(wishes, room.H, room.g)
    _bounds(q, keeping, count, period_s, room)
    low, high = room.lower[:used].copy(), room.upper[:used].copy()
    _smoothly(dq_before, acceleration * period_s, low[:n], high[:n])
    small = np.empty((QP_ROOM_ROWS + 3 * n, n))
    H, g, A = room.H[:n, :n].copy(), room.g[:n].copy(), room.C[:used, :n].copy()
    if solve_quadratic(H, g, A, low, high, small) >= 0:
        dq[:] = small[0]
        return AS_WANTED
    if solve_quadratic(H, g, A, room.lower[:used], room.upper[:used], small) >= 0:
        dq[:] = small[0]
        return FASTER
    most = 0.0
    for k in range(count):
        most = max(most, keeping.pushes[k])
    if most > 0.0:
        for k in range(count):
            room.missed[k] = keeping.pushes[k] / most
        if _solve_missing(m, count, most, room) >= 0:
            dq[:] = room.work[0, :n]
            return EASED
    room.missed[:count] = 1.0
    if _solve_missing(m, count, np.inf, room) >= 0:
        dq[:] = room.work[0, :n]
        return MISSED
    dq[:] = 0.0
    return STOPPED
