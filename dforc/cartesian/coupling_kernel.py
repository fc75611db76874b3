"""The quadratic program of one period of the plan, for numba: cost, bounds, answer."""

import math

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.quadratic_kernel import factorise, solve_factorised

SLOW_M_S = 1e-3  # a tip slower than this has no direction of its own
BLOCKED = 1e8  # weight that keeps a joint which is not free to its own speed
RETURN_RAD_S = 0.3  # fastest way back inside of a joint or row that is outside
ROOM_TO_ROUND = 1e-9
MORE_ACCELERATION = 3.0  # on top, where limits and rows cannot be kept otherwise


@compiled
def add_misses(J: Matrix, left: Vector, weight: float, free: Vector, H: Matrix, g: Vector) -> None:
    """Add weight |J dq - left|^2 / 2 of the free joints to 1/2 dq' H dq + g' dq (lower half)."""
    n = len(g)
    for r in range(len(left)):
        for j in range(n):
            scaled = weight * J[r, j] * free[j]
            g[j] -= scaled * left[r]
            for k in range(j + 1):
                H[j, k] += scaled * J[r, k] * free[k]


@compiled
def add_task(
    J: Matrix,
    v_task: Vector,
    active: Vector,
    weights: Vector,
    free: Vector,
    v_joint: Vector,
    H: Matrix,
    g: Vector,
) -> None:
    """Cost of one tip's miss, (J dq - v)' Omega (J dq - v) / 2.

    Omega weighs linear misses across the way with weights[0], along it with weights[1], and
    angular ones with weights[2]. Joints that are not free move by v_joint whatever happens.
    """
    left = v_task - J @ ((1.0 - free) * v_joint)
    if active[3] != 0.0:
        add_misses(J[3:], left[3:], weights[2], free, H, g)
    if active[0] != 0.0:
        add_misses(J[:3], left[:3], weights[0], free, H, g)
        way = v_task[:3]
        way = way / math.sqrt(SLOW_M_S * SLOW_M_S + way @ way)
        along = np.empty((1, len(g)))
        along[0] = way @ J[:3]
        add_misses(along, np.array([way @ left[:3]]), weights[1] - weights[0], free, H, g)


@compiled
def room(distance: float, braking: float, period_s: float) -> float:
    """Largest speed towards a limit from which it can still be kept; negative beyond it."""
    if distance < 0.0:
        if distance > -ROOM_TO_ROUND:
            return 0.0
        return max(distance / period_s, -RETURN_RAD_S)
    half = 0.5 * braking * period_s
    return min(distance / period_s, math.sqrt(2.0 * braking * distance + half * half) - half)


@compiled
def limit_bounds(
    values: Vector,
    lower: Vector,
    upper: Vector,
    sizes: Vector,
    braking: float,
    period_s: float,
    low: Vector,
    high: Vector,
) -> None:
    """Bounds on the speeds of C q (m,) that keep limits and rows, now and while braking."""
    for i in range(len(low)):
        high[i] = room(upper[i] - values[i], braking * sizes[i], period_s)
        low[i] = -room(values[i] - lower[i], braking * sizes[i], period_s)


@compiled
def narrow(low: Vector, high: Vector, least: Vector, most: Vector) -> None:
    """Bounds of the joints cut to least .. most, as far as their limits leave a choice."""
    for i in range(len(least)):
        a, b = low[i], high[i]
        low[i] = min(max(a, least[i]), b)
        high[i] = max(min(b, most[i]), a)


@compiled
def stopping_bounds(free: Vector, v_joint: Vector, low: Vector, high: Vector) -> None:
    """A joint that is not free may move by v_joint or less: it can always stand still."""
    for i in range(len(free)):
        if free[i] == 0.0:
            low[i] = min(max(low[i], min(0.0, v_joint[i]) - ROOM_TO_ROUND), 0.0)
            high[i] = max(min(high[i], max(0.0, v_joint[i]) + ROOM_TO_ROUND), 0.0)


@compiled
def plan_speeds(
    J: Matrix,
    v_task: Matrix,
    active: Matrix,
    weights: Vector,
    free: Vector,
    stiffness: float,
    v_joint: Vector,
    v_before: Vector,
    C: Matrix,
    values: Vector,
    lower: Vector,
    upper: Vector,
    sizes: Vector,
    speed_limit: Vector,
    acceleration: float,
    braking: float,
    period_s: float,
    dq: Vector,
) -> int:
    """Joint speeds of least cost within all bounds. Number of active bounds; -1: no answer, dq = 0.

    Where the bounds exclude each other, that on the acceleration goes first, then what leads back
    inside from outside; limits and rows stay.
    """
    n, m = len(v_joint), len(values)
    H, g = np.zeros((n, n)), np.empty(n)
    for j in range(n):
        H[j, j] = stiffness if free[j] != 0.0 else BLOCKED
        g[j] = -H[j, j] * v_joint[j]
    for tip in range(len(v_task)):
        add_task(J[6 * tip : 6 * tip + 6], v_task[tip], active[tip], weights, free, v_joint, H, g)
    L, M, R = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    held, work = np.empty((3, n)), np.empty((3, n))
    low, high = np.empty(m), np.empty(m)
    if factorise(H, n, 0.0, L):
        for attempt in range(4):
            limit_bounds(values, lower, upper, sizes, braking, period_s, low, high)
            narrow(low, high, -speed_limit, speed_limit)
            if attempt < 2:
                change = acceleration * period_s * (1.0 + MORE_ACCELERATION * attempt)
                narrow(low, high, v_before - change, v_before + change)
            stopping_bounds(free, v_joint, low, high)
            if attempt == 3:
                low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
            count = solve_factorised(L, g, C, low, high, n, dq, M, R, held, work)
            if count >= 0:
                return count
    dq[:] = 0.0
    return -1
