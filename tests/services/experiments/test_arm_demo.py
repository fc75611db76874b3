"""The arm demo: a ball that is moved as a person would, and one run in virtual time."""

import numpy as np
import pytest

from benchmarks.arm_demo import run_virtual
from benchmarks.arm_demo_ball import BODY_CLEAR_M, PEAK_M_S, MovedBall
from services.experiments.whole_arm.draw import point_segments
from services.experiments.whole_arm.referee import Array

GOALS = np.array([-0.4, 0.0, 0.1]), np.array([-0.3, 0.2, 0.1])
BODY = np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]]]), np.array([0.1])
RADIUS_M, LENGTH_S = 0.04, 30.0


def places(seed: int) -> Array:
    """Every 10 ms."""
    ball = MovedBall(np.random.default_rng(seed), GOALS, RADIUS_M, BODY, LENGTH_S)
    return np.array([ball.at(t) for t in np.arange(0.0, LENGTH_S, 0.01)])


def test_the_ball_is_never_faster_than_a_stroke_may_be() -> None:
    speeds = np.linalg.norm(np.diff(places(0), axis=0), axis=1) / 0.01
    assert speeds.max() <= PEAK_M_S[1] * 1.01
    assert speeds.max() > PEAK_M_S[0]


def test_the_ball_rests_between_strokes() -> None:
    speeds = np.linalg.norm(np.diff(places(0), axis=0), axis=1)
    assert (speeds == 0.0).sum() > 100  # a second of thirty, at least


def test_the_ball_comes_into_the_hands_way_and_keeps_off_the_body() -> None:
    way = places(1)
    segments, radii = BODY
    line = np.array([GOALS])
    assert min(point_segments(p, line)[0] for p in way) < 0.06
    off = min(float((point_segments(p, segments) - radii).min()) for p in way) - RADIUS_M
    assert off >= BODY_CLEAR_M - 0.005  # strokes are looked at in 15 places


def test_another_seed_moves_it_elsewhere() -> None:
    assert np.array_equal(places(2), places(2))
    assert not np.allclose(places(2), places(3))


@pytest.mark.slow
def test_the_hand_goes_to_and_fro_past_the_ball_and_touches_nothing() -> None:
    shown = run_virtual(0)
    assert shown.failure == ""
    assert shown.verdict.obstacle.distance_m > 0.0
    assert shown.reached >= 6
