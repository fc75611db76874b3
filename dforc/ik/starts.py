"""Postures for a search to begin from: others where the first one ends beside the pose."""

from collections.abc import Iterator
from functools import cache

import numpy as np

from dforc.arrays import Vector
from dforc.ik.problem import IkProblem
from dforc.ik.solver import SearchBounds

# Parts of each joint's range, spread by the golden ratios of several dimensions: the same for all.
COUNT = 7
OUTSIDE = 1e-6  # a row may be missed by, where a blocked joint stands in the way of the projection
NEAR_RAD = 1e-3  # a start this near is the same one


def starts_of(problem: IkProblem, q_start: Vector, bounds: SearchBounds) -> Iterator[Vector]:
    """The start itself, the rest posture, then postures spread over the room of this search.

    All of them inside all limits.
    """
    yield q_start
    n = problem.n
    lower, upper = bounds.lower[:n], bounds.upper[:n]
    # Of a joint without an end, one turn counts.
    lower = np.where(np.isfinite(lower), lower, np.minimum(q_start, upper - np.pi) - np.pi)
    room = np.minimum(upper, lower + 2.0 * np.pi) - lower
    root = _root(n)
    share = np.array([root ** -(j + 1) for j in range(n)])
    for k in range(COUNT + 1):
        q = problem.rest_rad if k == 0 else lower + ((0.5 + k * share) % 1.0) * room
        inside = problem.limits.project(np.minimum(np.maximum(q, lower), upper))
        inside = np.minimum(np.maximum(inside, lower), upper)  # blocked joints stay
        if (
            problem.limits.violation(inside) <= OUTSIDE
            and np.abs(inside - q_start).max() > NEAR_RAD
        ):
            yield inside


@cache
def _root(n: int) -> float:
    """The root of x^(n + 1) = x + 1 (Roberts' low-discrepancy sequence)."""
    x = 1.5
    for _ in range(60):
        x = (1.0 + x) ** (1.0 / (n + 1))
    return x
