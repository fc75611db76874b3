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
    """Cost of one tip's miss, (J dq - v)' Omega (J dq - v) / 2, added to 1/2 dq' H dq + g' dq.

    Omega weighs linear misses across the way with weights[0], along it with weights[1], and
    angular ones with weights[2]. Joints that are not free move by v_joint whatever happens.
    """
    n = len(g)
    size = SLOW_M_S * SLOW_M_S
    for i in range(3):
        size += v_task[i] * v_task[i]
    size = math.sqrt(size)
    along = np.zeros(n)
    left = np.empty(6)
    for r in range(6):
        left[r] = v_task[r]
        for j in range(n):
            if free[j] == 0.0:
                left[r] -= J[r, j] * v_joint[j]
    left_along = 0.0
    for r in range(6):
        if active[r] == 0.0:
            continue
        weight = weights[0] if r < 3 else weights[2]
        way = v_task[r] / size if r < 3 else 0.0
        left_along += way * left[r]
        for j in range(n):
            if free[j] == 0.0:
                continue
            scaled = weight * J[r, j]
            along[j] += way * J[r, j]
            g[j] -= scaled * left[r]
            for k in range(j + 1):
                if free[k] != 0.0:
                    H[j, k] += scaled * J[r, k]
    less = weights[0] - weights[1]
    for j in range(n):
        scaled = less * along[j]
        g[j] += scaled * left_along
        for k in range(j + 1):
            H[j, k] -= scaled * along[k]


@compiled
def speed_bounds(
    C: Matrix,
    q: Vector,
    lower: Vector,
    upper: Vector,
    sizes: Vector,
    speed_limit: Vector,
    braking: float,
    period_s: float,
    low: Vector,
    high: Vector,
) -> None:
    """Bounds on C dq (m,) that keep limits and rows, now and for as long as `braking` needs."""
    h, n = period_s, len(q)
    for i in range(len(low)):
        value = 0.0
        for k in range(n):
            value += C[i, k] * q[k]
        a = braking * sizes[i]
        high[i] = room(upper[i] - value, a, h)
        low[i] = -room(value - lower[i], a, h)
        if i < n:
            low[i] = min(max(low[i], -speed_limit[i]), high[i])
            high[i] = max(min(high[i], speed_limit[i]), low[i])


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
def plan_speeds(
    J: Matrix,
    v_task: Matrix,
    active: Matrix,
    weights: Vector,
    free: Vector,
    v_joint: Vector,
    C: Matrix,
    low: Vector,
    high: Vector,
    dq: Vector,
) -> int:
    """Joint speeds of least cost within bounds. Number of active bounds; -1: dq = 0, no answer."""
    n = len(v_joint)
    H, g = np.zeros((n, n)), np.empty(n)
    for j in range(n):
        weight = 1.0 if free[j] != 0.0 else BLOCKED
        H[j, j] = weight
        g[j] = -weight * v_joint[j]
        if free[j] == 0.0:  # it may stop sooner: standing still must always be possible
            low[j] = max(low[j], min(0.0, v_joint[j]) - ROOM_TO_ROUND)
            high[j] = min(high[j], max(0.0, v_joint[j]) + ROOM_TO_ROUND)
            low[j], high[j] = min(low[j], 0.0), max(high[j], 0.0)
    for tip in range(len(v_task)):
        add_task(J[6 * tip : 6 * tip + 6], v_task[tip], active[tip], weights, free, v_joint, H, g)
    L, M, R = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    held, work = np.empty((3, n)), np.empty((3, n))
    count = -1
    if factorise(H, n, 0.0, L):
        count = solve_factorised(L, g, C, low, high, n, dq, M, R, held, work)
        if count < 0:  # not every way back inside is open: stay, at least
            for i in range(len(low)):
                low[i], high[i] = min(low[i], 0.0), max(high[i], 0.0)
            count = solve_factorised(L, g, C, low, high, n, dq, M, R, held, work)
    if count < 0:
        for j in range(n):
            dq[j] = 0.0
        return -1
    return count
