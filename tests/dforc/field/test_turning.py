"""How a hand turns while a field moves its point."""

import math

import numpy as np
import pytest

from dforc.field.turning import TURN_RAD_S, Turning
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import TipTarget
from dforc.rotation import angle_between, matrix
from services.experiments.field_figures.pmp_arm import MEASURED, PmpArm, arm_of
from services.experiments.field_figures.targets import problem_of, virtual_path

PERIOD_S = 0.01
# A posture whose hand is turned by 179 degrees from home, beyond the wrist's limit the shorter way.
OTHER_SIDE_DEG = (4.4, 1.5, 3.4, -10.5, 130.0, 48.6, 15.0, 54.4, 23.9, 15.6)


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
        turned = turning.step(turned, [goal], PERIOD_S)
        assert angle_between(before, turned[0]) == pytest.approx(TURN_RAD_S * PERIOD_S * k)
    for _ in range(40):
        turned = turning.step(turned, [goal], PERIOD_S)
    assert goal.rotation is not None
    np.testing.assert_array_equal(turned[0], goal.rotation)


def test_a_hand_without_an_orientation_to_turn_to_stays(arm: PmpArm) -> None:
    turning = Turning(problem_of(arm))
    before, place = arm.model.tip_pose(arm.home_rad)
    for goal in (None, TipTarget(place, None)):
        assert turning.step([before], [goal], PERIOD_S)[0] is before


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
        turned = turning.step(turned, [goal], PERIOD_S)
        assert angle_between(turned_before[0], turned[0]) <= TURN_RAD_S * PERIOD_S + 1e-9
        led = inverse.track([TipTarget(point, turned[0])], led).q_rad
        straight = inverse.track([TipTarget(point, rotation)], straight).q_rad
    assert angle_between(arm.model.tip_pose(led)[0], rotation) < math.radians(1.0)
    assert angle_between(arm.model.tip_pose(straight)[0], rotation) > math.radians(45.0)
