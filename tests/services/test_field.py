"""The field service: where its point starts, how it moves, what it refuses."""

import msgspec
import numpy as np
import pytest

from services.core.testing import Bench
from services.field import Field
from services.messages import NAN3, CartesianStatus, Goal, Objects, Obstacle
from services.reaching.limb import limb_model
from services.robotfile.robot_tables import RobotFile
from services.streams import CARTESIAN_STATUS, GOAL, OBJECTS, VIRTUAL_POINT

NOWHERE = (0.0, 0.0, 0.0)


@pytest.fixture
def hand_m(robot: RobotFile) -> tuple[float, float, float]:
    x, y, z = limb_model(robot).tip_pose(np.radians(robot.reach.home_deg))[1].tolist()
    return x, y, z


@pytest.fixture
def bench(at_home: CartesianStatus) -> Bench:
    bench = Bench(Field())
    bench.put(CARTESIAN_STATUS, at_home)
    return bench


def goal_at(x: float, y: float, z: float, *, active: bool = True) -> Goal:
    return Goal(stamp_ns=0, position_m=(x, y, z), rotation_rad=(0.1, 0.2, 0.3), active=active)


def test_is_silent_without_a_goal(bench: Bench) -> None:
    bench.advance(0.1)
    assert bench.sent(VIRTUAL_POINT) == []


def test_point_starts_at_the_hand(bench: Bench, hand_m: tuple[float, float, float]) -> None:
    bench.put(GOAL, goal_at(*hand_m))
    bench.advance(0.0)
    assert bench.last(VIRTUAL_POINT).position_m == pytest.approx(hand_m, abs=1e-9)


def test_point_arrives_and_carries_the_goal_s_orientation(
    bench: Bench, hand_m: tuple[float, float, float]
) -> None:
    x, y, z = hand_m
    bench.put(GOAL, goal_at(x - 0.1, y, z))
    bench.advance(5.0)
    point = bench.last(VIRTUAL_POINT)
    assert point.position_m == pytest.approx((x - 0.1, y, z), abs=1e-4)
    assert point.rotation_rad == (0.1, 0.2, 0.3)


def test_point_goes_around_a_ball(bench: Bench, hand_m: tuple[float, float, float]) -> None:
    x, y, z = hand_m
    centre = np.array((x - 0.1, y + 0.01, z))
    bench.put(OBJECTS, Objects(stamp_ns=0, obstacles=(Obstacle(tuple(centre.tolist()), 0.05),)))
    bench.put(GOAL, goal_at(x - 0.2, y, z))
    bench.advance(8.0)
    path = np.array([point.position_m for point in bench.sent(VIRTUAL_POINT)])
    assert np.linalg.norm(path - centre, axis=1).min() > 0.055
    assert path[-1] == pytest.approx((x - 0.2, y, z), abs=1e-3)


def test_goal_that_is_not_finite_is_refused_and_the_old_one_holds(
    bench: Bench, hand_m: tuple[float, float, float]
) -> None:
    x, y, z = hand_m
    bench.put(GOAL, goal_at(x - 0.05, y, z))
    bench.advance(0.5)
    bench.put(GOAL, goal_at(float("nan"), y, z))
    bench.advance(4.0)
    assert isinstance(bench.service, Field)
    assert bench.service.refused == 1
    assert bench.last(VIRTUAL_POINT).position_m == pytest.approx((x - 0.05, y, z), abs=1e-3)


def test_ball_without_volume_is_refused(bench: Bench) -> None:
    bench.put(OBJECTS, Objects(stamp_ns=0, obstacles=(Obstacle(NOWHERE, -1.0),)))
    bench.advance(0.0)
    assert isinstance(bench.service, Field)
    assert bench.service.refused == 1


def test_falls_silent_when_the_goal_is_withdrawn(
    bench: Bench, hand_m: tuple[float, float, float]
) -> None:
    bench.put(GOAL, goal_at(*hand_m))
    bench.advance(0.1)
    count = len(bench.sent(VIRTUAL_POINT))
    bench.put(GOAL, goal_at(*NOWHERE, active=False))
    bench.advance(0.2)
    assert len(bench.sent(VIRTUAL_POINT)) == count


@pytest.mark.parametrize("far_m", [1e308, -1e308])
def test_goal_beyond_all_numbers_does_not_end_the_field(
    bench: Bench,
    at_home: CartesianStatus,
    hand_m: tuple[float, float, float],
    far_m: float,
) -> None:
    bench.put(GOAL, goal_at(far_m, far_m, 0.0))
    bench.advance(0.1)
    assert isinstance(bench.service, Field)
    assert bench.service.refused > 0
    bench.put(CARTESIAN_STATUS, at_home)
    bench.put(GOAL, goal_at(*hand_m))
    bench.advance(0.02)
    assert bench.last(VIRTUAL_POINT).position_m == pytest.approx(hand_m, abs=1e-9)


def test_hand_that_is_not_finite_does_not_end_the_field(
    bench: Bench, at_home: CartesianStatus, hand_m: tuple[float, float, float]
) -> None:
    nowhere = msgspec.structs.replace(at_home, hand_position_m=NAN3)
    bench.put(CARTESIAN_STATUS, nowhere)
    bench.put(GOAL, goal_at(*hand_m))
    bench.advance(0.02)
    assert bench.sent(VIRTUAL_POINT) == []
    bench.put(CARTESIAN_STATUS, at_home)
    bench.advance(0.02)
    assert bench.last(VIRTUAL_POINT).position_m == pytest.approx(hand_m, abs=1e-9)
