"""Objects and goals as the Python client makes them."""

import math

import numpy as np
import pytest

from services.core.errors import ServiceError
from services.fields.client_goals import make_goal
from services.fields.client_objects import ObjectShelf, triple
from services.messages import WorldObject

BALL = WorldObject(name="ball", shape="sphere", size_m=(0.05,), position_m=(0.1, 0.2, 0.3))
CUBE = WorldObject(name="cube", shape="box", size_m=(0.1, 0.1, 0.1), position_m=(0.0, 0.0, 0.0))


@pytest.fixture
def published() -> list[tuple[WorldObject, ...]]:
    return []


@pytest.fixture
def shelf(published: list[tuple[WorldObject, ...]]) -> ObjectShelf:
    return ObjectShelf(published.append)


def test_every_change_publishes_the_whole_set(
    shelf: ObjectShelf, published: list[tuple[WorldObject, ...]]
) -> None:
    ball, cube = shelf.add(BALL), shelf.add(CUBE)
    ball.move((0.4, 0.0, 0.0), rotation=(0.0, 0.0, 1.0), velocity_m_s=(0.1, 0.0, 0.0))
    cube.switch(on=False)
    ball.remove()
    assert [[item.name for item in items] for items in published] == [
        ["ball"], ["ball", "cube"], ["ball", "cube"], ["ball", "cube"], ["cube"],
    ]  # fmt: skip
    moved = published[2][0]
    assert (moved.position_m, moved.velocity_m_s) == ((0.4, 0.0, 0.0), (0.1, 0.0, 0.0))
    assert moved.rotation_rad == pytest.approx((0.0, 0.0, 1.0))
    assert not published[-1][0].on


def test_an_object_that_is_moved_without_a_velocity_has_it_estimated_until_it_rests(
    shelf: ObjectShelf,
) -> None:
    ball = shelf.add(BALL)
    ball.move((0.4, 0.0, 0.0), covariance_m2=(1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4))
    moving = ball.item
    assert moving.velocity_m_s is None
    assert moving.covariance_m2 is not None
    ball.rest()
    resting = ball.item
    assert (resting.position_m, resting.velocity_m_s) == ((0.4, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_what_is_no_place_changes_nothing(
    shelf: ObjectShelf, published: list[tuple[WorldObject, ...]]
) -> None:
    ball = shelf.add(BALL)
    with pytest.raises(ServiceError, match="position_m is not finite"):
        ball.move((math.nan, 0.0, 0.0))
    with pytest.raises(ServiceError, match="3 numbers, not 2"):
        ball.move((0.0, 0.0))
    assert ball.item.position_m == BALL.position_m
    assert len(published) == 1


def test_a_name_is_given_once_and_again_after_its_object_is_gone(shelf: ObjectShelf) -> None:
    ball = shelf.add(BALL)
    with pytest.raises(ServiceError, match="there is an object 'ball' already; move it by"):
        shelf.add(BALL)
    ball.remove()
    with pytest.raises(ServiceError, match="object 'ball' has been removed"):
        ball.move((0.0, 0.0, 0.0))
    assert shelf.add(BALL).item.position_m == BALL.position_m


def test_an_object_is_stamped_when_it_is_put_moved_or_brought_to_rest_and_else_not() -> None:
    stamps = iter((100, 200, 300, 400))
    shelf = ObjectShelf(lambda _: None, lambda: next(stamps))
    ball, cube = shelf.add(BALL), shelf.add(CUBE)
    ball.move((0.4, 0.0, 0.0))
    cube.switch(on=False)
    assert (ball.item.seen_ns, cube.item.seen_ns) == (300, 200)
    ball.rest()
    assert ball.item.seen_ns == 400


def test_a_goal_without_a_rotation_leaves_the_hand_to_turn_as_it_likes() -> None:
    assert make_goal((0.1, 0.2, 0.3)).position_only
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    goal = make_goal((0.1, 0.2, 0.3), turned, second_position_m=(0.0, 0.0, 0.0))
    assert not goal.position_only
    assert goal.rotation_rad == pytest.approx((0.0, 0.0, math.pi / 2))
    assert goal.second_rotation_rad is None


def test_three_numbers_are_three() -> None:
    assert triple(np.array([1, 2, 3])) == (1.0, 2.0, 3.0)
