"""Quadratic programs: the optimality conditions of what comes back, checked one by one."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.quadratic import NoSolutionError, minimise


def problem(rng: np.random.Generator) -> tuple[Matrix, Vector, Matrix, Vector, Vector]:
    n, m = 10, 7
    B = rng.normal(size=(n, n))
    C = np.vstack([np.eye(n), rng.normal(size=(m, n))])
    inside = C @ rng.uniform(-1.0, 1.0, n)
    lower, upper = inside - rng.uniform(0.0, 1.0, n + m), inside + rng.uniform(0.0, 1.0, n + m)
    return B @ B.T + 0.1 * np.eye(n), rng.normal(size=n) * 5.0, C, lower, upper


@pytest.mark.parametrize("seed", range(30))
def test_answer_meets_the_optimality_conditions(seed: int) -> None:
    H, g, C, lower, upper = problem(np.random.default_rng(seed))
    x = minimise(H, g, C, lower, upper)
    values = C @ x
    assert (values >= lower - 1e-9).all()
    assert (values <= upper + 1e-9).all()
    at_lower, at_upper = values - lower < 1e-8, upper - values < 1e-8
    held = np.flatnonzero(at_lower | at_upper)
    assert len(held) > 0
    multipliers, *_ = np.linalg.lstsq(C[held].T, H @ x + g, rcond=None)
    assert C[held].T @ multipliers == pytest.approx(H @ x + g, abs=1e-7)
    pushes_up = at_lower[held]
    assert (multipliers[pushes_up] > -1e-7).all()
    assert (multipliers[~pushes_up] < 1e-7).all()


def test_free_minimum_is_returned_when_nothing_stands_in_the_way() -> None:
    H, g = np.diag([1.0, 2.0]), np.array([-1.0, -4.0])
    x = minimise(H, g, np.eye(2), np.array([-9.0, -9.0]), np.array([9.0, 9.0]))
    assert x == pytest.approx([1.0, 2.0])


def test_equal_bounds_hold_exactly() -> None:
    H, g = np.eye(2), np.zeros(2)
    x = minimise(H, g, np.array([[1.0, 1.0]]), np.array([2.0]), np.array([2.0]))
    assert x == pytest.approx([1.0, 1.0])


def test_constraints_that_exclude_each_other_are_named() -> None:
    C = np.array([[1.0, 0.0], [1.0, 0.0]])
    with pytest.raises(NoSolutionError):
        minimise(np.eye(2), np.zeros(2), C, np.array([1.0, -5.0]), np.array([2.0, 0.0]))
