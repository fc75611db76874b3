"""Small strictly convex quadratic programs, for numba: Goldfarb and Idnani's dual method (1983).

minimise 1/2 x' H x + g' x subject to lower <= C x <= upper, from the free minimum, adding one
violated constraint at a time. H comes as its Cholesky factor L. J = L^-T Q and the triangle R hold
the factorisation of the active normals, J' N = (R; 0), and are updated by plane rotations.
"""

import math

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled

TOLERANCE = 1e-10  # violation that counts as kept, in the unit of the constraint
DEPENDENT = 1e-14  # square of a normal's part outside the active ones, as a share of the whole
STEPS_PER_CONSTRAINT = 5
EXCLUDED, UNSETTLED = -1, -2  # instead of the number of active constraints


@compiled
def factorise(H: Matrix, n: int, shift: float, L: Matrix) -> bool:
    """Cholesky factor of H + shift I in the lower triangle of L; False if it is not positive."""
    for j in range(n):
        pivot = H[j, j] + shift
        for k in range(j):
            pivot -= L[j, k] * L[j, k]
        if not pivot > 1e-12 * (abs(H[j, j]) + shift):
            return False
        root = math.sqrt(pivot)
        L[j, j] = root
        for i in range(j + 1, n):
            value = H[i, j]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            L[i, j] = value / root
    return True


@compiled
def free_minimum(L: Matrix, g: Vector, n: int, J: Matrix, d: Vector, x: Vector) -> None:
    """J = L^-T, x = -J J' g."""
    for j in range(n):  # column j of L^-T is row j of L^-1
        for i in range(n):
            J[i, j] = 0.0
        J[j, j] = 1.0 / L[j, j]
        for i in range(j - 1, -1, -1):
            value = 0.0
            for k in range(i, j):
                value += L[j, k] * J[i, k]
            J[i, j] = -value / L[j, j]
    for j in range(n):
        value = 0.0
        for i in range(j + 1):
            value += J[i, j] * g[i]
        d[j] = value
    for i in range(n):
        value = 0.0
        for j in range(i, n):
            value -= J[i, j] * d[j]
        x[i] = value


@compiled
def most_violated(
    C: Matrix, lower: Vector, upper: Vector, x: Vector, n: int
) -> tuple[int, float, float]:
    """Constraint, its side (+1 lower, -1 upper) and by how much; (-1, 0, 0) if all are kept."""
    row, side, worst = -1, 0.0, TOLERANCE
    for i in range(C.shape[0]):
        value = 0.0
        for k in range(n):
            value += C[i, k] * x[k]
        if lower[i] - value > worst:
            row, side, worst = i, 1.0, lower[i] - value
        if value - upper[i] > worst:
            row, side, worst = i, -1.0, value - upper[i]
    if row < 0:
        worst = 0.0
    return row, side, worst


@compiled
def directions(
    J: Matrix, R: Matrix, normal: Vector, side: float, n: int, q: int, work: Matrix
) -> tuple[float, float]:
    """Set d = J' n, step z, and r, what active multipliers lose per unit. Slope z' n, and |d|^2."""
    d, z, r = work[0], work[1], work[2]
    whole, slope = 0.0, 0.0
    for j in range(n):
        value = 0.0
        for i in range(n):
            value += J[i, j] * normal[i]
        d[j] = side * value
        whole += value * value
        if j >= q:
            slope += value * value
    for i in range(n):
        value = 0.0
        for j in range(q, n):
            value += J[i, j] * d[j]
        z[i] = value
    for i in range(q - 1, -1, -1):
        value = d[i]
        for k in range(i + 1, q):
            value -= R[i, k] * r[k]
        r[i] = value / R[i, i]
    return slope, whole


@compiled
def first_to_leave(r: Vector, multipliers: Vector, q: int) -> tuple[int, float]:
    """Which active constraint's multiplier reaches zero first, and after how long a step."""
    leaving, step = -1, math.inf
    for k in range(q):
        if r[k] > 0.0 and multipliers[k] / r[k] < step:
            leaving, step = k, max(0.0, multipliers[k] / r[k])
    return leaving, step


@compiled
def turn(J: Matrix, n: int, a: int, b: int, cosine: float, sine: float) -> None:
    """Rotate two columns of J."""
    for i in range(n):
        x, y = J[i, a], J[i, b]
        J[i, a] = cosine * x + sine * y
        J[i, b] = cosine * y - sine * x


