"""The virtual arm on a planar arm of three links: it reaches, gives way, waits, and goes on."""

import math

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.collision.kernel_body import clearance
from dforc.collision.obstacles import World, box, sphere, world_of
from dforc.errors import NotFiniteError, ShapeError
from dforc.limits import JointLimits
from dforc.rotation import matrix
from dforc.virtual_arm.arm import VirtualArm
from dforc.virtual_arm.goals import ArmOutput, ArmState, TipGoal
from dforc.virtual_arm.params import ArmParams, ArmParamsError

PERIOD_S = 0.01
STILL, NOTHING = np.zeros(3), world_of(())
START = np.array([-0.8, 0.7, 0.5])
GOAL = TipGoal.checked((0.35, 0.30, 0.0))


@pytest.fixture
def arm(flat_body: Body, flat_limits: JointLimits) -> VirtualArm:
    made = VirtualArm(flat_body, flat_body.joints, flat_limits, [2.0] * 3, (0,), [0.3] * 3, seed=1)
    made.begin(START)
    return made


def step(
    arm: VirtualArm, goal: TipGoal | None, world: World = NOTHING, lag_m: float = 0.0
) -> ArmOutput:
    return arm.step(None if goal is None else [goal], world, STILL, STILL, PERIOD_S, lag_m)


def run(
    arm: VirtualArm, goal: TipGoal | None, world: World, seconds: float, until: str = ""
) -> list[ArmOutput]:
    outputs = []
    for _ in range(round(seconds / PERIOD_S)):
        outputs.append(step(arm, goal, world))
        if outputs[-1].state == until:
            break
    return outputs


def clear(body: Body, q: Vector, world: World) -> float:
    """Least distance of surfaces, obstacles' or own."""
    frames, segments, all_of_it = np.zeros((3, 12)), np.zeros((3, 6)), np.ones(3, dtype=np.bool_)
    return clearance(q, body.arrays, world, all_of_it, frames, segments, 0.0, 0.0, -1e300)


def test_the_hand_begins_as_equation_3_says(arm: VirtualArm) -> None:
    hand = step(arm, None).tips[0].position_m
    goal = TipGoal.checked(hand + np.array([0.02, -0.01, 0.0]))
    velocity = step(arm, goal).tips[0].velocity_m_s
    K = arm.params.stiffness_n_m
    np.testing.assert_allclose(velocity, PERIOD_S * K * (goal.position_m - hand), atol=2e-5)


def test_reaches_on_a_straight_way_and_no_faster_than_it_may(arm: VirtualArm) -> None:
    begin = step(arm, None).tips[0].position_m
    outputs = run(arm, GOAL, NOTHING, 6.0, "arrived")
    assert outputs[-1].state is ArmState.ARRIVED
    assert outputs[-1].position_error_m <= arm.params.position_tolerance_m
    along = (GOAL.position_m - begin) / np.linalg.norm(GOAL.position_m - begin)
    hands = np.array([output.tips[0].position_m for output in outputs]) - begin
    aside = np.linalg.norm(hands - (hands @ along)[:, None] * along, axis=1)
    assert aside.max() < 0.004
    speeds = [float(np.linalg.norm(output.tips[0].velocity_m_s)) for output in outputs]
    assert max(speeds) <= 1.02 * arm.params.speed_m_s
    assert max(speeds) >= 0.8 * arm.params.speed_m_s


def test_turns_its_hand_about_the_shorter_way(arm: VirtualArm) -> None:
    hand = step(arm, None).tips[0]
    turned = hand.rotation @ matrix((0.0, 0.0, -0.6))
    goal = TipGoal.checked(hand.position_m, turned)
    outputs = run(arm, goal, NOTHING, 6.0, "arrived")
    assert outputs[-1].state is ArmState.ARRIVED
    assert outputs[-1].orientation_error_rad <= arm.params.orientation_tolerance_rad
    assert max(output.position_error_m for output in outputs) < 0.02


def test_goes_round_a_post_and_touches_nothing(arm: VirtualArm, flat_body: Body) -> None:
    post = world_of((sphere("post", (0.46, 0.10, 0.0), 0.05),))
    outputs = run(arm, GOAL, post, 20.0, "arrived")
    assert outputs[-1].state is ArmState.ARRIVED
    assert min(clear(flat_body, output.q_rad, post) for output in outputs) > 0.0


def test_keeps_limits_and_rows_on_the_way_to_a_goal_beyond_them(
    arm: VirtualArm, flat_limits: JointLimits
) -> None:
    behind = TipGoal.checked((-0.05, -0.02, 0.0))
    outputs = run(arm, behind, NOTHING, 5.0)
    assert max(flat_limits.violation(output.q_rad) for output in outputs) <= 1e-9


