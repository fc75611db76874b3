"""The tracker of one object, on motions whose truth is known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from dforc.errors import NotFiniteError, ShapeError
from dforc.field.tracking import ObjectTracker, Sample, TrackingError

Array = NDArray[np.float64]

PERIOD_S = 0.01
NOISE_M = 0.01
COVARIANCE = NOISE_M**2 * np.eye(3)


def follow(truth: Array, seed: int = 0, keep: float = 1.0) -> tuple[ObjectTracker, Array, Array]:
    """A tracker behind a path (k, 3) seen with noise, and its places and velocities."""
    rng = np.random.default_rng(seed)
    tracker = ObjectTracker()
    places, velocities = [], []
    for i, place in enumerate(truth):
        sample = place + rng.normal(0.0, NOISE_M, 3)
        if i == 0 or rng.uniform() < keep:
            tracker.update(PERIOD_S * i, sample, COVARIANCE)
        state = tracker.at(PERIOD_S * i)
        places.append(state.position_m)
        velocities.append(state.velocity_m_s)
    return tracker, np.array(places), np.array(velocities)


def straight(velocity_m_s: tuple[float, float, float], duration_s: float) -> Array:
    return np.outer(PERIOD_S * np.arange(round(duration_s / PERIOD_S)), velocity_m_s)


def rms(errors: Array) -> float:
    return float(np.sqrt((errors**2).sum(axis=1).mean()))


def test_the_first_sample_is_where_the_object_is() -> None:
    tracker = ObjectTracker()
    assert tracker.update(3.0, (0.1, 0.2, 0.3), COVARIANCE) is Sample.RESTARTED
    position, velocity, sigma_m = tracker.at(3.0)
    np.testing.assert_array_equal(position, (0.1, 0.2, 0.3))
    np.testing.assert_array_equal(velocity, np.zeros(3))
    assert sigma_m == pytest.approx(NOISE_M)


def test_averages_an_object_at_rest_to_a_fifth_of_the_noise() -> None:
    tracker, places, _ = follow(np.zeros((600, 3)))
    assert tracker.at_rest
    assert rms(places[400:]) < 0.2 * NOISE_M * np.sqrt(3.0)


def test_does_not_lag_behind_steady_motion() -> None:
    truth = straight((0.1, 0.0, 0.0), 4.0)
    _, places, velocities = follow(truth)
    assert abs((places - truth)[200:, 0].mean()) < 0.003
    assert velocities[200:, 0].mean() == pytest.approx(0.1, abs=0.005)


def test_comes_to_rest_after_the_object() -> None:
    truth = np.vstack([straight((0.1, 0.0, 0.0), 2.0), np.tile((0.2, 0.0, 0.0), (500, 1))])
    tracker, places, velocities = follow(truth)
    assert tracker.at_rest
    assert rms((places - truth)[400:]) < 0.005
    assert rms(velocities[600:]) < 0.003


def test_follows_an_object_that_starts_suddenly() -> None:
    truth = np.vstack([np.zeros((300, 3)), straight((0.0, 0.0, -0.4), 2.0)])
    tracker, places, _ = follow(truth)
    assert not tracker.at_rest
    assert rms((places - truth)[340:]) < 0.012


def test_needs_only_some_of_the_samples() -> None:
    truth = straight((0.1, 0.05, 0.0), 4.0)
    _, places, _ = follow(truth, keep=0.3)
    assert rms((places - truth)[200:]) < 0.01


def test_skips_an_outlier() -> None:
    tracker, _, _ = follow(np.zeros((200, 3)))
    before = tracker.at(2.0).position_m
    assert tracker.update(2.0, (1.0, 0.0, 0.0), COVARIANCE) is Sample.SKIPPED
    np.testing.assert_allclose(tracker.at(2.0).position_m, before, atol=1e-3)


def test_starts_anew_where_an_object_has_jumped_to() -> None:
    tracker, _, _ = follow(np.zeros((200, 3)))
    taken = [tracker.update(2.0 + PERIOD_S * i, (1.0, 0.0, 0.0), COVARIANCE) for i in range(3)]
    assert taken == [Sample.SKIPPED, Sample.SKIPPED, Sample.RESTARTED]
    np.testing.assert_allclose(tracker.at(2.02).position_m, (1.0, 0.0, 0.0))


def test_ignores_a_sample_that_is_not_newer() -> None:
    tracker = ObjectTracker()
    tracker.update(1.0, (0.0, 0.0, 0.0))
    assert tracker.update(1.0, (0.5, 0.0, 0.0)) is Sample.IGNORED
    np.testing.assert_array_equal(tracker.at(1.0).position_m, np.zeros(3))


def test_uses_a_velocity_that_is_given() -> None:
    tracker = ObjectTracker()
    tracker.update(0.0, (0.0, 0.0, 0.0), velocity_m_s=(0.3, 0.0, 0.0))
    np.testing.assert_allclose(tracker.at(0.1).position_m, (0.03, 0.0, 0.0), atol=2e-4)


def test_doubt_grows_while_nothing_is_seen() -> None:
    tracker, _, _ = follow(straight((0.1, 0.0, 0.0), 2.0))
    assert tracker.at(2.5).sigma_m > 2.0 * tracker.at(2.0).sigma_m


def test_extrapolates_for_half_a_second_only() -> None:
    tracker = ObjectTracker()
    tracker.update(0.0, (0.0, 0.0, 0.0), velocity_m_s=(0.3, 0.0, 0.0))
    state = tracker.at(10.0)
    np.testing.assert_allclose(state.position_m, (0.15, 0.0, 0.0), atol=1e-3)
    np.testing.assert_array_equal(state.velocity_m_s, np.zeros(3))


def test_an_uncertain_axis_moves_less() -> None:
    tracker = ObjectTracker()
    R = np.diag([1e-6, 1e-2, 1e-6])
    for i in range(3):
        tracker.update(PERIOD_S * i, (0.0, 0.0, 0.0), 1e-6 * np.eye(3))
    tracker.update(0.03, (0.002, 0.002, 0.0), R)
    x, y, _ = tracker.at(0.03).position_m
    assert x > 0.0005
    assert abs(y) < 1e-5


def test_refuses_what_is_no_number() -> None:
    tracker = ObjectTracker()
    tracker.update(0.0, (0.1, 0.0, 0.0))
    with pytest.raises(NotFiniteError):
        tracker.update(0.1, (np.nan, 0.0, 0.0))
    with pytest.raises(NotFiniteError):
        tracker.update(np.inf, (0.0, 0.0, 0.0))
    with pytest.raises(ShapeError):
        tracker.update(0.1, (0.0, 0.0))
    np.testing.assert_array_equal(tracker.at(0.0).position_m, (0.1, 0.0, 0.0))


@pytest.mark.parametrize(
    "covariance", [np.zeros((3, 3)), np.diag([1.0, 1.0, -1.0]), np.eye(2), np.full((3, 3), np.nan)]
)
def test_refuses_what_is_no_covariance(covariance: Array) -> None:
    with pytest.raises(TrackingError):
        ObjectTracker().update(0.0, (0.0, 0.0, 0.0), covariance)


def test_knows_nothing_of_an_object_never_seen() -> None:
    tracker = ObjectTracker()
    assert not tracker.is_seen
    with pytest.raises(TrackingError, match="never been seen"):
        tracker.at(0.0)


def stroke(way_m: float, duration_s: float) -> Array:
    """Rest, a stroke of minimum jerk, rest."""
    s = np.clip((PERIOD_S * np.arange(600) - 3.0) / duration_s, 0.0, 1.0)
    return np.outer(way_m * s**3 * (10.0 - 15.0 * s + 6.0 * s**2), (0.6, 0.0, 0.8))


def avoided(truth: Array, noise_m: float, seed: int = 0) -> tuple[Array, Array]:
    """Places and velocities (k, 3) to keep clear of, behind a path."""
    rng = np.random.default_rng(seed)
    tracker = ObjectTracker()
    states = []
    for i, place in enumerate(truth):
        sample = place + rng.normal(0.0, noise_m, 3)
        tracker.update(PERIOD_S * i, sample, noise_m**2 * np.eye(3))
        states.append(tracker.avoided_at(PERIOD_S * i))
    places, velocities, _ = zip(*states, strict=True)
    return np.array(places), np.array(velocities)


def test_what_is_kept_clear_of_is_where_a_hand_has_it_from_the_first_moment() -> None:
    truth = stroke(0.3, 1.6)  # 0.35 m/s at its peak
    for seed in range(5):
        places, _ = avoided(truth, 0.005, seed)
        assert np.linalg.norm(places - truth, axis=1)[20:].max() < 0.018


def test_what_is_kept_clear_of_stands_still_with_its_object() -> None:
    places, velocities = avoided(np.zeros((600, 3)), 0.005)
    still = (velocities[300:] == 0.0).all(axis=1) | (
        np.linalg.norm(velocities[300:], axis=1) < 0.01
    )
    assert still.mean() > 0.9
    assert rms(places[300:]) < 0.004


def test_nothing_can_be_kept_clear_of_what_was_never_seen() -> None:
    with pytest.raises(TrackingError, match="never been seen"):
        ObjectTracker().avoided_at(0.0)


@pytest.mark.parametrize("rate_hz", [30.0, 100.0])
@pytest.mark.parametrize("speed_m_s", [0.6, 1.2, 2.0])
@pytest.mark.parametrize("noise_m", [0.0, 0.005])
def test_tracks_what_is_fast_from_the_first_sight_on(
    noise_m: float, speed_m_s: float, rate_hz: float
) -> None:
    rng, tracker = np.random.default_rng(3), ObjectTracker(0.001)
    covariance = None if noise_m == 0.0 else noise_m**2 * np.eye(3)
    for k in range(round(0.5 * rate_hz)):
        place = np.array([speed_m_s * k / rate_hz, 0.0, 0.0])
        tracker.update(k / rate_hz, place + rng.normal(0.0, noise_m, 3), covariance)
    for state in (tracker.at(k / rate_hz), tracker.avoided_at(k / rate_hz)):
        assert state.velocity_m_s[0] == pytest.approx(speed_m_s, rel=0.15)
        assert np.linalg.norm(state.position_m - place) < 0.015


def test_tracks_what_a_hand_throws_after_it_stood_still() -> None:
    """Rest, then 1 m/s at once: known by the third odd sample, and no slower than it is."""
    tracker = ObjectTracker()
    for i in range(60):
        x = 0.0 if i < 30 else (i - 29) / 30.0
        tracker.update(i / 30.0, (x, 0.0, 0.0), 0.005**2 * np.eye(3))
        if i >= 32:
            assert tracker.at(i / 30.0).velocity_m_s[0] == pytest.approx(1.0, rel=0.1)
