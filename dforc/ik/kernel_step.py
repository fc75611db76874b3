"""One Newton step of a search for a posture, for numba.

It minimises the quadratic model of the cost (exact Hessian, made positive where it is not) subject
to the linear limits, and is then shortened until the cost itself falls.
"""

import math
from typing import NamedTuple

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.ik.kernel_cost import Chains, Geometry, Goal, Multipliers, cost
from dforc.quadratic_kernel import factorise, solve_factorised

LARGEST_STEP_RAD = 0.6  # of a joint
AT_LIMIT_RAD = 1e-9
SMALLEST_SHIFT, SHIFT_GROWTH, LARGEST_SHIFT = 1e-3, 4.0, 1e9
HALVINGS = 14
ARMIJO = 1e-4
ROUNDING = 1e-15


class Limits(NamedTuple):
    """lower <= C q <= upper, the joints' ranges first."""

    C: Matrix  # (n + m, n)
    lower: Vector
    upper: Vector
    free: Indices  # joints that may move (f,)
    slots: Indices  # (n,) place among them, or -1


class Room(NamedTuple):
    """Room for a search over f joints and r rows."""

    g: Vector  # (f,)
    H: Matrix  # (f, f), the part of the Hessian that is never negative
    B: Matrix  # (f, f), the rest
    L: Matrix
    J: Matrix
    R: Matrix
    active: Matrix  # (3, f): row, side and multiplier of what holds the last step
    held: Indices  # (1,) how many
    work: Matrix  # (3, f)
    dq: Vector  # (f,)
    q: Vector  # (n,)
    middle: Vector  # (n,) the answer before conditions use their radius
    C: Matrix  # (r, f): the free columns
    lower: Vector  # (r,) against the present posture
    upper: Vector


@compiled
def confine(q: Vector, limits: Limits, room: Room) -> None:
    """Limits of the coming step."""
    f = len(limits.free)
    for i in range(f):
        joint = limits.free[i]
        room.lower[i] = max(limits.lower[joint] - q[joint], -LARGEST_STEP_RAD)
        room.upper[i] = min(limits.upper[joint] - q[joint], LARGEST_STEP_RAD)
    n = len(q)
    for row in range(len(room.lower) - f):
        value = 0.0
        for joint in range(n):
            value += limits.C[n + row, joint] * q[joint]
        # A posture on a row stays allowed, whatever rounding says.
        room.lower[f + row] = min(limits.lower[n + row] - value, 0.0)
        room.upper[f + row] = max(limits.upper[n + row] - value, 0.0)


@compiled
def step_with_factor(room: Room, f: int) -> bool:
    """The step into room.dq; False if none keeps the limits."""
    active = solve_factorised(
        room.L,
        room.g,
        room.C,
        room.lower,
        room.upper,
        f,
        room.dq,
        room.J,
        room.R,
        room.active,
        room.work,
    )
    if active >= 0:
        room.held[0] = active
    return active >= 0


@compiled
def brace(room: Room, f: int, M: Matrix) -> None:
    """Stiffen a Hessian across the limits that held the last step and still stop this one.

    As long as they hold nothing moves across them and the step is the same; but a Hessian that is
    negative only there is so no more.
    """
    stiffness = 1.0
    for i in range(f):
        stiffness = max(stiffness, 2.0 * abs(M[i, i]))
    for k in range(room.held[0]):
        row, side = int(room.active[0, k]), room.active[1, k]
        inside = -room.lower[row] if side > 0.0 else room.upper[row]
        if inside > AT_LIMIT_RAD:
            continue
        for i in range(f):
            if room.C[row, i] != 0.0:
                for j in range(i + 1):
                    M[i, j] += stiffness * room.C[row, i] * room.C[row, j]


@compiled
def newton_step(room: Room, f: int, gauss: bool, shift: float) -> float:
    """The step into room.dq; the shift that it took, infinite if there is no step.

    With the whole Hessian where it is positive. Where it is not: `gauss` takes the part that is
    never negative, which is good near a pose that can be reached; else the whole is shifted by
    its diagonal, from `shift` on, which is good where much is missed.
    """
    for i in range(f):
        for j in range(i + 1):
            room.B[i, j] += room.H[i, j]
    if factorise(room.B, f, 0.0, room.L):
        if step_with_factor(room, f):
            return 0.0
    elif room.held[0] > 0:
        brace(room, f, room.B)
        if factorise(room.B, f, 0.0, room.L) and step_with_factor(room, f):
            return 0.0
    shift = 0.0 if gauss else max(shift, SMALLEST_SHIFT)
    while shift <= LARGEST_SHIFT:
        positive = factorise(room.H if gauss else room.B, f, shift, room.L)
        if positive and step_with_factor(room, f):
            return shift
        shift = max(SMALLEST_SHIFT, SHIFT_GROWTH * shift)
    return math.inf


@compiled
def walk(
    q: Vector,
    value: float,
    chains: Chains,
    goal: Goal,
    multipliers: Multipliers,
    geometry: Geometry,
    limits: Limits,
    room: Room,
) -> float:
    """Go along room.dq as far as the cost falls. The share that was gone; 0 if it does not fall."""
    f = len(limits.free)
    slope = 0.0
    for i in range(f):
        slope += room.g[i] * room.dq[i]
    share = 1.0
    for _ in range(HALVINGS):
        for i in range(len(q)):
            room.q[i] = q[i]
        for i in range(f):
            joint = limits.free[i]
            moved = q[joint] + share * room.dq[i]
            room.q[joint] = min(max(moved, limits.lower[joint]), limits.upper[joint])
        there = cost(room.q, chains, goal, multipliers, geometry)
        if there <= value + ARMIJO * share * slope + ROUNDING * (1.0 + abs(value)):
            for i in range(len(q)):
                q[i] = room.q[i]
            return share
        share *= 0.5
    return 0.0


@compiled
def finite_length(dq: Vector, f: int) -> float:
    """The largest step of a joint."""
    longest = 0.0
    for i in range(f):
        longest = max(longest, abs(dq[i]))
    return longest
