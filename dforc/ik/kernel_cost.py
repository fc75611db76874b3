"""Cost of a posture with its exact first and second derivatives, for numba.

For each tip, with x = p(q) - x_d and e the rotation vector of R(q) R_d' in the base frame, and with
z_i the axis of joint i, o_i its origin, l_i = z_i x (p - o_i):

    dx/dq_i = l_i,   d2x/dq_i dq_j = z_j x l_i                (j nearer to the base than i, or i)
    de/dq_i = Jl^-1(e) z_i,   Jl^-1 = k I + b e e' - 1/2 [e]x,   k = |e|/2 cot(|e|/2)

A part of the pose is a cost w |r|^2, or a condition |r| <= radius: then it enters as the augmented
Lagrangian rho/2 max(0, |r + y/rho| - radius)^2, whose minimum over q for the right multiplier y is
the constrained minimum. Either way it pulls with v = df/dr and bends with f'' = a I + c s s'.
To these come beta W against the rest posture and a proximal weight against the start.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices, place_chain

IGNORED, COST, CONDITION = 0, 1, 2  # role of a part of the pose
SMALL_RAD = 1e-4  # below it the series of k and b are exact to rounding

Roles = NDArray[np.int64]
Cube = NDArray[np.float64]


class Chains(NamedTuple):
    """The chains of all tips, padded to the longest."""

    counts: Indices  # (t,) joints of each
    joints: Roles  # (t, k)
    turns: Cube  # (t, k + 1, 9)
    places: Cube  # (t, k + 1, 3)


class Goal(NamedTuple):
    """What the cost is of. Part 0 of a pose is the position, part 1 the orientation."""

    positions: Matrix  # (t, 3)
    rotations: Matrix  # (t, 9), by rows
    roles: Roles  # (t, 2)
    weights: Vector  # (2,) of a cost
    radii: Vector  # (2,) of a condition, m and rad
    nearest: Vector  # (2,) of a condition that is given up
    rest: Vector  # (n,)
    stiffness: Vector  # (n,), beta W
    start: Vector  # (n,)
    proximal: Vector  # (1,)


class Multipliers(NamedTuple):
    """State of the augmented Lagrangian."""

    y: Cube  # (t, 2, 3)
    rho: Vector  # (2,)
    radii: Vector  # (2,) that count now: 0 while the search aims at the middle


class Geometry(NamedTuple):
    """Room for one tip at a time, and the residuals of all."""

    axes: Matrix  # (k + 1, 3)
    origins: Matrix  # (k + 4, 3), behind the joints' the tip's position and rotation
    levers: Matrix  # (k, 3)
    residuals: Cube  # (t, 2, 3): x and e
    pull: Matrix  # (3, 3): v, s, and a, c


@compiled
def residual(
    q: Vector, chains: Chains, goal: Goal, geometry: Geometry, t: int
) -> tuple[float, float]:
    """Place tip t; x and e into the residuals. k and b of Jl^-1(e)."""
    k = chains.counts[t]
    place_chain(
        q, chains.joints[t, :k], chains.turns[t], chains.places[t], geometry.axes, geometry.origins
    )
    x, e = geometry.residuals[t, 0], geometry.residuals[t, 1]
    for i in range(3):
        x[i] = geometry.origins[k, i] - goal.positions[t, i]
    R, D = geometry.origins[k + 1 : k + 4], goal.rotations[t]
    m = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            m[i, j] = R[i, 0] * D[3 * j] + R[i, 1] * D[3 * j + 1] + R[i, 2] * D[3 * j + 2]
    factors: tuple[float, float] = rotation_vector(m, e)
    return factors


@compiled
def rotation_vector(m: Matrix, e: Vector) -> tuple[float, float]:
    """E of a rotation matrix; k and b of its Jl^-1."""
    a, b, c = 0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1])
    sine = math.sqrt(a * a + b * b + c * c)
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine < SMALL_RAD and cosine < 0.0:  # half a turn: the axis is in the symmetric part
        i = 0
        for j in range(1, 3):
            if m[j, j] > m[i, i]:
                i = j
        length = math.sqrt(max(0.5 * (m[i, i] + 1.0), 0.0))
        sign = 1.0
        if a * (i == 0) + b * (i == 1) + c * (i == 2) < 0.0:
            sign = -1.0
        for j in range(3):
            shared = 0.25 * (m[i, j] + m[j, i]) / length if j != i else length
            e[j] = sign * angle * shared
        return 0.0, 1.0 / (angle * angle)
    ratio = 1.0 if sine < 1e-12 else angle / sine
    e[0], e[1], e[2] = ratio * a, ratio * b, ratio * c
    if angle < SMALL_RAD:
        return 1.0, 1.0 / 12.0
    k = 0.5 * ratio * (1.0 + cosine)
    return k, (1.0 - k) / (angle * angle)


@compiled
def pulled(
    role: int, r: Vector, y: Vector, rho: float, radius: float, weight: float, pull: Matrix
) -> float:
    """Value of one part of a pose; v, s and (a, c) into `pull`."""
    v, s = pull[0], pull[1]
    if role == COST:
        for i in range(3):
            v[i], s[i] = 2.0 * weight * r[i], 0.0
        pull[2, 0], pull[2, 1] = 2.0 * weight, 0.0
        return weight * float(r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
    square = 0.0
    for i in range(3):
        s[i] = r[i] + y[i] / rho
        square += s[i] * s[i]
    if role == CONDITION and radius == 0.0:
        for i in range(3):
            v[i] = rho * s[i]
        pull[2, 0], pull[2, 1] = rho, 0.0
        return 0.5 * rho * float(square)
    length = math.sqrt(square)
    if role == IGNORED or length <= radius:
        for i in range(3):
            v[i] = 0.0
        pull[2, 0], pull[2, 1] = 0.0, 0.0
        return 0.0
    share = 1.0 - radius / length
    for i in range(3):
        v[i] = rho * share * s[i]
    pull[2, 0], pull[2, 1] = rho * share, rho * radius / (length * square)
    return 0.5 * rho * (length - radius) * (length - radius)


@compiled
def posture_cost(q: Vector, goal: Goal) -> float:
    """Against the rest posture and the start."""
    value = 0.0
    for i in range(len(q)):
        away, moved = q[i] - goal.rest[i], q[i] - goal.start[i]
        value += goal.stiffness[i] * away * away + goal.proximal[0] * moved * moved
    return value


@compiled
def bend_posture(q: Vector, goal: Goal, free: Indices, g: Vector, H: Matrix, B: Matrix) -> None:
    """Set gradient and Hessian to those of `posture_cost`."""
    for i in range(len(free)):
        joint = free[i]
        weight, near = goal.stiffness[joint], goal.proximal[0]
        away, moved = q[joint] - goal.rest[joint], q[joint] - goal.start[joint]
        g[i] = 2.0 * weight * away + 2.0 * near * moved
        for j in range(i + 1):
            H[i, j], B[i, j] = 0.0, 0.0
        H[i, i] = 2.0 * (weight + near)


@compiled
def cost(
    q: Vector, chains: Chains, goal: Goal, multipliers: Multipliers, geometry: Geometry
) -> float:
    """The whole cost, without derivatives."""
    value = posture_cost(q, goal)
    for t in range(len(chains.counts)):
        if goal.roles[t, 0] == IGNORED and goal.roles[t, 1] == IGNORED:
            continue
        residual(q, chains, goal, geometry, t)
        for part in range(2):
            value += pulled(
                goal.roles[t, part],
                geometry.residuals[t, part],
                multipliers.y[t, part],
                multipliers.rho[part],
                multipliers.radii[part],
                goal.weights[part],
                geometry.pull,
            )
    return value


@compiled
def through_rotation(e: Vector, k: float, b: float, v: Vector) -> None:
    """V = Jl^-1(e)' v, in place."""
    along = b * (e[0] * v[0] + e[1] * v[1] + e[2] * v[2])
    x = k * v[0] + along * e[0] + 0.5 * (e[1] * v[2] - e[2] * v[1])
    y = k * v[1] + along * e[1] + 0.5 * (e[2] * v[0] - e[0] * v[2])
    z = k * v[2] + along * e[2] + 0.5 * (e[0] * v[1] - e[1] * v[0])
    v[0], v[1], v[2] = x, y, z