@compiled
def take_in(J: Matrix, R: Matrix, d: Vector, n: int, q: int) -> None:
    """Make the normal behind d = J' n the last active one."""
    for j in range(n - 1, q, -1):
        size = math.hypot(d[j - 1], d[j])
        if size > 0.0:
            cosine, sine = d[j - 1] / size, d[j] / size
            d[j - 1], d[j] = size, 0.0
            turn(J, n, j - 1, j, cosine, sine)
    for i in range(q + 1):
        R[i, q] = d[i]


@compiled
def let_go(J: Matrix, R: Matrix, active: Matrix, n: int, q: int, leaving: int) -> None:
    """Take one active constraint out. Columns of `active`: row, side, multiplier."""
    for k in range(leaving, q - 1):
        for i in range(q):
            R[i, k] = R[i, k + 1]
        for i in range(3):
            active[i, k] = active[i, k + 1]
    for k in range(leaving, q - 1):
        size = math.hypot(R[k, k], R[k + 1, k])
        if size > 0.0:
            cosine, sine = R[k, k] / size, R[k + 1, k] / size
            for j in range(k, q - 1):
                x, y = R[k, j], R[k + 1, j]
                R[k, j] = cosine * x + sine * y
                R[k + 1, j] = cosine * y - sine * x
            turn(J, n, k, k + 1, cosine, sine)


@compiled
def add(
    C: Matrix,
    x: Vector,
    J: Matrix,
    R: Matrix,
    active: Matrix,
    work: Matrix,
    n: int,
    q: int,
    row: int,
    side: float,
    violation: float,
) -> int:
    """Move x to where the violated constraint holds, dropping others that stand in the way."""
    multiplier = 0.0
    while True:
        slope, whole = directions(J, R, C[row], side, n, q, work)
        can_move = slope > DEPENDENT * whole and q < n
        full = violation / slope if can_move else math.inf
        leaving, partial = first_to_leave(work[2], active[2], q)
        step = min(full, partial)
        if step == math.inf:
            return EXCLUDED
        for k in range(q):
            active[2, k] -= step * work[2, k]
        multiplier += step
        if can_move:
            for i in range(n):
                x[i] += step * work[1, i]
            violation -= step * slope
        if step == full:
            take_in(J, R, work[0], n, q)
            active[0, q], active[1, q], active[2, q] = float(row), side, multiplier
            return q + 1
        let_go(J, R, active, n, q, leaving)
        q -= 1


@compiled
def solve_factorised(
    L: Matrix,
    g: Vector,
    C: Matrix,
    lower: Vector,
    upper: Vector,
    n: int,
    x: Vector,
    J: Matrix,
    R: Matrix,
    active: Matrix,
    work: Matrix,
) -> int:
    """The minimiser in x. Number of active constraints, or EXCLUDED or UNSETTLED.

    Args:
        L: Cholesky factor of H, lower triangle, (>= n, >= n).
        g: gradient (>= n).
        C: rows of about unit size (m, >= n); only the first n columns count.
        lower: (m,), -inf where open.
        upper: (m,), +inf where open.
        n: size of x.
        x: result (>= n).
        J: room (>= n, >= n).
        R: room (>= n, >= n).
        active: result (3, >= n): row, side (+1 lower, -1 upper) and multiplier of each active one.
        work: room (3, >= n).
    """
    free_minimum(L, g, n, J, work[0], x)
    q = 0
    for _ in range(STEPS_PER_CONSTRAINT * (C.shape[0] + 1)):
        row, side, violation = most_violated(C, lower, upper, x, n)
        if row < 0:
            return q
        q = add(C, x, J, R, active, work, n, q, row, side, violation)
        if q < 0:
            return q
    return UNSETTLED


@compiled
def solve_quadratic(
    H: Matrix, g: Vector, C: Matrix, lower: Vector, upper: Vector, room: Matrix
) -> int:
    """The minimiser in room[0]; H is factorised here. `room` is (4 n + 7, n) at least.

    Returns the number of active constraints, EXCLUDED or UNSETTLED.
    """
    n = len(g)
    L, J, R = room[7 : 7 + n], room[7 + n : 7 + 2 * n], room[7 + 2 * n : 7 + 3 * n]
    if not factorise(H, n, 0.0, L):
        return UNSETTLED
    return solve_factorised(L, g, C, lower, upper, n, room[0], J, R, room[1:4], room[4:7])
