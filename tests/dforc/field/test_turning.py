"""How a hand turns while a field moves its point."""

import math

import numpy as np
import pytest

from dforc.field.turning import LARGE_RAD, TURN_RAD_S, Turning
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from dforc.rotation import angle_between, matrix
from services.experiments.field_figures.pmp_arm import MEASURED, PmpArm, arm_of
from services.experiments.field_figures.targets import problem_of, virtual_path

PERIOD_S = 0.01
# A posture whose hand is turned by 179 degrees from home, beyond the wrist's limit the shorter way.
OTHER_SIDE_DEG = (4.4, 1.5, 3.4, -10.5, 130.0, 48.6, 15.0, 54.4, 23.9, 15.6)

# Two postures: the hand of the first is turned by less than a large turn from home, and by 173
# degrees from that of the second.
ASIDE_DEG = (0.0, 0.0, 0.0, -8.0, 70.0, 39.0, 34.0, 24.0, -4.0, 6.0)
ACROSS_DEG = (0.0, 0.0, 0.0, -84.0, 122.0, 7.0, 75.0, -1.0, -56.0, 2.0)


@pytest.fixture(scope="module")
def arm() -> PmpArm:
    return arm_of(MEASURED)


def test_a_small_turn_goes_the_shortest_way_at_the_rate(arm: PmpArm) -> None:
    turning = Turning(problem_of(arm))
    turning.begin(arm.home_rad)
    before, place = arm.model.tip_pose(arm.home_rad)
    goal = TipTarget(place, matrix((0.0, 0.0, 1.0)) @ before)
    turned = [before]
    for k in range(1, 40):
        turned = turning.step(turned, [place], [goal], PERIOD_S)
        assert angle_between(before, turned[0]) == pytest.approx(TURN_RAD_S * PERIOD_S * k)
    for _ in range(40):
        turned = turning.step(turned, [place], [goal], PERIOD_S)
    assert goal.rotation is not None
    np.testing.assert_array_equal(turned[0], goal.rotation)


def test_a_hand_without_an_orientation_to_turn_to_stays(arm: PmpArm) -> None:
    turning = Turning(problem_of(arm))
    before, place = arm.model.tip_pose(arm.home_rad)
    for goal in (None, TipTarget(place, None)):
        assert turning.step([before], [place], [goal], PERIOD_S)[0] is before


def test_half_a_turn_goes_the_way_round_that_the_arm_can(arm: PmpArm) -> None:
    problem = problem_of(arm)
    rotation, place = arm.model.tip_pose(np.radians(OTHER_SIDE_DEG))
    before = arm.model.tip_pose(arm.home_rad)[0]
    assert angle_between(before, rotation) > math.radians(170.0)
    goal, inverse = TipTarget(place, rotation), InverseKinematics(problem)
    turning = Turning(problem)
    turning.begin(arm.home_rad)
    led, straight, turned = arm.home_rad, arm.home_rad, [before]
    for point in virtual_path(arm.home_m, place):
        turned_before = turned
        turned = turning.step(turned, [point], [goal], PERIOD_S)
        assert angle_between(turned_before[0], turned[0]) <= TURN_RAD_S * PERIOD_S + 1e-9
        led = inverse.track([TipTarget(point, turned[0])], led).q_rad
        straight = inverse.track([TipTarget(point, rotation)], straight).q_rad
    assert angle_between(arm.model.tip_pose(led)[0], rotation) < math.radians(1.0)
    assert angle_between(arm.model.tip_pose(straight)[0], rotation) > math.radians(45.0)


def test_a_large_turn_begins_where_a_small_one_has_ended(arm: PmpArm) -> None:
    home = arm.model.tip_pose(arm.home_rad)[0]
    first, second = (arm.model.tip_pose(np.radians(posture)) for posture in (ASIDE_DEG, ACROSS_DEG))
    assert math.radians(60.0) < angle_between(home, first[0]) < LARGE_RAD
    assert angle_between(first[0], second[0]) > math.radians(170.0)
    turning = Turning(problem_of(arm))
    turning.begin(arm.home_rad)
    turned, place, way_rad, from_home_rad = [home], arm.home_m, 0.0, math.inf
    for rotation, end in (first, second):
        goal, way_rad, from_home_rad = TipTarget(end, rotation), 0.0, math.inf
        for point in virtual_path(place, end)[:900]:
            before = turned[0]
            turned = turning.step(turned, [place], [goal], PERIOD_S)
            way_rad += angle_between(before, turned[0])
            from_home_rad = min(from_home_rad, angle_between(turned[0], home))
            place = point
        assert angle_between(turned[0], rotation) < 1e-6
    assert way_rad < 1.05 * angle_between(first[0], second[0])
    assert from_home_rad > math.radians(60.0)  # not back to where it began