@compiled
def bend(
    chains: Chains,
    t: int,
    slots: Indices,
    columns: Matrix,
    axes: Matrix,
    pull: Matrix,
    share: float,
    g: Vector,
    H: Matrix,
    B: Matrix,
) -> None:
    """Add what one part of tip t's pose pulls and bends: gradient, and Hessian's lower triangle.

    `columns` are dr/dq; d2r/dq_i dq_j counts as `share` of axes_j x columns_i, and goes into B:
    the Hessian is H + B, and H alone is never negative.
    """
    v, s, a, c = pull[0], pull[1], pull[2, 0], pull[2, 1]
    for i in range(chains.counts[t]):
        row = slots[chains.joints[t, i]]
        if row < 0:
            continue
        u = columns[i]
        g[row] += v[0] * u[0] + v[1] * u[1] + v[2] * u[2]
        along = c * (s[0] * u[0] + s[1] * u[1] + s[2] * u[2])
        # v . (z_j x u_i) = z_j . (u_i x v)
        x = share * (u[1] * v[2] - u[2] * v[1])
        y = share * (u[2] * v[0] - u[0] * v[2])
        z = share * (u[0] * v[1] - u[1] * v[0])
        for j in range(i + 1):
            column = slots[chains.joints[t, j]]
            if column < 0:
                continue
            w, n = columns[j], axes[j]
            lower, upper = max(row, column), min(row, column)
            H[lower, upper] += (
                (a * u[0] + along * s[0]) * w[0]
                + (a * u[1] + along * s[1]) * w[1]
                + (a * u[2] + along * s[2]) * w[2]
            )
            B[lower, upper] += x * n[0] + y * n[1] + z * n[2]


