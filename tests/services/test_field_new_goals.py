"""A new goal of the field: what was found of the one before is no verdict on it."""

from services.fields.messages import FieldRequest
from services.messages import Goal
from services.robotfile.robot_tables import RobotFile
from services.streams import FIELD_STATUS
from tests.services.field_stand import PERIOD_S, FieldStand, ball
from tests.services.test_field_ulna import FollowedStand


def states_until_arrival(stand: FieldStand, goal: Goal, longest_s: float) -> list[str]:
    """Of a goal that is asked for; each state once where it does not change."""
    number = stand.ask(FieldRequest(action="goal", goal=goal)).goal
    begun = len(stand.bench.sent(FIELD_STATUS))
    stand.run(longest_s)
    told = [s.state for s in stand.bench.sent(FIELD_STATUS)[begun:] if s.last_goal == number]
    return [state for k, state in enumerate(told) if k == 0 or state != told[k - 1]]


def test_a_point_that_was_trapped_does_not_wait_on_its_way_to_another_goal(
    robot: RobotFile,
) -> None:
    stand = FieldStand(robot, "dforc")
    stand.run(0.05)
    stand.set(preset="paper")
    stand.see(ball("wall", stand.beside(-0.1, 0.0, 0.0)))
    stand.send(stand.goal(-0.2, 0.0, 0.0))
    stand.run(15.0)
    assert stand.told().state == "waiting"
    stand.see()
    states = states_until_arrival(stand, stand.goal(0.0, 0.12, 0.0), 12.0)
    assert states == ["reaching", "arrived"]


def test_a_time_base_that_has_run_out_begins_again_for_a_goal_beside(robot: RobotFile) -> None:
    stand = FieldStand(robot, "pmp")
    stand.set(preset="paper")
    stand.send(stand.goal(-0.15, 0.0, 0.1))
    stand.run(3.5)
    assert "time base has run out" in stand.told().reason
    stand.ask(FieldRequest(action="goal", goal=stand.goal(-0.15, 0.005, 0.1)))
    assert stand.told().state == "reaching"


def test_a_goal_beside_one_that_was_out_of_reach_is_not_out_of_reach(robot: RobotFile) -> None:
    stand = FollowedStand(robot, "ulna")
    stand.run(0.05)
    stand.see(ball("ball", stand.beside(-0.15, 0.0, 0.0), 0.05))
    stand.send(stand.goal(-0.15, 0.0, 0.0))
    stand.run(8.0)
    assert stand.told().state == "unreachable"
    states = states_until_arrival(stand, stand.goal(-0.06, 0.0, 0.0), 4.0)
    assert states == ["reaching", "arrived"]


def test_a_streamed_goal_that_moves_on_is_pursued_as_one(robot: RobotFile) -> None:
    stand = FollowedStand(robot, "ulna")
    stand.run(0.05)
    stand.see(ball("ball", stand.beside(-0.15, 0.0, 0.0), 0.05))
    for k in range(800):  # 8 s
        stand.send(stand.goal(-0.15, 0.001 * (k % 2), 0.0))
        stand.run(PERIOD_S)
    status = stand.told()
    assert status.last_goal == 800
    assert status.state == "unreachable"


def test_a_followed_goal_is_the_same_whatever_place_is_sent_with_it(robot: RobotFile) -> None:
    stand = FieldStand(robot, "dforc")
    stand.see(ball("cube", stand.beside(-0.05, 0.0, 0.0), 0.01, role="target"))
    stand.run(0.05)
    for k in range(20):
        stand.send(stand.goal(-0.05, 0.001 * k, 0.0, follow="cube"))
        stand.run(PERIOD_S)
    assert stand.told().last_goal == 1
