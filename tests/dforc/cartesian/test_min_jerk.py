"""Minimum-jerk feedback laws against their closed forms."""

import numpy as np
import pytest

from dforc.cartesian.min_jerk import LagState, Motion, advance, lag_step

PERIOD_S = 0.01


def profile(s: float) -> float:
    """Minimum jerk from 0 to 1."""
    return 10 * s**3 - 15 * s**4 + 6 * s**5


def test_time_to_go_law_is_the_minimum_jerk_profile() -> None:
    motion = Motion(np.array([-1.0]), np.zeros(1), np.zeros(1))
    for tick in range(100):
        motion = advance(motion, 1.0 - tick * PERIOD_S, PERIOD_S)
        s = (tick + 1) * PERIOD_S
        assert 1.0 + motion.error[0] == pytest.approx(profile(s), abs=1e-12)
    assert motion.velocity[0] == pytest.approx(0.0, abs=1e-9)


def test_velocity_and_acceleration_are_derivatives_of_the_error() -> None:
    start = Motion(np.array([0.3, -0.1]), np.array([1.0, 0.2]), np.array([-4.0, 2.0]))
    before, here, after = (advance(start, 0.4, t) for t in (0.0999, 0.1, 0.1001))
    assert here.velocity == pytest.approx((after.error - before.error) / 2e-4, rel=1e-6)
    assert here.acceleration == pytest.approx((after.velocity - before.velocity) / 2e-4, rel=1e-6)


def test_last_period_lands_at_rest() -> None:
    motion = Motion(np.array([0.3]), np.array([1.0]), np.array([-4.0]))
    landed = advance(motion, PERIOD_S, PERIOD_S)
    assert (landed.error[0], landed.velocity[0], landed.acceleration[0]) == (0.0, 0.0, 0.0)


def test_held_time_to_go_is_stable_and_trails_an_acceleration_by_its_formula() -> None:
    motion, time_to_go_s, acceleration = Motion(np.zeros(1), np.zeros(1), np.zeros(1)), 0.2, 1.0
    for _ in range(300):
        motion = advance(motion, time_to_go_s, PERIOD_S)
        # the target gains speed: in its frame the value loses it
        motion = Motion(
            motion.error, motion.velocity - acceleration * PERIOD_S, motion.acceleration
        )
    assert motion.error[0] == pytest.approx(-0.15 * time_to_go_s**2 * acceleration, rel=0.15)


def lag_response(target: list[float]) -> list[float]:
    state, x, path = LagState.at_rest(1), np.zeros(1), []
    for wanted in target:
        state, velocity = lag_step(state, wanted - x, 1.0, PERIOD_S)
        x = x + PERIOD_S * velocity
        path.append(float(x[0]))
    return path


def test_lag_law_is_at_90_percent_after_the_trajectory_time_without_overshoot() -> None:
    path = lag_response([1.0] * 400)
    assert path[99] == pytest.approx(0.90, abs=0.01)
    assert next(i for i, x in enumerate(path) if x > 0.98) == pytest.approx(141, abs=5)
    assert max(path) < 1.0 + 1e-4


def test_lag_law_trails_a_ramp_by_0_564_of_the_trajectory_time() -> None:
    path = lag_response([i * PERIOD_S for i in range(600)])
    assert 599 * PERIOD_S - path[-1] == pytest.approx(0.564, abs=0.015)
