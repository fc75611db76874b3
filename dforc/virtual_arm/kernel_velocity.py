"""The quadratic program of one step of the virtual arm, for numba: joint speeds for its tasks.

Cost: (J dq - v)' W (J dq - v) of the hands and (dq - dq_w)' P (dq - dq_w) of the posture.
Kept: speeds of the joints, limits and rows (not faster than they can be braked), and for every
surface that is near the speed towards it. What cannot be kept is missed by the same speed on all
surfaces, by as little as can be.
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
AS_WANTED, FASTER, MISSED, STOPPED = 0, 1, 2, 3  # how an answer came about


class Room(NamedTuple):
    """Scratch of the program, for n joints, m rows and k surfaces."""

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
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros((rows, size)),
        np.zeros(rows),
        np.zeros(rows),
        np.zeros((QP_ROOM_ROWS + 3 * size, size)),
    )


@compiled
def _cost(
    J: Matrix, v: Vector, weights: Vector, dq_wanted: Vector, posture: Vector, H: Matrix, g: Vector
) -> None:
    """Fill H (both halves) and g of the joints' part."""
    n = len(dq_wanted)
    for j in range(n):
        g[j] = -posture[j] * dq_wanted[j]
        for k in range(n):
            H[j, k] = 0.0
        H[j, j] = posture[j]
    for r in range(len(v)):
        weight = weights[r]
        if weight == 0.0:
            continue
        for j in range(n):
            scaled = weight * J[r, j]
            g[j] -= scaled * v[r]
            for k in range(j + 1):
                H[j, k] += scaled * J[r, k]
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
def _limits(
    q: Vector,
    C: Matrix,
    lower: Vector,
    upper: Vector,
    speeds: Vector,
    period_s: float,
    room: Room,
) -> None:
    """The first n + m constraints: joints and rows."""
    n = len(q)
    for i in range(len(C)):
        value, fastest = 0.0, 0.0
        for j in range(n):
            value += C[i, j] * q[j]
            fastest += abs(C[i, j]) * speeds[j]
            room.C[i, j] = C[i, j]
        room.C[i, n] = 0.0
        room.upper[i] = min(fastest, _towards(upper[i] - value, LIMIT_1_S, RETURN_RAD_S, period_s))
        room.lower[i] = -min(fastest, _towards(value - lower[i], LIMIT_1_S, RETURN_RAD_S, period_s))


@compiled
def choose_velocity(
    q: Vector,
    dq_before: Vector,
    J: Matrix,
    v: Vector,
    weights: Vector,
    dq_wanted: Vector,
    posture: Vector,
    C: Matrix,
    lower: Vector,
    upper: Vector,
    speeds: Vector,
    acceleration: float,
    gradients: Matrix,
    floors: Vector,
    count: int,
    period_s: float,
    room: Room,
    dq: Vector,
) -> int:
    """Joint speeds dq (n,) of the next period, and how they came about.

    Args:
        q: posture (n,); dq_before the speeds of the period before.
        J: (r, n) of all hands' tasks, v (r,) what they want, weights (r,).
        dq_wanted: (n,) of the posture, with weights `posture` (n,), all positive.
        C, lower, upper: limits and rows as JointLimits has them.
        speeds: (n,) largest of each joint; acceleration [rad/s^2] of all, unless surfaces need more.
        gradients: (count, n) of the distances to surfaces, floors (count,): their least speed.
        count: surfaces.
        period_s: of a step.
        room: scratch.
        dq: the answer.
    """
    n, m = len(q), len(C)
    _cost(J, v, weights, dq_wanted, posture, room.H, room.g)
    _limits(q, C, lower, upper, speeds, period_s, room)
    for k in range(count):
        row = m + k
        for j in range(n):
            room.C[row, j] = gradients[k, j]
        room.C[row, n] = 0.0
        room.lower[row] = floors[k]
        room.upper[row] = np.inf
    wide_low, wide_high = room.lower[:n].copy(), room.upper[:n].copy()
    step = acceleration * period_s
    for j in range(n):
        if dq_before[j] - step <= wide_high[j]:
            room.lower[j] = max(wide_low[j], dq_before[j] - step)
        if dq_before[j] + step >= wide_low[j]:
            room.upper[j] = min(wide_high[j], dq_before[j] + step)
    used = m + count
    small = room.work[: QP_ROOM_ROWS + 3 * n, :n].copy()
    H, g, A = room.H[:n, :n].copy(), room.g[:n].copy(), room.C[:used, :n].copy()
    solved = solve_quadratic(H, g, A, room.lower[:used], room.upper[:used], small)
    how = AS_WANTED
    if solved < 0:
        room.lower[:n] = wide_low
        room.upper[:n] = wide_high
        solved = solve_quadratic(H, g, A, room.lower[:used], room.upper[:used], small)
        how = FASTER
    if solved >= 0:
        dq[:] = small[0]
        return how
    for j in range(n):
        room.H[n, j] = 0.0
        room.H[j, n] = 0.0
        room.C[used, j] = 0.0
    room.H[n, n] = MISS_WEIGHT
    room.g[n] = 0.0
    for k in range(count):
        room.C[m + k, n] = 1.0
    room.C[used, n] = 1.0
    room.lower[used] = 0.0
    room.upper[used] = np.inf
    used += 1
    solved = solve_quadratic(
        room.H, room.g, room.C[:used], room.lower[:used], room.upper[:used], room.work
    )
    if solved >= 0:
        dq[:] = room.work[0, :n]
        return MISSED
    dq[:] = 0.0
    return STOPPED