def test_says_unreachable_beyond_its_reach_and_stretches_out(arm: VirtualArm) -> None:
    far = TipGoal.checked((0.9, 0.0, 0.0))
    outputs = run(arm, far, NOTHING, 15.0)
    assert outputs[-1].state is ArmState.UNREACHABLE
    assert "no posture" in outputs[-1].reason
    assert outputs[-1].position_error_m < 0.3 + 0.02


def test_waits_at_a_closed_cage_and_goes_in_when_it_opens(arm: VirtualArm, flat_body: Body) -> None:
    x, y, _ = GOAL.position_m
    walls = [
        box("left", (x - 0.10, y, 0.0), (0.01, 0.11, 0.1)),
        box("right", (x + 0.10, y, 0.0), (0.01, 0.11, 0.1)),
        box("far", (x, y + 0.10, 0.0), (0.11, 0.01, 0.1)),
        box("near", (x, y - 0.10, 0.0), (0.11, 0.01, 0.1)),
    ]
    closed, opened = world_of(walls), world_of(walls[1:3])
    outputs = run(arm, GOAL, closed, 15.0)
    assert outputs[-1].state is ArmState.UNREACHABLE
    assert float(np.abs(outputs[-1].dq_rad_s).max()) < 0.02
    after = run(arm, GOAL, opened, 20.0, "arrived")
    assert after[-1].state is ArmState.ARRIVED
    assert min(clear(flat_body, output.q_rad, closed) for output in outputs) > 0.0
    assert min(clear(flat_body, output.q_rad, opened) for output in after) > 0.0


def test_gives_way_to_a_ball_that_comes_nearer(arm: VirtualArm, flat_body: Body) -> None:
    hand = step(arm, None).tips[0].position_m
    way = np.array([0.0, -1.0, 0.0])
    for tick in range(150):
        centre = hand - (0.15 - 0.15 * tick * PERIOD_S) * way
        moving = world_of((sphere("ball", tuple(centre.tolist()), 0.03),))
        moving = moving._replace(velocities=0.15 * way[None])
        output = step(arm, None, moving)
        assert clear(flat_body, output.q_rad, moving) > 0.0
    assert float(np.linalg.norm(output.tips[0].position_m - hand)) > 0.03


def test_follows_a_moving_goal_without_falling_behind(arm: VirtualArm) -> None:
    speed = np.array([0.0, 0.08, 0.0])
    outputs = []
    for tick in range(300):
        place = np.array([0.45, -0.10, 0.0]) + tick * PERIOD_S * speed
        outputs.append(step(arm, TipGoal.checked(place, None, speed)))
    assert outputs[-1].position_error_m < 0.005


@pytest.mark.parametrize("lag_m", [0.10, 5.0])
def test_waits_for_a_hand_that_is_left_behind(arm: VirtualArm, lag_m: float) -> None:
    output = step(arm, GOAL, lag_m=lag_m)
    assert output.state is ArmState.WAITING
    assert "behind" in output.reason
    np.testing.assert_allclose(output.q_rad, START, atol=1e-4)


def test_follows_a_goal_that_claims_to_be_faster_no_faster_than_it_may(arm: VirtualArm) -> None:
    goal = TipGoal.checked(GOAL.position_m, None, (0.0, 3.0, 0.0))
    speeds = [np.linalg.norm(step(arm, goal).tips[0].velocity_m_s) for _ in range(100)]
    assert max(speeds) <= 1.02 * arm.params.speed_m_s


def test_says_what_it_is_inside_of_and_never_that_it_has_arrived(arm: VirtualArm) -> None:
    hand = step(arm, None).tips[0].position_m
    dropped = world_of((sphere("dropped", tuple(hand.tolist()), 0.3),))
    output = run(arm, TipGoal.checked(hand), dropped, 0.05)[-1]
    assert output.state is not ArmState.ARRIVED
    assert "inside an obstacle" in output.reason


def test_stands_without_a_goal(arm: VirtualArm) -> None:
    output = run(arm, None, NOTHING, 0.2)[-1]
    assert output.state is ArmState.IDLE
    np.testing.assert_array_equal(output.q_rad, START)


def test_other_constants_and_another_arm_go_on_at_the_same_speed(
    arm: VirtualArm, flat_body: Body, flat_limits: JointLimits
) -> None:
    moving = run(arm, GOAL, NOTHING, 0.5)[-1]
    arm.change(ArmParams(speed_m_s=0.15))
    other = VirtualArm(flat_body, flat_body.joints, flat_limits, [2.0] * 3, (0,), [0.3] * 3)
    other.begin(moving.q_rad, moving.dq_rad_s)
    jump = arm.params.acceleration_rad_s2 * PERIOD_S
    for one in (arm, other):
        assert np.abs(step(one, GOAL).dq_rad_s - moving.dq_rad_s).max() <= jump + 1e-9
    slower = run(arm, GOAL, NOTHING, 0.5)[-1]
    assert float(np.linalg.norm(slower.tips[0].velocity_m_s)) <= 1.02 * 0.15


