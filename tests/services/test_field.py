"""The field service: where its point starts, how it moves, what it refuses."""

import math

import msgspec
import numpy as np
import pytest

from services.core.clock import NS_PER_MS
from services.messages import Goal, Objects, Obstacle
from services.robotfile.robot_tables import RobotFile
from services.streams import FIELD_STATUS, GOAL, OBJECTS, VIRTUAL_POINT
from tests.services.field_stand import STILL, FieldStand


@pytest.fixture
def stand(robot: RobotFile) -> FieldStand:
    stand = FieldStand(robot)
    stand.run(0.05)
    return stand


def test_is_silent_without_a_goal_and_says_idle(stand: FieldStand) -> None:
    stand.run(0.1)
    assert stand.bench.sent(VIRTUAL_POINT) == []
    assert stand.told().state == "idle"


def test_point_starts_at_the_hand(stand: FieldStand) -> None:
    stand.send(stand.goal(0.0, 0.0, 0.0))
    stand.run(0.01)
    assert stand.bench.last(VIRTUAL_POINT).position_m == pytest.approx(stand.home_m, abs=1e-9)


def test_point_arrives_turned_as_the_goal_is(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0, position_only=False, rotation_rad=(0.1, 0.2, 0.3)))
    stand.run(5.0)
    point = stand.bench.last(VIRTUAL_POINT)
    assert point.position_m == pytest.approx(stand.beside(-0.1, 0.0, 0.0), abs=1e-4)
    assert point.rotation_rad == pytest.approx((0.1, 0.2, 0.3))
    assert not point.position_only
    status = stand.told()
    assert status.state == "arrived"
    assert status.goal_angle_rad == pytest.approx(0.0, abs=1e-6)


def test_point_obeys_equation_3_from_the_first_period_on(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(0.02)
    (first, second) = stand.bench.sent(VIRTUAL_POINT)
    # K = 9, D = 6, unit mass, semi-implicit: v1 = 0.01 * 9 * 0.1, x1 = 0.01 v1
    assert first.velocity_m_s[0] == pytest.approx(-0.009)
    assert first.position_m[0] == pytest.approx(stand.home_m[0] - 0.00009)
    pull = 9.0 * (0.1 - 0.00009) - 6.0 * 0.009
    assert second.velocity_m_s[0] == pytest.approx(-0.009 - 0.01 * pull)


def test_point_goes_around_a_ball_of_the_short_form(stand: FieldStand) -> None:
    centre = stand.beside(-0.1, 0.01, 0.0)
    stand.bench.put(OBJECTS, Objects(stamp_ns=0, obstacles=(Obstacle(centre, 0.05),)))
    stand.send(stand.goal(-0.2, 0.0, 0.0))
    stand.run(8.0)
    path = np.array([point.position_m for point in stand.bench.sent(VIRTUAL_POINT)])
    assert np.linalg.norm(path - centre, axis=1).min() > 0.055
    assert path[-1] == pytest.approx(stand.beside(-0.2, 0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"position_m": (math.nan, 0.0, 0.0)}, "position_m is not finite"),
        ({"position_m": (1e308, 1e308, 0.0)}, "position_m of 1e+308 is beyond 100"),
        ({"rotation_rad": (0.0, math.inf, 0.0)}, "rotation_rad is not finite"),
        ({"velocity_m_s": (0.0, 0.0, -21.0)}, "velocity_m_s of -21 is beyond 20"),
        ({"limb": "tail"}, "unknown limb 'tail'; there are: right_arm"),
        ({"second_position_m": STILL}, "a second pose is for a limb with two hands"),
    ],
)
def test_goal_that_is_none_is_refused_and_the_old_one_holds(
    stand: FieldStand, change: dict[str, object], why: str
) -> None:
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    stand.run(0.2)
    stand.send(stand.goal(-0.05, 0.0, 0.0, **change))
    stand.run(4.0)
    status = stand.told()
    assert (status.refused, status.goal) == (1, 1)
    assert why in status.refusal
    place = stand.bench.last(VIRTUAL_POINT).position_m
    assert place == pytest.approx(stand.beside(-0.05, 0.0, 0.0), abs=1e-3)


def test_a_goal_that_is_sent_again_and_again_is_one_goal(stand: FieldStand) -> None:
    for _ in range(20):
        stand.send(stand.goal(-0.05, 0.0, 0.0))
        stand.run(0.02)
    assert stand.told().goal == 1


def test_falls_silent_when_the_goal_is_withdrawn(stand: FieldStand) -> None:
    stand.send(stand.goal(0.0, 0.0, 0.0))
    stand.run(0.1)
    count = len(stand.bench.sent(VIRTUAL_POINT))
    stand.bench.put(GOAL, Goal(stamp_ns=0, position_m=STILL, rotation_rad=STILL, active=False))
    stand.run(0.2)
    assert len(stand.bench.sent(VIRTUAL_POINT)) == count
    assert stand.told().state == "idle"


def test_waits_with_the_remedy_while_joints_are_not_calibrated(stand: FieldStand) -> None:
    good = stand.states["torso"]
    stand.states["torso"] = msgspec.structs.replace(good, valid=False)
    stand.run(0.6)
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    status = stand.told()
    assert stand.bench.sent(VIRTUAL_POINT) == []
    assert status.state == "waiting"
    assert "`ulna joints calibrate`" in status.reason
    assert "torso" in status.assumed
    stand.states["torso"] = good
    stand.run(0.05)
    assert stand.bench.last(VIRTUAL_POINT).position_m == pytest.approx(stand.home_m, abs=1e-3)


def test_states_the_lag_of_a_hand_that_does_not_follow(stand: FieldStand) -> None:
    stand.send(stand.goal(-0.1, 0.0, 0.0))
    stand.run(1.0)
    status = stand.told()
    point = np.array(stand.bench.last(VIRTUAL_POINT).position_m)
    assert status.lag_m == pytest.approx(np.linalg.norm(point - stand.home_m), abs=2e-3)
    assert "behind the point" in status.reason


def test_in_virtual_time_no_period_is_late(stand: FieldStand) -> None:
    stand.run(1.0)
    assert (stand.told().late_ms, stand.told().late_count) == (0.0, 0)


def test_how_late_periods_begin_is_told_for_a_second(stand: FieldStand) -> None:
    stand.bench.late_ns = 73 * NS_PER_MS
    stand.run(0.05)
    stand.bench.late_ns = 0
    status = stand.told()
    assert (status.late_ms, status.late_count) == (73.0, 1)
    stand.run(1.0)
    status = stand.told()
    assert (status.late_ms, status.late_count) == (0.0, 1)


def test_a_status_comes_twenty_times_a_second(stand: FieldStand) -> None:
    before = len(stand.bench.sent(FIELD_STATUS))
    stand.run(1.0)
    assert len(stand.bench.sent(FIELD_STATUS)) - before == 20
