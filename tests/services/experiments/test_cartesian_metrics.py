"""Figures of a motion, against motions whose figures can be worked out."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from services.experiments.cartesian.metrics import (
    distances_to_curve,
    estimate,
    judge_move,
    minimum_jerk,
    reached_s,
    squared_jerk,
)

Vector = NDArray[np.float64]

PERIOD_S = 0.01
START, GOAL = np.array([0.1, 0.2, 0.3]), np.array([0.1, 0.5, 0.3])
AT_S: Vector = np.arange(301, dtype=np.float64) * PERIOD_S


def straight(share: Vector) -> Vector:
    return START + np.outer(share, GOAL - START)


def test_a_minimum_jerk_motion_is_its_own_ideal() -> None:
    found = judge_move(straight(minimum_jerk(AT_S / 1.2)), START, GOAL, PERIOD_S)
    assert found.distance_m == pytest.approx(0.3)
    assert found.perpendicular < 1e-9
    assert found.deviation < 1e-3
    assert found.profile_rms < 1e-3
    assert found.fitted_s == pytest.approx(1.2, abs=0.005)
    assert found.since_jump_s == pytest.approx(1.2, abs=0.005)
    assert found.onset_s == pytest.approx(0.0, abs=0.005)
    # 10 s^3 - 15 s^4 + 6 s^5 = 0.98 at s = 0.8647
    assert found.t98_s == pytest.approx(0.8647 * 1.2, abs=0.001)
    assert found.peak_share == pytest.approx(0.5 / 0.8647, abs=0.01)
    assert found.jerk == pytest.approx(1.0, abs=0.05)
    assert found.overshoot < 1e-9


def test_a_late_motion_has_an_onset_and_counts_as_longer_from_the_jump() -> None:
    found = judge_move(straight(minimum_jerk((AT_S - 0.1) / 1.2)), START, GOAL, PERIOD_S)
    assert found.onset_s == pytest.approx(0.1, abs=0.005)
    assert found.fitted_s == pytest.approx(1.2, abs=0.005)
    assert 1.3 < found.since_jump_s < 1.45
    assert found.t98_s == pytest.approx(0.1 + 0.8647 * 1.2, abs=0.001)


def test_an_arc_is_as_far_off_the_line_as_it_is_high() -> None:
    share = minimum_jerk(AT_S / 1.2)
    bent = straight(share) + np.outer(0.03 * np.sin(np.pi * share), [1.0, 0.0, 0.0])
    found = judge_move(bent, START, GOAL, PERIOD_S)
    assert found.perpendicular == pytest.approx(0.1, abs=1e-4)
    assert found.deviation == pytest.approx(0.1, abs=0.002)


def test_a_jump_at_the_onset_costs_jerk_and_an_overshoot_is_seen() -> None:
    exponential = 1.0 - np.exp(-4.0 * AT_S)
    found = judge_move(straight(exponential), START, GOAL, PERIOD_S)
    # a jump of v in one period: twice (v / h^2)^2 h, over 720 L^2 / T^5
    jump_per_s = exponential[1] / PERIOD_S
    by_hand = 2.0 * jump_per_s**2 / PERIOD_S**3 * found.fitted_s**5 / 720.0
    assert found.jerk == pytest.approx(by_hand, rel=0.1)
    beyond = 1.05 * minimum_jerk(AT_S / 1.2)
    assert judge_move(straight(beyond), START, GOAL, PERIOD_S).overshoot == pytest.approx(0.05)


def test_smoothing_takes_away_what_is_fast_and_leaves_the_motion() -> None:
    rng = np.random.default_rng(0)
    noisy = straight(minimum_jerk(AT_S / 1.2)) + rng.normal(0.0, 2e-5, (301, 3))
    rough = judge_move(noisy, START, GOAL, PERIOD_S)
    smooth = judge_move(noisy, START, GOAL, PERIOD_S, smoothed_hz=5.0)
    assert rough.jerk > 100.0
    assert smooth.jerk < 0.02 * rough.jerk


def test_a_way_that_is_never_covered_has_no_time() -> None:
    assert reached_s(np.array([0.0, 0.5, 0.9]), PERIOD_S) == math.inf
    assert reached_s(np.array([0.0, 0.5, 0.9, 1.0]), PERIOD_S) == pytest.approx(0.028)


def test_the_squared_jerk_of_a_cubic_is_that_of_its_third_derivative() -> None:
    cubic = np.zeros((101, 3))
    cubic[:, 0] = 2.0 * (np.arange(101) * PERIOD_S) ** 3  # jerk 12 from the beginning on, over 1 s
    assert squared_jerk(cubic, PERIOD_S) == pytest.approx(144.0, rel=0.03)


def test_distances_to_a_curve_are_to_its_nearest_point() -> None:
    curve = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    hand = np.array([[0.1, 0.0, 0.0], [1.0, 0.0, 0.3]])
    assert distances_to_curve(hand, curve) == pytest.approx([0.1, 0.3])


def test_confidence_is_students() -> None:
    found = estimate([1.0, 2.0, 3.0])
    assert found.mean == pytest.approx(2.0)
    assert found.half_width == pytest.approx(4.3027 / math.sqrt(3.0), rel=1e-4)
    assert estimate([5.0]).half_width == 0.0
    assert estimate([1.0, math.inf]).mean == math.inf
