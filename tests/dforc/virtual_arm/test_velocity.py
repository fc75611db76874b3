"""Joint speeds for tasks, behind limits and surfaces: two joints, worked out by hand."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.virtual_arm.kernel_velocity import (
    AS_WANTED,
    EASED,
    FASTER,
    LIMIT_1_S,
    MISSED,
    Keeping,
    Wishes,
    choose_velocity,
    room_of,
)

PERIOD_S = 0.01


def choose(
    v: tuple[float, float],
    *,
    q: tuple[float, float] = (0.0, 0.0),
    before: tuple[float, float] | None = None,
    surfaces: tuple[tuple[float, float, float], ...] = (),
    pushes: tuple[float, ...] = (),
    acceleration: float = 1e6,
) -> tuple[int, Vector]:
    """Speeds for a hand that moves with the joints one to one; surfaces are (gradient, floor)."""
    gradients, floors = np.zeros((4, 2)), np.zeros(4)
    for k, (x, y, floor) in enumerate(surfaces):
        gradients[k], floors[k] = (x, y), floor
    wishes = Wishes(np.eye(2), np.array(v), np.full(2, 1e4), np.zeros(2), np.full(2, 1e-3))
    keeping = Keeping(
        np.vstack([np.eye(2), [[1.0, 1.0]]]),
        np.array([-1.0, -1.0, -1.5]),
        np.array([1.0, 1.0, 1.5]),
        np.full(2, 2.0),
        gradients,
        floors,
        np.array([*pushes, *np.zeros(4 - len(pushes))]),
    )
    dq = np.zeros(2)
    how = choose_velocity(
        np.array(q),
        np.array(v if before is None else before),
        acceleration,
        PERIOD_S,
        wishes,
        keeping,
        len(surfaces),
        room_of(2, 1, 4),
        dq,
    )
    return how, dq


def test_gives_what_is_wanted_where_nothing_is_in_the_way() -> None:
    how, dq = choose((0.3, -0.2))
    assert how == AS_WANTED
    np.testing.assert_allclose(dq, (0.3, -0.2), rtol=1e-5)


def test_brakes_before_a_limit_and_before_a_row() -> None:
    assert choose((2.0, 0.0), q=(0.95, 0.0))[1][0] == pytest.approx(LIMIT_1_S * 0.05)
    _, dq = choose((2.0, 2.0), q=(0.70, 0.75))
    assert dq.sum() == pytest.approx(LIMIT_1_S * 0.05)


def test_comes_back_inside_of_a_limit() -> None:
    assert choose((1.0, 0.0), q=(1.1, 0.0))[1][0] == pytest.approx(-0.3)


def test_slides_along_a_surface() -> None:
    how, dq = choose((0.5, 0.4), surfaces=((-1.0, 0.0, -0.1),))
    assert how == AS_WANTED
    np.testing.assert_allclose(dq, (0.1, 0.4), rtol=1e-4)


def test_speeds_change_no_faster_than_they_may_unless_a_surface_asks_for_it() -> None:
    how, dq = choose((1.0, 0.0), before=(0.0, 0.0), acceleration=10.0)
    assert (how, dq[0]) == (AS_WANTED, pytest.approx(0.1))
    how, dq = choose((1.0, 0.0), before=(1.0, 0.0), surfaces=((-1.0, 0.0, 0.5),), acceleration=10.0)
    assert (how, dq[0]) == (FASTER, pytest.approx(-0.5))


def test_misses_two_surfaces_that_close_in_by_the_same_speed() -> None:
    how, dq = choose((0.0, 0.0), surfaces=((1.0, 0.0, 0.3), (-1.0, 0.0, 0.1)))
    assert how == MISSED
    assert dq[0] == pytest.approx(0.1, abs=1e-4)


def test_leaves_a_margin_no_faster_than_another_surface_has_room() -> None:
    out_of_it, with_room = (1.0, 0.0, 0.3), (-1.0, 0.0, -0.1)
    how, dq = choose((0.0, 0.0), surfaces=(out_of_it, with_room), pushes=(0.3,))
    assert how == EASED
    assert dq[0] == pytest.approx(0.1, abs=1e-4)
