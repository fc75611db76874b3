"""The ball that a hand cannot leave, and goals outside of it."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Matrix, Vector
from dforc.ik.problem import Tip
from dforc.robot_model import ChainElement
from services.config import load_robot
from services.fields.goals import out_of_reach
from services.fields.limbs import FieldLimb
from services.fields.mode import HandGoal
from services.fields.reach import Reach
from services.reaching.limb_shape import limb_shape
from services.reaching.messages import LimbSetup, TipOffset

UP = np.array((0.0, 0.0, 1.0))
LIMBS = ("right_arm", "left_arm", "both_arms")


class TwoLinks:
    """An arm about z whose shoulder is at (1, 2, 3), with links of 0.3 m and 0.2 m along x."""

    n = 2

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,)."""
        first, second = (rotation.matrix((0.0, 0.0, angle)) for angle in q_rad)
        return first @ second, np.array((1.0, 2.0, 3.0)) + first @ (
            np.array((0.3, 0.0, 0.0)) + second @ np.array((0.2, 0.0, 0.0))
        )

    def tip_jacobian(self, q_rad: Vector) -> Matrix:
        """Nobody asks for it here."""
        raise NotImplementedError

    def chain_description(self) -> Sequence[ChainElement]:
        """From the base to the tip."""
        return (
            ChainElement(-1, np.eye(3), np.array((1.0, 2.0, 3.0)), UP, 0),
            ChainElement(0, np.eye(3), np.array((0.3, 0.0, 0.0)), UP, 1),
            ChainElement(1, np.eye(3), np.array((0.2, 0.0, 0.0)), np.zeros(3), -1),
        )


def arm(name: str) -> FieldLimb:
    return FieldLimb.of(limb_shape(load_robot("icub:arms"), name))


def at(place: Vector) -> HandGoal:
    return HandGoal(position_m=place)


def test_a_hand_reaches_as_far_as_its_links_in_one_line() -> None:
    reach = Reach.of(Tip("hand", TwoLinks()))
    assert reach.centre_m.tolist() == [1.0, 2.0, 3.0]
    assert reach.radius_m == pytest.approx(0.5)
    assert reach.beyond_m((1.0, 2.6, 3.0)) == pytest.approx(0.1)
    assert reach.beyond_m((1.4, 2.0, 3.0)) == pytest.approx(-0.1)


def test_what_is_held_in_the_hand_counts() -> None:
    tip = Tip("hand", TwoLinks())
    longer = tip.attached(np.eye(3), (0.05, 0.0, 0.0))
    shorter = tip.attached(np.eye(3), (-0.05, 0.0, 0.0))
    assert Reach.of(longer).radius_m == pytest.approx(0.55)
    assert Reach.of(shorter).radius_m == pytest.approx(0.45)


@pytest.mark.parametrize("name", LIMBS)
def test_no_posture_leaves_the_ball(name: str) -> None:
    limb = arm(name)
    draws = np.random.default_rng(7)
    for _ in range(500):
        q_rad = draws.uniform(-math.pi, math.pi, limb.shape.n)
        for (_, place_m), reach in zip(limb.poses(q_rad), limb.reaches, strict=True):
            assert reach.beyond_m(place_m) <= 1e-9


def test_the_ball_is_no_larger_than_the_links_are_long() -> None:
    (reach,) = arm("right_arm").reaches
    links = arm("right_arm").problem.tips[0].model.chain_description()
    assert reach.radius_m == pytest.approx(sum(math.hypot(*link.p) for link in links[1:]))
    assert 0.5 < reach.radius_m < 0.9


def test_a_goal_outside_is_out_of_reach_by_what_it_is_beyond() -> None:
    limb = arm("right_arm")
    (reach,) = limb.reaches
    ahead = np.array((-1.0, 0.0, 0.0))
    beyond = at(reach.centre_m + (reach.radius_m + 0.123) * ahead)
    assert out_of_reach(limb, (beyond,)) == (
        "at least 123 mm beyond the reach of right_arm, which goes as near as it can"
    )
    assert out_of_reach(limb, (at(reach.centre_m + (reach.radius_m + 0.004) * ahead),)) == ""
    assert out_of_reach(limb, (at(reach.centre_m),)) == ""


def test_of_two_hands_the_one_that_is_farther_off_is_named_and_a_free_one_never() -> None:
    limb = arm("both_arms")
    left, right = (
        at(reach.centre_m + np.array((0.0, 0.0, reach.radius_m + beyond_m)))
        for reach, beyond_m in zip(limb.reaches, (0.02, 0.3), strict=True)
    )
    assert "300 mm beyond the reach of right_arm" in out_of_reach(limb, (left, right))
    assert "20 mm beyond the reach of left_arm" in out_of_reach(limb, (left, None))
    assert out_of_reach(limb, (None, None)) == ""


def test_a_limb_that_is_set_up_with_a_tool_reaches_farther() -> None:
    limb = arm("right_arm")
    (before,) = limb.reaches
    tool = TipOffset(position_m=(0.0, 0.0, 0.1))
    limb.set_up(LimbSetup(limb="right_arm", tip_offsets=(tool,)))
    (after,) = limb.reaches
    assert before.radius_m < after.radius_m <= before.radius_m + 0.1
