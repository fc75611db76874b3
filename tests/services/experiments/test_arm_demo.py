"""The arm demo: a ball that is moved as a person would, and one run in virtual time."""

import numpy as np
import pytest

from benchmarks.arm_demo import rows_of, run_virtual
from benchmarks.arm_demo_ball import BODY_CLEAR_M, PEAK_M_S, MovedBall
from benchmarks.arm_demo_job import Shown
from services.experiments.whole_arm.draw import point_segments
from services.experiments.whole_arm.referee import Array, Nearest, Verdict

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


def missed(*found: Shown) -> list[str]:
    """Bars that do not hold, without the runs' name."""
    return [row.name.split(": ")[1] for row in rows_of(found, "virtual") if row.holds is False]


def judged(distance_m: float, reached: int) -> Shown:
    return Shown(
        seed=0,
        reached=reached,
        asked=8,
        verdict=Verdict(obstacle=Nearest(distance_m, ("r_hand", "ball"))),
    )


def test_three_goals_of_four_without_a_contact_hold() -> None:
    assert missed(judged(0.02, 6), judged(0.01, 6)) == []


def test_a_hand_that_stands_still_touches_nothing_and_fails() -> None:
    assert missed(judged(0.3, 8), judged(0.3, 0)) == ["goals reached to 10 mm"]


def test_a_run_in_which_nothing_was_judged_has_failed() -> None:
    assert missed(judged(0.02, 8), Shown(seed=1, reached=8, asked=8)) == ["runs that failed"]


@pytest.mark.slow
def test_the_hand_goes_to_and_fro_past_the_ball_and_touches_nothing() -> None:
    shown = run_virtual(0)
    assert shown.failure == ""
    assert shown.verdict.obstacle.distance_m > 0.0
    assert shown.reached >= 6
