"""Joint limits and time base of PMP: signs, ends and values worked out by hand."""

import math

import numpy as np
import pytest

from dforc.pmp.fields import limit_field, time_base

LOWER, UPPER = np.array([-1.0, 0.0]), np.array([1.0, 2.0])


def test_limit_field_is_zero_half_way_and_pushes_away_from_both_ends() -> None:
    assert limit_field(np.array([0.0, 1.0]), LOWER, UPPER) == pytest.approx([0.0, 0.0])
    near_lower, near_upper = limit_field(np.array([-0.8, 1.8]), LOWER, UPPER)
    assert near_lower == pytest.approx(math.log(1.8 / 0.2))
    assert near_upper == pytest.approx(-math.log(1.8 / 0.2))


def test_limit_field_is_minus_twice_the_inverse_hyperbolic_tangent() -> None:
    q = np.array([0.3, 1.3])
    assert limit_field(q, LOWER, UPPER) == pytest.approx([-2.0 * math.atanh(0.3)] * 2)


def test_limit_field_stays_finite_at_and_beyond_the_limits() -> None:
    largest = math.log(1.9999 / 0.0001)
    assert limit_field(np.array([-1.0, 5.0]), LOWER, UPPER) == pytest.approx([largest, -largest])


def test_printed_lambda_would_not_push_at_the_upper_limit() -> None:
    """Without the factor 2 lambda is in -1..0: S is 0 at the top, where ours is at its largest."""
    printed = (UPPER - LOWER) / (UPPER - LOWER) - 1.0
    assert np.log((1.0 - printed) / (1.0 + printed)) == pytest.approx([0.0, 0.0])
    assert limit_field(UPPER, LOWER, UPPER)[0] < -9.0


def test_time_base_is_minimum_jerk_over_what_is_left() -> None:
    # s = 1/2: xi = 1/2, dxi = 30/16 / tau
    assert time_base(1.5, 3.0, 1e-3) == pytest.approx(30.0 / 16.0 / 3.0 / 0.501)


@pytest.mark.parametrize("time_s", [-1.0, 0.0, 3.0, 10.0])
def test_time_base_is_zero_outside_the_motion(time_s: float) -> None:
    assert time_base(time_s, 3.0, 1e-3) == 0.0


def test_time_base_integrates_to_the_logarithm_of_what_it_leaves() -> None:
    epsilon, dt_s = 1e-3, 1e-4
    total = sum(time_base((k + 0.5) * dt_s, 3.0, epsilon) for k in range(30000)) * dt_s
    assert total == pytest.approx(math.log((1.0 + epsilon) / epsilon), rel=1e-5)
