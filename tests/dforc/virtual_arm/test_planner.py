"""Ways from posture to posture, of an arm of three links in a plane."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import clearance
from dforc.collision.obstacles import World, box, sphere, world_of
from dforc.limits import JointLimits
from dforc.virtual_arm.planner import PlanState, PosturePlanner

JOINTS = np.arange(3)
MARGIN_M, SELF_M = 0.01, 0.005
START, GOAL = np.array([-0.8, 0.0, 0.0]), np.array([0.8, 0.0, 0.0])
STILL, NOWHERE = np.zeros(3), world_of(())
# In the way of the straight arm at 40 cm, not of a folded one; and one that no arm passes.
POST = world_of((sphere("post", (0.45, 0.0, 0.0), 0.05),))
GATE = world_of((sphere("gate", (0.1, 0.0, 0.0), 0.05),))


@pytest.fixture
def planner(flat_body: Body, flat_limits: JointLimits) -> PosturePlanner:
    return PosturePlanner(flat_body, JOINTS, flat_limits, seed=3, most_looks=6000)


def solve(planner: PosturePlanner, world: World, goals: Matrix, seed: int | None = None) -> Matrix:
    planner.begin(START, goals, world, STILL, MARGIN_M, SELF_M, seed)
    for _ in range(100):
        if planner.advance(100) is not PlanState.SEARCHING:
            break
    return planner.path


def clear(body: Body, q: Vector, world: World) -> float:
    """Least distance of surfaces, obstacles or own."""
    frames, segments, all_of_it = np.zeros((3, 12)), np.zeros((3, 6)), np.ones(3, dtype=np.bool_)
    return clearance(q, body.arrays, world, all_of_it, frames, segments, 0.0, 0.0, -1e300)


def along(path: Matrix) -> Matrix:
    shares = np.linspace(0.0, 1.0, 200)[:, None]
    return np.vstack([a + shares * (b - a) for a, b in pairwise(path)])


def test_goes_straight_where_nothing_is_in_the_way(planner: PosturePlanner) -> None:
    path = solve(planner, NOWHERE, GOAL[None])
    np.testing.assert_array_equal(path, [START, GOAL])


def test_goes_round_what_is_in_the_way_and_keeps_its_margin(
    planner: PosturePlanner, flat_body: Body
) -> None:
    path = solve(planner, POST, GOAL[None])
    assert len(path) > 2
    np.testing.assert_array_equal(path[[0, -1]], [START, GOAL])
    least = min(clear(flat_body, q, POST) for q in along(path))
    assert least >= SELF_M / 2  # half of the smaller margin may go between two looks


def test_every_posture_of_a_way_keeps_limits_and_rows(
    planner: PosturePlanner, flat_limits: JointLimits
) -> None:
    for seed in range(5):
        path = solve(planner, POST, GOAL[None], seed)
        assert max(flat_limits.violation(q) for q in along(path)) <= 1e-9


def test_does_not_jump_over_a_sheet_of_paper(planner: PosturePlanner, flat_body: Body) -> None:
    sheet = world_of((box("sheet", (0.5, 0.0, 0.0), (0.2, 0.00005, 0.1)),))
    path = solve(planner, sheet, GOAL[None])
    assert len(path) > 2
    assert min(clear(flat_body, q, sheet) for q in along(path)) > 0.0


def test_shut_out_it_fails_after_the_work_it_was_given(planner: PosturePlanner) -> None:
    assert len(solve(planner, GATE, GOAL[None])) == 0
    assert planner.advance(100) is PlanState.FAILED
    assert 6000 <= planner.looks <= 6100


def test_a_call_looks_at_little_more_than_it_was_asked_to(planner: PosturePlanner) -> None:
    planner.begin(START, GOAL[None], GATE, STILL, MARGIN_M, SELF_M)
    for calls in range(1, 20):
        planner.advance(100)
        assert planner.looks <= calls * 165


def test_takes_the_goal_that_can_be_had(planner: PosturePlanner) -> None:
    inside = np.array([0.0, 0.0, 0.0])  # the arm through the gate
    beyond, here = np.array([0.8, 0.0, 0.0]), np.array([-1.2, 0.5, 0.5])
    path = solve(planner, GATE, np.array([inside, beyond, here]))
    np.testing.assert_array_equal(path[-1], here)


def test_without_a_free_goal_it_fails_at_once(planner: PosturePlanner) -> None:
    planner.begin(START, np.zeros((1, 3)), GATE, STILL, MARGIN_M, SELF_M)
    assert planner.advance(1) is PlanState.FAILED


def test_leaves_a_margin_that_it_stands_in_without_coming_nearer(
    planner: PosturePlanner, flat_body: Body
) -> None:
    elbow = np.array([0.4 * np.cos(-0.8), 0.4 * np.sin(-0.8), 0.0])
    beside = elbow + 0.044 * np.array([np.sin(0.8), np.cos(0.8), 0.0])  # 4 mm from the surface
    near = world_of((sphere("near", (beside[0], beside[1], beside[2]), 0.02),))
    assert clear(flat_body, START, near) == pytest.approx(0.004)
    path = solve(planner, near, GOAL[None])
    assert len(path) > 1
    assert min(clear(flat_body, q, near) for q in along(path)) >= 0.004 / 2


def test_the_same_seed_gives_the_same_way(planner: PosturePlanner) -> None:
    first, other, again = (solve(planner, POST, GOAL[None], seed) for seed in (5, 6, 5))
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)


def test_says_where_a_path_is_blocked_by_what_came_later(planner: PosturePlanner) -> None:
    path = np.array([START, START, GOAL])
    whole = planner.free_along(path, 0.0, NOWHERE, STILL, MARGIN_M, SELF_M, 100)
    assert (whole.reached, whole.blocked) == (2.0, False)
    half = planner.free_along(path, 0.0, POST, STILL, MARGIN_M, SELF_M, 1000)
    # The hand's side passes the post at asin((5 + 2 + 1) / 45) = 10.24 degrees before the middle.
    passes = 1.0 + 0.5 * (1.0 - np.arcsin(0.08 / 0.45) / 0.8)
    assert half.blocked
    assert passes - 0.01 <= half.reached <= passes + 0.005
    assert not planner.is_path_free(path, 1.2, POST, STILL, MARGIN_M, SELF_M, 1000)
    assert planner.is_path_free(path[:2], 0.0, POST, STILL, MARGIN_M, SELF_M, 1000)


def test_a_path_is_looked_along_in_pieces(planner: PosturePlanner) -> None:
    side = world_of((sphere("side", (0.7, 0.0, 0.0), 0.05),))  # passed by 1.5 cm beyond the margin
    begin, calls = 0.0, 0
    path = np.array([START, GOAL])
    while begin < 1.0:
        stretch = planner.free_along(path, begin, side, STILL, MARGIN_M, SELF_M, 5)
        assert not stretch.blocked
        assert stretch.looks <= 7
        begin, calls = stretch.reached, calls + 1
    assert calls > 1


def test_says_how_much_of_a_straight_way_is_free(planner: PosturePlanner) -> None:
    free = planner.free_length(START, GOAL, POST, STILL, MARGIN_M, SELF_M, 1000)
    assert free == pytest.approx(0.5 * (1.0 - np.arcsin(0.08 / 0.45) / 0.8), abs=0.01)
    assert planner.free_length(START, GOAL, NOWHERE, STILL, MARGIN_M, SELF_M, 10) == 1.0


INTERPRETED = """
import sys
sys.modules["numba"] = None
sys.path[:0] = sys.argv[1:]
import conftest, test_planner
from dforc.compiled import HAS_COMPILER
from dforc.virtual_arm.planner import PosturePlanner
assert not HAS_COMPILER
planner = PosturePlanner(conftest.flat_arm(), test_planner.JOINTS, conftest.bent_limits(), 3)
path = test_planner.solve(planner, test_planner.POST, test_planner.GOAL[None], 5)
print(path.tobytes().hex())
"""


def test_without_a_compiler_it_finds_the_same_way(planner: PosturePlanner) -> None:
    here = Path(__file__).parent
    command = [sys.executable, "-W", "error", "-c", INTERPRETED, str(here), str(here.parents[2])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == solve(planner, POST, GOAL[None], 5).tobytes().hex()
