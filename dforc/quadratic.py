"""Small strictly convex quadratic programs: dual active-set method (Goldfarb and Idnani, 1983).

For the ten joints of an arm and a handful of active limits. It starts at the free minimum, which is
the answer of almost every tick, and adds one violated constraint at a time.
"""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.errors import DforcError

TOLERANCE = 1e-10  # violation that counts as kept, in the unit of the constraint
STEPS_PER_CONSTRAINT = 5


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
        NoSolutionError: no x keeps all constraints.
    """
    H_inverse = np.asarray(np.linalg.inv(H), dtype=np.float64)
    x: Vector = -H_inverse @ g
    active = _ActiveSet(H_inverse, C)
    for _ in range(STEPS_PER_CONSTRAINT * (len(C) + 1)):
        values = C @ x
        below, above = lower - values, values - upper
        worst_below, worst_above = int(np.argmax(below)), int(np.argmax(above))
        if max(below[worst_below], above[worst_above]) <= TOLERANCE:
            return x
        if below[worst_below] >= above[worst_above]:
            x = active.add(x, worst_below, 1.0, float(below[worst_below]))
        else:
            x = active.add(x, worst_above, -1.0, float(above[worst_above]))
    raise NoSolutionError("the active set did not settle: constraints exclude each other")


class _ActiveSet:
    """Constraints held at equality, each with its sign (+1 lower, -1 upper) and multiplier."""

    def __init__(self, H_inverse: Matrix, C: Matrix) -> None:
        self._H_inverse = H_inverse
        self._C = C
        self._rows: list[int] = []
        self._signs: list[float] = []
        self._multipliers: list[float] = []

    def add(self, x: Vector, row: int, sign: float, violation: float) -> Vector:
        """Move x to where the violated constraint holds, dropping others that stand in the way."""
        normal = sign * self._C[row]
        multiplier = 0.0
        while True:
            direction, ratios = self._directions(normal)
            slope = float(normal @ direction)
            full_step = violation / slope if slope > TOLERANCE else np.inf
            dual_step, blocking = self._first_to_leave(ratios)
            step = min(full_step, dual_step)
            if step == np.inf:
                raise NoSolutionError(f"constraint {row} excludes the others")
            for index, ratio in enumerate(ratios):
                self._multipliers[index] -= step * float(ratio)
            multiplier += step
            if full_step < np.inf:
                x = x + step * direction
                violation -= step * slope
            if step == full_step:
                self._rows.append(row)
                self._signs.append(sign)
                self._multipliers.append(multiplier)
                return x
            for kept in (self._rows, self._signs, self._multipliers):
                kept.pop(blocking)

    def _directions(self, normal: Vector) -> tuple[Vector, Vector]:
        """Primal step per unit of the new multiplier, and what it takes from the held ones."""
        free: Vector = self._H_inverse @ normal
        if not self._rows:
            return free, np.zeros(0)
        N = (self._C[self._rows].T * self._signs).T  # (k, n)
        HN = N @ self._H_inverse  # (k, n)
        ratios = np.asarray(np.linalg.solve(HN @ N.T, HN @ normal), dtype=np.float64)
        direction: Vector = free - HN.T @ ratios
        return direction, ratios

    def _first_to_leave(self, ratios: Vector) -> tuple[float, int]:
        """Step at which a held constraint's multiplier reaches zero, and which one."""
        best, blocking = np.inf, -1
        for index, ratio in enumerate(ratios):
            if ratio > TOLERANCE and self._multipliers[index] / ratio < best:
                best, blocking = max(0.0, self._multipliers[index] / float(ratio)), index
        return best, blocking
