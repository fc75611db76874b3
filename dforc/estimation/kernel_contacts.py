"""The contacts of one sub-model from the wrench that is missing in it, for numba.

A column of A is the wrench of one unknown about the sub-model's reference point (the middle of its
contacts), in base axes. Forces are in newtons; moments are divided by LEVER_M, on both sides, so
that all numbers are newtons. The answer is the least-squares one, of least norm where it is not the
only one: A = V S U' by one-sided Jacobi rotations of A', singular values below RANK_TOLERANCE of
the largest one dropped.
"""

import math

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.plan import DIRECTION, FORCE, LEVER_M, RANK_TOLERANCE, SEVERAL
from dforc.estimation.tree_model import Indices, Places

SWEEPS = 30
ROUNDING = 1e-15
VANISHING = 1e-28  # of the squared norm: rounding of what is zero


@compiled
def shift(missing: Vector, point: Vector, found: Vector) -> None:
    """The one whole wrench of a sub-model: what is missing, about its point."""
    fx, fy, fz = missing[0], missing[1], missing[2]
    found[0], found[1], found[2] = fx, fy, fz
    found[3] = missing[3] - (point[1] * fz - point[2] * fy)
    found[4] = missing[4] - (point[2] * fx - point[0] * fz)
    found[5] = missing[5] - (point[0] * fy - point[1] * fx)


@compiled
def solve_sub_model(
    method: int,
    members: Indices,
    contacts: Places,
    places: tuple[Matrix, Matrix],
    missing: Vector,
    scratch: tuple[Matrix, Matrix],
    wrenches: Matrix,
    numbers: Vector,
) -> None:
    """Fill in what is no single whole wrench: wrenches, residual about the reference, rank.

    `numbers` holds the reference point in its moments when called; `missing` is about the origin.
    """
    rx, ry, rz = numbers[3], numbers[4], numbers[5]
    fx, fy, fz = missing[0], missing[1], missing[2]
    mx = missing[3] - (ry * fz - rz * fy)
    my = missing[4] - (rz * fx - rx * fz)
    mz = missing[5] - (rx * fy - ry * fx)
    rank = 0
    if method == SEVERAL:
        target = scratch[1][6]
        target[0], target[1], target[2] = fx, fy, fz
        target[3], target[4], target[5] = mx / LEVER_M, my / LEVER_M, mz / LEVER_M
        numbers[6] = solve_several(members, contacts, places, scratch, wrenches, numbers)
        return
    if method == FORCE:
        found = wrenches[members[0]]
        found[0], found[1], found[2] = fx, fy, fz
        fx, fy, fz = 0.0, 0.0, 0.0
        rank = 3
    elif method == DIRECTION:
        found, n = wrenches[members[0]], places[1][members[0], 6:9]
        size = n[0] * fx + n[1] * fy + n[2] * fz
        found[0], found[1], found[2] = size * n[0], size * n[1], size * n[2]
        fx, fy, fz = fx - found[0], fy - found[1], fz - found[2]
        rank = 1
    numbers[0], numbers[1], numbers[2] = fx, fy, fz
    numbers[3], numbers[4], numbers[5] = mx, my, mz
    numbers[6] = rank


@compiled
def solve_several(
    members: Indices,
    contacts: Places,
    places: tuple[Matrix, Matrix],
    scratch: tuple[Matrix, Matrix],
    wrenches: Matrix,
    numbers: Vector,
) -> int:
    """Several contacts in one sub-model: least squares of least norm. Returns the rank."""
    W, V = scratch
    rows = fill(members, contacts, places, numbers, W)
    diagonalise(W, V, rows)
    rank = invert(W, V, rows, numbers)
    row = 0
    for i in members:
        found, n = wrenches[i], places[1][i, 6:9]
        for k in range(contacts[i, 1]):
            value = 0.0
            for c in range(6):
                value += W[row, c] * V[8, c]
            if contacts[i, 1] == 1:
                found[0], found[1], found[2] = value * n[0], value * n[1], value * n[2]
            else:
                found[k] = value if k < 3 else value * LEVER_M
            row += 1
    return rank


@compiled
def invert(W: Matrix, V: Matrix, rows: int, numbers: Vector) -> int:
    """Weights of the columns of W in the answer (row 8 of V), the residual, and the rank."""
    largest, rank = 0.0, 0
    for c in range(6):
        V[7, c] = 0.0
        numbers[c] = 0.0
        for r in range(rows):
            V[7, c] += W[r, c] * W[r, c]
        largest = max(largest, V[7, c])
    for c in range(6):
        along = 0.0
        for k in range(6):
            along += V[k, c] * V[6, k]
        if V[7, c] > RANK_TOLERANCE * RANK_TOLERANCE * largest:
            rank += 1
            V[8, c] = along / V[7, c]
        else:
            V[8, c] = 0.0
            for k in range(6):
                numbers[k] += V[k, c] * along * (1.0 if k < 3 else LEVER_M)
    return rank


@compiled
def fill(
    members: Indices,
    contacts: Places,
    places: tuple[Matrix, Matrix],
    numbers: Vector,
    W: Matrix,
) -> int:
    """A row of W for each unknown: its wrench about the reference. Returns how many there are."""
    points, table = places
    row = 0
    for i in members:
        x = (points[i, 0] - numbers[3]) / LEVER_M
        y = (points[i, 1] - numbers[4]) / LEVER_M
        z = (points[i, 2] - numbers[5]) / LEVER_M
        for k in range(contacts[i, 1]):
            for c in range(6):
                W[row, c] = 0.0
            if k >= 3:
                W[row, k] = 1.0
                row += 1
                continue
            nx, ny, nz = 0.0, 0.0, 0.0
            if contacts[i, 1] == 1:
                nx, ny, nz = table[i, 6], table[i, 7], table[i, 8]
            elif k == 0:
                nx = 1.0
            elif k == 1:
                ny = 1.0
            else:
                nz = 1.0
            W[row, 0], W[row, 1], W[row, 2] = nx, ny, nz
            W[row, 3], W[row, 4], W[row, 5] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
            row += 1
    return row


@compiled
def turn_columns(M: Matrix, rows: int, a: int, b: int, ratio: float) -> None:
    """The Jacobi rotation of two columns that makes their product vanish."""
    sign = 1.0 if ratio >= 0.0 else -1.0
    tangent = sign / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for r in range(rows):
        x, y = M[r, a], M[r, b]
        M[r, a], M[r, b] = cosine * x - sine * y, sine * x + cosine * y


@compiled
def diagonalise(W: Matrix, V: Matrix, rows: int) -> None:
    """Make the columns of W orthogonal by rotations from the right; V collects them."""
    total = 0.0
    for c in range(6):
        for k in range(6):
            V[k, c] = 1.0 if k == c else 0.0
        for r in range(rows):
            total += W[r, c] * W[r, c]
    for _ in range(SWEEPS):
        turns = 0
        for a in range(5):
            for b in range(a + 1, 6):
                aa, bb, ab = 0.0, 0.0, 0.0
                for r in range(rows):
                    aa += W[r, a] * W[r, a]
                    bb += W[r, b] * W[r, b]
                    ab += W[r, a] * W[r, b]
                if abs(ab) <= ROUNDING * math.sqrt(aa * bb) or abs(ab) <= VANISHING * total:
                    continue
                turns += 1
                ratio = (bb - aa) / (2.0 * ab)
                turn_columns(W, rows, a, b, ratio)
                turn_columns(V, 6, a, b, ratio)
        if turns == 0:
            return
