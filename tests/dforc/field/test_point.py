"""The better field for a bare point: arrives, touches nothing, and says what it is doing."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from dforc.collision.kernel_shapes import world_distance
from dforc.collision.obstacles import Obstacle, World, box, sphere, world_of
from dforc.errors import NotFiniteError, ShapeError
from dforc.field.point import PointError, PointField, PointParams, PointStatus

Array = NDArray[np.float64]

PERIOD_S = 0.01
START, GOAL = np.zeros(3), np.array([0.3, 0.0, 0.0])
EMPTY = world_of([])


@dataclass(frozen=True)
class Ride:
    """What a point did."""

    places_m: Array  # (k, 3)
    said: list[PointStatus]  # every change
    clearance_m: float  # the smallest, after each step

    @property
    def end_m(self) -> Array:
        return np.asarray(self.places_m[-1])


def ride(
    world: World | Callable[[float], World],
    duration_s: float = 5.0,
    goal: Array = GOAL,
    start: Array = START,
    params: PointParams | None = None,
) -> Ride:
    field = PointField(params)
    field.begin(start)
    places: list[Array] = []
    said: list[PointStatus] = []
    least = np.inf
    for i in range(round(duration_s / PERIOD_S)):
        now = world(PERIOD_S * i) if callable(world) else world
        after = world(PERIOD_S * (i + 1)) if callable(world) else world
        out = field.step(goal, now, PERIOD_S)
        places.append(out.position_m)
        if not said or said[-1] is not out.status:
            said.append(out.status)
        least = min(least, world_distance(out.position_m, after))
    return Ride(np.array(places), said, least)


def coming(speed_m_s: float) -> Callable[[float], World]:
    """A ball that comes straight at the origin."""

    def at(t_s: float) -> World:
        ball = sphere("ball", (1.0 - speed_m_s * t_s, 0.001, 0.0), 0.05)
        return world_of([replace(ball, velocity_m_s=(-speed_m_s, 0.0, 0.0))])

    return at


def cage(count: int) -> list[Obstacle]:
    """The first plates of six around the goal."""
    plates = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            centre, half = GOAL.copy(), np.full(3, 0.06)
            centre[axis] += 0.06 * side
            half[axis] = 0.005
            plates.append(box(f"{axis} {side}", tuple(centre), tuple(half)))
    return plates[:count]


def test_far_from_obstacles_it_is_the_papers_spring_and_damper() -> None:
    k, d = 9.0, 6.0
    params = PointParams(smoothing_s=0.001, jerk_m_s3=1e6, speed_m_s=10.0, escape_m_s=10.0)
    found = ride(EMPTY, 3.0, goal=np.array([0.1, 0.0, 0.0]), params=params)
    x, v = np.zeros(3), np.zeros(3)
    for place in found.places_m:
        v = v + PERIOD_S * (k * (np.array([0.1, 0.0, 0.0]) - x) - d * v)
        x = x + PERIOD_S * v
        np.testing.assert_allclose(place, x, atol=2e-4)


def test_does_not_lag_behind_a_target_whose_velocity_is_known() -> None:
    field = PointField()
    field.begin(START)
    velocity = np.array([0.1, 0.0, 0.0])
    for i in range(500):
        out = field.step(PERIOD_S * i * velocity, EMPTY, PERIOD_S, velocity)
    np.testing.assert_allclose(out.position_m, PERIOD_S * 499 * velocity, atol=1.5e-3)


def test_arrives_behind_a_ball_exactly_in_the_way() -> None:
    found = ride(world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)]))
    np.testing.assert_allclose(found.end_m, GOAL, atol=1e-3)
    assert found.clearance_m >= 0.01
    assert found.said[-1] is PointStatus.ARRIVED


def test_is_smooth() -> None:
    found = ride(world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)]))
    jerk = np.diff(found.places_m, 3, axis=0) / PERIOD_S**3
    assert np.linalg.norm(jerk, axis=1).max() < 30.0


def test_waits_for_a_cage_to_open_and_then_goes_in() -> None:
    found = ride(lambda t: world_of(cage(6 if t < 3.0 else 5)), 8.0)
    assert PointStatus.UNREACHABLE in found.said
    closed = found.places_m[:300]
    assert np.linalg.norm(closed - closed[0], axis=1).max() < 0.05
    np.testing.assert_allclose(found.end_m, GOAL, atol=1e-3)
    assert found.clearance_m > 0.0


def test_a_goal_inside_a_ball_is_neared_as_far_as_is_safe() -> None:
    found = ride(world_of([sphere("ball", (0.3, 0.03, 0.0), 0.05)]))
    assert found.said[-1] is PointStatus.NEAREST
    # The ball's surface is 20 mm from the goal, away from its centre; 3 mm are kept.
    np.testing.assert_allclose(found.end_m, (0.3, -0.023, 0.0), atol=1e-3)


def test_a_goal_close_to_a_ball_is_reached() -> None:
    found = ride(world_of([sphere("ball", (0.3, 0.055, 0.0), 0.05)]))
    np.testing.assert_allclose(found.end_m, GOAL, atol=1e-3)
    assert found.clearance_m >= 0.004


def test_leaves_an_obstacle_by_the_shortest_way() -> None:
    found = ride(world_of([sphere("ball", (0.02, 0.0, 0.0), 0.05)]))
    assert found.said[0] is PointStatus.LEAVING
    out = next(p for p in found.places_m if np.linalg.norm(p - (0.02, 0.0, 0.0)) > 0.05)
    assert out[0] < -0.029
    np.testing.assert_allclose(found.end_m, GOAL, atol=1e-3)


@pytest.mark.parametrize("speed_m_s", [0.2, 0.4, 0.6])
def test_gets_out_of_the_way_of_a_ball(speed_m_s: float) -> None:
    found = ride(coming(speed_m_s), 7.0, goal=START)
    assert found.clearance_m > 0.005
    assert np.linalg.norm(found.places_m, axis=1).max() < 0.25


def test_goes_around_a_plate_that_pushes_it() -> None:
    def plate(t_s: float) -> World:
        made = box("plate", (0.6 - 0.3 * t_s, 0.0, 0.0), (0.01, 0.15, 0.15))
        return world_of([replace(made, velocity_m_s=(-0.3, 0.0, 0.0))])

    found = ride(plate, 6.0, goal=START)
    assert found.clearance_m > 0.005
    np.testing.assert_allclose(found.end_m, START, atol=5e-3)


def test_goes_through_a_hole_that_is_narrower_than_its_margin() -> None:
    half, wide = 0.005, 0.3
    sides = [
        box("up", (0.15, 0.0, half + wide), (0.005, wide, wide)),
        box("down", (0.15, 0.0, -half - wide), (0.005, wide, wide)),
        box("left", (0.15, half + wide, 0.0), (0.005, wide, wide)),
        box("right", (0.15, -half - wide, 0.0), (0.005, wide, wide)),
    ]
    found = ride(world_of(sides), 8.0)
    np.testing.assert_allclose(found.end_m, GOAL, atol=1e-3)
    assert found.clearance_m > 0.003


def test_holds_its_velocity_until_a_way_is_found() -> None:
    params = PointParams(cells=1)
    found = ride(world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)]), 0.1, params=params)
    assert found.said == [PointStatus.SEARCHING]
    np.testing.assert_array_equal(found.end_m, START)


def test_takes_any_number_of_obstacles() -> None:
    balls = [sphere(f"{i}", (0.15, 0.02 * (i - 20), 0.3), 0.01) for i in range(40)]
    np.testing.assert_allclose(ride(world_of(balls)).end_m, GOAL, atol=1e-3)


def test_stays_where_it_is_when_given_what_is_no_number() -> None:
    field = PointField()
    field.begin(START)
    world = world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)])
    with pytest.raises(NotFiniteError):
        field.step((np.nan, 0.0, 0.0), world, PERIOD_S)
    with pytest.raises(ShapeError):
        field.step((0.0, 0.0), world, PERIOD_S)
    with pytest.raises(PointError):
        field.step(GOAL, world, 0.0)
    world.centres[0, 1] = np.inf
    with pytest.raises(NotFiniteError):
        field.step(GOAL, world, PERIOD_S)
    np.testing.assert_array_equal(field.step(START, EMPTY, PERIOD_S).position_m, START)


def test_refuses_constants_that_make_no_field() -> None:
    with pytest.raises(PointError, match="stiffness_n_m"):
        PointParams(stiffness_n_m=0.0)
    with pytest.raises(PointError, match="speed_m_s"):
        PointParams(speed_m_s=-0.1)
    with pytest.raises(PointError, match="tightest_m"):
        PointParams(margin_m=0.002, tightest_m=0.003)
