"""Postures with the hand at its goal and clear of everything, of three links in a plane."""

from itertools import pairwise

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import clearance, place_body, tip_pose
from dforc.collision.obstacles import World, sphere, world_of
from dforc.limits import JointLimits
from dforc.virtual_arm.goal_postures import GoalSearch
from dforc.virtual_arm.goals import TipGoal

MARGIN_M, SELF_M = 0.01, 0.005
NOW, STILL, NOWHERE = np.array([0.3, 0.3, 0.3]), np.zeros(3), world_of(())
AHEAD = TipGoal.checked((0.3, 0.2, 0.0))
# Where the arm bent to the left, the nearer way to there, has its second joint.
BALL = world_of((sphere("ball", (0.17, -0.08, 0.0), 0.04),))


@pytest.fixture
def search(flat_body: Body, flat_limits: JointLimits) -> GoalSearch:
    return GoalSearch(flat_body, np.arange(3), flat_limits, (0,), np.zeros(3), seed=1)


def turned(angle_rad: float) -> Matrix:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def find(search: GoalSearch, goal: TipGoal | None, world: World, tries: int = 40) -> Matrix:
    search.begin((goal,), world, NOW, STILL, MARGIN_M, SELF_M)
    for _ in range(tries):
        search.advance(1)
    return search.postures


def hand(body: Body, q: Vector) -> Vector:
    frames, segments = np.zeros((3, 12)), np.zeros((3, 6))
    rotation, position = np.zeros(9), np.zeros(3)
    place_body(q, body.arrays, frames, segments)
    tip_pose(body.arrays, 0, frames, rotation, position)
    return position


def spare(body: Body, q: Vector, world: World) -> float:
    """Least of all distances beyond the margins."""
    frames, segments, all_of_it = np.zeros((3, 12)), np.zeros((3, 6)), np.ones(3, dtype=np.bool_)
    return clearance(q, body.arrays, world, all_of_it, frames, segments, MARGIN_M, SELF_M, -1e300)


def test_the_hand_is_at_the_goal_to_a_millimetre_inside_limits_and_rows(
    search: GoalSearch, flat_body: Body, flat_limits: JointLimits
) -> None:
    postures = find(search, AHEAD, BALL)
    assert len(postures) >= 2
    for q in postures:
        assert np.linalg.norm(hand(flat_body, q) - AHEAD.position_m) <= 0.001
        assert flat_limits.violation(q) <= 1e-9


def test_every_posture_keeps_the_margins(search: GoalSearch, flat_body: Body) -> None:
    postures = find(search, AHEAD, BALL)
    assert min(spare(flat_body, q, BALL) for q in postures) >= 0.0


def test_where_the_hand_is_already_the_present_posture_is_found_first(
    search: GoalSearch, flat_body: Body
) -> None:
    search.begin((TipGoal(hand(flat_body, NOW)),), NOWHERE, NOW, STILL, MARGIN_M, SELF_M)
    assert search.advance(1) == 1
    np.testing.assert_allclose(search.postures[0], NOW, atol=1e-9)


def test_the_best_posture_comes_first(search: GoalSearch) -> None:
    postures = find(search, AHEAD, NOWHERE)
    lever = np.array([0.6, 0.4, 0.2])  # a straight arm's, from each joint to the fingertip
    costs = [np.linalg.norm(lever * (q - NOW)) + 0.3 * np.linalg.norm(lever * q) for q in postures]
    assert all(a <= b for a, b in pairwise(costs))


def test_an_orientation_that_can_be_had_is_kept_to_a_degree(search: GoalSearch) -> None:
    # The wrist at (0.3, 0.2) - 0.2 (cos 60, sin 60), 20 cm away: the row allows one of two elbows.
    postures = find(search, TipGoal.checked((0.3, 0.2, 0.0), turned(np.pi / 3)), NOWHERE)
    assert len(postures) > 0
    for q in postures:
        assert q.sum() == pytest.approx(np.pi / 3, abs=np.radians(1.0))
    assert search.orientation_error_rad <= np.radians(1.0)


def test_of_an_orientation_that_cannot_be_had_as_little_is_missed_as_can_be(
    search: GoalSearch, flat_body: Body
) -> None:
    # 55 cm away the wrist can be at most 40 cm away: cos b = (55^2 + 20^2 - 40^2) / (2 55 20).
    least = np.arccos((0.55**2 + 0.2**2 - 0.4**2) / (2 * 0.55 * 0.2))
    postures = find(search, TipGoal.checked((0.55, 0.0, 0.0), turned(np.pi / 2)), NOWHERE)
    assert len(postures) > 0
    assert np.linalg.norm(hand(flat_body, postures[0]) - [0.55, 0.0, 0.0]) <= 0.001
    assert search.orientation_error_rad == pytest.approx(np.pi / 2 - least, abs=np.radians(2.0))


def test_a_goal_inside_an_obstacle_has_no_posture(search: GoalSearch) -> None:
    over = world_of((sphere("over", (0.3, 0.2, 0.0), 0.05),))
    assert len(find(search, AHEAD, over)) == 0
    assert 20 <= search.tried <= 80


def test_a_goal_out_of_reach_has_no_posture(search: GoalSearch) -> None:
    assert len(find(search, TipGoal.checked((0.61, 0.0, 0.0)), NOWHERE)) == 0


def test_a_hand_without_a_goal_may_be_anywhere(search: GoalSearch) -> None:
    np.testing.assert_allclose(find(search, None, NOWHERE, 1)[0], NOW, atol=1e-12)


def test_the_same_seed_gives_the_same_postures(search: GoalSearch) -> None:
    first = find(search, AHEAD, BALL, 20)
    np.testing.assert_array_equal(find(search, AHEAD, BALL, 20), first)


def test_slices_of_any_size_find_the_same_postures(search: GoalSearch) -> None:
    slices = find(search, AHEAD, BALL, 20)
    search.begin((AHEAD,), BALL, NOW, STILL, MARGIN_M, SELF_M)
    search.advance(20)
    np.testing.assert_array_equal(search.postures[:2], slices[:2])
