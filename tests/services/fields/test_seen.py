"""What an object is taken for by what must not touch it."""

from dataclasses import replace
from itertools import pairwise

import pytest

from dforc.collision.obstacles import Obstacle, sphere
from services.fields.seen import (
    AHEAD_S,
    SIGMAS,
    SURGE_M,
    WIDEST_M,
    SeenObject,
    Sighting,
    as_obstacle,
)


def seen(solid: Obstacle, *, sigma_m: float = 0.0, avoided: Sighting | None = None) -> SeenObject:
    return SeenObject(
        name="ball", source="eyes", solid=solid, role="obstacle", on=True,
        sigma_m=sigma_m, avoided=avoided,
    )  # fmt: skip


def moving(speed_m_s: float) -> Obstacle:
    return replace(sphere("ball", (0.1, 0.2, 0.3), 0.04), velocity_m_s=(speed_m_s, 0.0, 0.0))


def test_what_stands_and_is_known_exactly_has_no_margin() -> None:
    ball = sphere("ball", (0.1, 0.2, 0.3), 0.04)
    assert as_obstacle(seen(ball)) is ball


def test_doubt_about_what_stands_is_a_margin() -> None:
    obstacle = as_obstacle(seen(moving(0.0), sigma_m=0.004))
    assert obstacle.margin_m == pytest.approx(SIGMAS * 0.004)
    assert obstacle.position_m == (0.1, 0.2, 0.3)


def test_what_moves_fills_all_that_it_passes_and_more() -> None:
    obstacle = as_obstacle(seen(moving(0.3)))
    assert obstacle.position_m == pytest.approx((0.1 + 0.3 * AHEAD_S, 0.2, 0.3))
    assert obstacle.margin_m == pytest.approx(0.3 * AHEAD_S + SURGE_M)
    assert obstacle.velocity_m_s == (0.3, 0.0, 0.0)


def test_margin_grows_without_a_step_as_an_object_begins_to_move() -> None:
    margins = [as_obstacle(seen(moving(0.002 * k))).margin_m for k in range(100)]
    assert max(b - a for a, b in pairwise(margins)) < 0.001


def test_no_margin_locks_the_hand_in() -> None:
    assert as_obstacle(seen(moving(2.0), sigma_m=0.05)).margin_m == WIDEST_M


@pytest.mark.parametrize("speed_m_s", [0.5, 1.3, 2.0, 8.0])
def test_the_ball_where_it_is_now_is_inside_however_fast_it_is(speed_m_s: float) -> None:
    obstacle = as_obstacle(seen(moving(speed_m_s), sigma_m=0.001))
    shift_m = obstacle.position_m[0] - 0.1
    assert 0.0 < shift_m <= obstacle.margin_m + 1e-12


def test_it_is_kept_clear_of_where_the_nimble_filter_has_it() -> None:
    place = Sighting((0.15, 0.2, 0.3), (0.0, 0.2, 0.0), 0.003)
    obstacle = as_obstacle(seen(moving(0.0), sigma_m=0.001, avoided=place))
    assert obstacle.position_m == pytest.approx((0.15, 0.2 + 0.2 * AHEAD_S, 0.3))
    assert obstacle.margin_m == pytest.approx(3.0 * 0.003 + 0.2 * AHEAD_S + SURGE_M)
