"""Minimum-jerk feedback laws against their closed forms."""

import numpy as np
import pytest

from dforc.cartesian.min_jerk import LagState, Motion, advance, lag_step, run_cubic

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


def cubic_run(
    velocity: float, acceleration: float, wanted: float, periods: int
) -> tuple[list[float], list[float], float]:
    """Speeds and accelerations over `periods` of a change of speed that takes so long; the way."""
    v, a, way, gone = np.array([velocity]), np.array([acceleration]), np.zeros(1), 0.0
    speeds, accelerations = [], []
    for left in range(periods, 0, -1):
        run_cubic(way, v, a, np.array([wanted]), left * PERIOD_S, PERIOD_S)
        gone += float(way[0])
        speeds.append(float(v[0]))
        accelerations.append(float(a[0]))
    return speeds, accelerations, gone


def test_change_of_speed_from_rest_follows_the_cubic_with_least_jerk() -> None:
    speeds, accelerations, gone = cubic_run(0.0, 0.0, 0.4, 30)
    s = np.arange(1, 31) / 30
    assert speeds == pytest.approx(0.4 * (3.0 * s**2 - 2.0 * s**3), abs=1e-12)
    assert accelerations == pytest.approx(0.4 / 0.3 * 6.0 * (s - s**2), abs=1e-9)
    assert gone == pytest.approx(0.4 * 0.3 / 2.0)


def test_stop_covers_half_of_speed_times_time_and_does_not_turn_back() -> None:
    speeds, _, gone = cubic_run(0.6, 0.0, 0.0, 40)
    assert gone == pytest.approx(0.6 * 0.4 / 2.0)
    assert min(speeds) == pytest.approx(0.0, abs=1e-12)
    assert (np.diff(speeds) < 0.0).all()


def test_change_of_speed_begins_at_the_acceleration_that_there_is() -> None:
    _, accelerations, gone = cubic_run(0.6, 2.0, 0.0, 4000)
    assert accelerations[0] == pytest.approx(2.0, rel=0.002)
    assert gone == pytest.approx(0.6 * 40.0 / 2.0 + 2.0 * 40.0**2 / 12.0)