def test_two_runs_are_the_same(flat_body: Body, flat_limits: JointLimits) -> None:
    post = world_of((sphere("post", (0.46, 0.10, 0.0), 0.05),))
    ends = []
    for _ in range(2):
        arm = VirtualArm(flat_body, flat_body.joints, flat_limits, [2.0] * 3, (0,), [0.3] * 3)
        arm.begin(START)
        ends.append(run(arm, GOAL, post, 2.0)[-1].q_rad)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_refuses_what_is_no_number_and_has_not_moved(arm: VirtualArm) -> None:
    with pytest.raises(NotFiniteError):
        TipGoal.checked((math.nan, 0.0, 0.0))
    with pytest.raises(NotFiniteError):
        arm.step([GOAL], NOTHING, STILL, np.array([0.0, math.inf, 0.0]), PERIOD_S)
    with pytest.raises(NotFiniteError):
        arm.step([TipGoal(np.full(3, np.nan))], NOTHING, STILL, STILL, PERIOD_S)
    ball = world_of((sphere("ball", (0.3, 0.0, 0.0), 0.05),))
    with pytest.raises(NotFiniteError):
        arm.step([GOAL], ball._replace(centres=np.full((1, 3), np.nan)), STILL, STILL, PERIOD_S)
    with pytest.raises(ShapeError):
        arm.step([GOAL, GOAL], NOTHING, STILL, STILL, PERIOD_S)
    with pytest.raises(NotFiniteError):
        arm.step([GOAL], NOTHING, STILL, STILL, 0.0)
    with pytest.raises(ArmParamsError, match="speed_m_s"):
        ArmParams(speed_m_s=0.0)
    np.testing.assert_array_equal(arm.q_rad, START)


def test_says_unreachable_of_a_goal_that_goes_on_beyond_its_reach(arm: VirtualArm) -> None:
    states = set()
    for tick in range(800):
        turn = tick * PERIOD_S * 1.25
        place = (0.9 + 0.08 * math.cos(turn), 0.08 * math.sin(turn), 0.0)
        states.add(step(arm, TipGoal.checked(place)).state)
    assert ArmState.UNREACHABLE in states
    assert float(np.abs(arm.q_rad - START).max()) > 0.1


def test_comes_back_from_beyond_a_limit_without_a_jump(
    arm: VirtualArm, flat_limits: JointLimits
) -> None:
    beyond = START.copy()
    beyond[2] = flat_limits.upper_rad[2] + 0.05
    arm.begin(beyond)
    assert float(np.abs(step(arm, None).q_rad - beyond).max()) <= 0.3 * PERIOD_S + 1e-9
    run(arm, None, NOTHING, 1.0)
    assert flat_limits.violation(arm.q_rad) <= 1e-9


def test_keeps_the_whole_margin_again_once_the_goal_has_gone_on_into_the_open(
    arm: VirtualArm,
) -> None:
    """Two balls leave 14 mm beside the hand at the goal; then the goal walks back out, 25 cm."""
    there = run(arm, GOAL, NOTHING, 8.0, until=ArmState.ARRIVED)[-1]
    turned = float(there.q_rad.sum())
    along = np.array([math.cos(turned), math.sin(turned), 0.0])
    side = np.array([-along[1], along[0], 0.0])
    places = [(GOAL.position_m + s * 0.084 * side).tolist() for s in (-1.0, 1.0)]
    world = world_of([sphere(f"ball at {x:.2f}", (x, y, z), 0.05) for x, y, z in places])
    arm.begin(START)
    tight = run(arm, GOAL, world, 30.0, until=ArmState.ARRIVED)[-1]
    assert tight.state is ArmState.ARRIVED
    assert tight.margin_m < arm.params.margin_m
    for k in range(500):
        goal = TipGoal.checked(GOAL.position_m - 0.0005 * k * along, None, -0.05 * along)
        out = step(arm, goal, world)
    assert out.clearance_m > 0.1
    assert out.margin_m == arm.params.margin_m


def test_the_clearance_told_is_the_smallest_whatever_the_margins_are(arm: VirtualArm) -> None:
    """A ball 15 mm away is deeper in its margin than the arm's own links, which nearly touch."""
    folded = np.radians([0.0, 100.0, 99.0])
    arm.begin(folded)
    own = step(arm, None).clearance_m
    beside = sphere("ball", (0.1, -0.02 - 0.03 - own - 0.004, 0.0), 0.03)
    told = step(arm, None, world_of([beside]))
    assert told.clearance_m == pytest.approx(own, abs=1e-3)
    assert told.nearest == ("first", "third")