@compiled
def reach(count: int, axes: Matrix, origins: Matrix, levers: Matrix) -> None:
    """l_i = z_i x (p - o_i)."""
    for i in range(count):
        x = origins[count, 0] - origins[i, 0]
        y = origins[count, 1] - origins[i, 1]
        z = origins[count, 2] - origins[i, 2]
        levers[i, 0] = axes[i, 1] * z - axes[i, 2] * y
        levers[i, 1] = axes[i, 2] * x - axes[i, 0] * z
        levers[i, 2] = axes[i, 0] * y - axes[i, 1] * x


@compiled
def expand(
    q: Vector,
    chains: Chains,
    goal: Goal,
    multipliers: Multipliers,
    geometry: Geometry,
    free: Indices,
    slots: Indices,
    g: Vector,
    H: Matrix,
    B: Matrix,
) -> float:
    """The whole cost; its gradient and the lower triangle of its Hessian over the free joints.

    Args:
        q: posture (n,).
        chains: of all tips.
        goal: what the cost is of.
        multipliers: of the conditions.
        geometry: room; the residuals are left in it.
        free: the free joints (f,).
        slots: place of each joint among the free ones (n,), -1 for a blocked one.
        g: result (f,).
        H: result (f, f), the part that is never negative.
        B: result (f, f), the rest of the Hessian.
    """
    bend_posture(q, goal, free, g, H, B)
    value = posture_cost(q, goal)
    for t in range(len(chains.counts)):
        if goal.roles[t, 0] == IGNORED and goal.roles[t, 1] == IGNORED:
            continue
        k, b = residual(q, chains, goal, geometry, t)
        axes, origins, levers, pull = (
            geometry.axes,
            geometry.origins,
            geometry.levers,
            geometry.pull,
        )
        count = chains.counts[t]
        for part in range(2):
            if goal.roles[t, part] == IGNORED:
                continue
            value += pulled(
                goal.roles[t, part],
                geometry.residuals[t, part],
                multipliers.y[t, part],
                multipliers.rho[part],
                multipliers.radii[part],
                goal.weights[part],
                pull,
            )
            if part == 0:
                reach(count, axes, origins, levers)
                bend(chains, t, slots, levers, axes, pull, 1.0, g, H, B)
            else:
                if goal.roles[t, 1] == COST:  # f'' through Jl^-1: exact, since v is along e
                    e = geometry.residuals[t, 1]
                    pull[1, 0], pull[1, 1], pull[1, 2] = e[0], e[1], e[2]
                    pull[2, 1] = b * pull[2, 0]
                    pull[2, 0] *= k
                else:
                    through_rotation(geometry.residuals[t, 1], k, b, pull[0])
                bend(chains, t, slots, axes, axes, pull, 0.5, g, H, B)
    return value
