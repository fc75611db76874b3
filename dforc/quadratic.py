"""Small strictly convex quadratic programs, for the joints of a limb and a handful of limits."""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.errors import DforcError
from dforc.quadratic_kernel import EXCLUDED, solve_quadratic

ROOM_ROWS = 7  # beside three matrices


class NoSolutionError(DforcError):
    """The constraints exclude each other."""


def minimise(H: Matrix, g: Vector, C: Matrix, lower: Vector, upper: Vector) -> Vector:
    """Minimiser (n,) of 1/2 x' H x + g' x subject to lower <= C x <= upper.

    Args:
        H: (n, n) symmetric positive definite.
        g: (n,).
        C: (m, n), rows of about unit size.
        lower: (m,), -inf where open.
        upper: (m,), +inf where open.

    Raises:
        NoSolutionError: no x keeps all constraints, or H is not positive definite.
    """
    n = len(g)
    room = np.empty((ROOM_ROWS + 3 * n, n))
    count = solve_quadratic(_plain(H), _plain(g), _plain(C), _plain(lower), _plain(upper), room)
    if count == EXCLUDED:
        raise NoSolutionError("the constraints exclude each other")
    if count < 0:
        raise NoSolutionError("no minimum: the cost is not convex, or the limits do not settle")
    x: Vector = room[0].copy()
    return x


def _plain(values: Matrix) -> Matrix:
    """In rows, writable and float64: numba compiles the program once, for this type."""
    plain = np.ascontiguousarray(values, dtype=np.float64)
    return plain if plain.flags.writeable else plain.copy()
