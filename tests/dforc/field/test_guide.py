"""The way to go around obstacles, against ways known from geometry."""

import itertools
import math

import numpy as np
import pytest

from dforc.collision.kernel_shapes import is_segment_free
from dforc.collision.obstacles import Obstacle, World, box, sphere, world_of
from dforc.errors import NotFiniteError
from dforc.field.guide import SIGHT_SHARE, Guide, GuideError, GuideState

LOW, HIGH = (-0.1, -0.2, -0.2), (0.4, 0.2, 0.2)
START, GOAL = np.zeros(3), np.array([0.3, 0.0, 0.0])
CLEARANCE_M = 0.015


def guide_for(world: World, cells: int = 100_000, cell_m: float = 0.02) -> Guide:
    guide = Guide(LOW, HIGH, cell_m)
    guide.set(GOAL, START, world, CLEARANCE_M)
    guide.advance(cells)
    return guide


def cage(half_m: float = 0.06, thick_m: float = 0.001) -> list[Obstacle]:
    """Six plates around the goal."""
    plates = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            centre, half = GOAL.copy(), np.full(3, half_m)
            centre[axis] += side * half_m
            half[axis] = thick_m
            plates.append(box(f"{axis} {side}", tuple(centre), tuple(half)))
    return plates


def test_the_way_is_straight_where_nothing_is_in_between() -> None:
    direction, length = guide_for(world_of([])).direction(START)
    np.testing.assert_allclose(direction, (1.0, 0.0, 0.0), atol=1e-9)
    assert length == pytest.approx(0.3)


def test_the_way_around_a_ball_is_a_little_longer_than_the_tangents() -> None:
    world = world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)])
    direction, length = guide_for(world).direction(START)
    radius = 0.05 + SIGHT_SHARE * CLEARANCE_M
    tangent = math.sqrt(0.15**2 - radius**2)
    shortest = 2.0 * (tangent + radius * math.asin(radius / 0.15))
    assert shortest <= length <= 1.03 * shortest
    assert math.acos(direction[0]) >= math.asin(radius / 0.15) - 1e-9


def test_every_line_of_the_way_keeps_off_the_obstacles() -> None:
    balls = [sphere(f"{y}", (0.15, y, 0.01), 0.04) for y in (-0.06, 0.0, 0.06)]
    world = world_of(balls)
    path, used = guide_for(world).path(START)
    places = [START, *path[:used, :3]]
    kept = SIGHT_SHARE * CLEARANCE_M - 1e-9
    assert used > 1
    assert all(is_segment_free(a, b, world, kept) for a, b in itertools.pairwise(places))


def test_a_plate_of_2_mm_is_not_jumped_over() -> None:
    world = world_of([box("plate", (0.15, 0.0, 0.0), (0.001, 0.1, 0.1))])
    _, length = guide_for(world).direction(START)
    assert length >= 2.0 * math.hypot(0.15, 0.1)


def test_an_enclosed_goal_is_infinitely_far() -> None:
    guide = guide_for(world_of(cage()))
    assert guide.state is GuideState.UNREACHABLE
    direction, length = guide.direction(START)
    assert length == math.inf
    np.testing.assert_array_equal(direction, np.zeros(3))


def test_a_cage_that_has_opened_is_entered() -> None:
    guide = guide_for(world_of(cage()))
    guide.set(GOAL, START, world_of(cage()[:-1]), CLEARANCE_M)
    assert guide.advance(100_000) is GuideState.FOUND
    assert guide.direction(START)[1] < 0.6


def test_goes_on_where_it_stopped() -> None:
    world = world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)])
    whole, parts = guide_for(world), guide_for(world, cells=0)
    calls = 0
    while parts.state is GuideState.SEARCHING:
        before = parts.cells
        parts.advance(7)
        assert parts.cells - before <= 7
        calls += 1
    assert calls > 3
    assert parts.direction(START)[1] == whole.direction(START)[1]


def test_a_goal_inside_an_obstacle_is_not_reached() -> None:
    guide = guide_for(world_of([sphere("ball", (0.3, 0.01, 0.0), 0.05)]))
    assert guide.state is GuideState.UNREACHABLE


def test_answers_for_the_obstacles_as_they_were_when_it_was_set() -> None:
    world = world_of([sphere("ball", (0.15, 0.0, 0.0), 0.05)])
    guide = guide_for(world)
    before = guide.direction(START)[1]
    world.centres[0] = 1.0, 1.0, 1.0
    assert guide.direction(START)[1] == before


def test_a_grid_too_fine_for_its_room_is_made_coarser() -> None:
    assert Guide(LOW, HIGH, 0.001, most_nodes=10_000).cell_m > 0.015


def test_knows_no_way_before_it_is_set() -> None:
    guide = Guide(LOW, HIGH, 0.02)
    assert guide.state is GuideState.IDLE
    assert guide.direction(START)[1] == math.inf


def test_refuses_what_makes_no_grid() -> None:
    with pytest.raises(GuideError):
        Guide(HIGH, LOW, 0.02)
    with pytest.raises(GuideError):
        Guide(LOW, HIGH, 0.0)
    with pytest.raises(NotFiniteError):
        Guide(LOW, HIGH, 0.02).set((np.nan, 0.0, 0.0), START, world_of([]), CLEARANCE_M)
