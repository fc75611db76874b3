"""Mode ulna through the service: the whole arm, the rest of the body, gains on the way."""

import msgspec
import numpy as np
import pytest

from services.config import load_robot
from services.core.testing import Bench
from services.fields.messages import FieldRequest
from services.ik import Ik
from services.messages import JointState
from services.reaching.limb import limb_model
from services.reaching.messages import LimbSetup, SetupInUse
from services.reaching.tip_poses import vector3
from services.robotfile.robot_tables import RobotFile
from services.streams import CARTESIAN_SETUP, FIELD_STATUS, IK_SOLUTION, JOINT_STATE, VIRTUAL_POINT
from tests.services.field_stand import PERIOD_S, FieldStand, ball


class FollowedStand(FieldStand):
    """The same with an arm that is where the newest point has it."""

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / PERIOD_S)):
            points = self.bench.sent(VIRTUAL_POINT)
            if points and points[-1].q_rad:
                self._stand_at(points[-1].q_rad)
            super().run(PERIOD_S)

    def block(self, robot: RobotFile, *names: str) -> None:
        """Joints that may not move, as the Cartesian controller tells."""
        free = tuple(name not in names for name in robot.chain)
        setup = LimbSetup(limb="right_arm", free=free)
        self.bench.put(CARTESIAN_SETUP, SetupInUse(stamp_ns=0, setup=setup))

    def _stand_at(self, q_rad: tuple[float, ...]) -> None:
        start = 0
        for part in ("torso", "right_arm"):
            state: JointState = self.states[part]
            end = start + len(state.q_rad)
            self.states[part] = msgspec.structs.replace(state, q_rad=q_rad[start:end])
            start = end


@pytest.fixture
def stand(robot: RobotFile) -> FollowedStand:
    stand = FollowedStand(robot, "ulna")
    stand.run(0.05)
    return stand


def test_the_hand_arrives_beside_a_ball_with_the_margin_kept(stand: FollowedStand) -> None:
    stand.see(ball("ball", stand.beside(-0.05, 0.0, -0.15)))
    stand.send(stand.goal(-0.08, 0.0, 0.03))
    closest_m = np.inf
    for _ in range(30):
        stand.run(0.1)
        closest_m = min(closest_m, stand.bench.last(FIELD_STATUS).clearance_m)
    status = stand.told()
    assert status.state == "arrived"
    assert status.goal_distance_m < 0.002
    assert closest_m > 0.015
    assert status.lag_m < 0.001


def test_inverse_kinematics_answers_with_the_arm_s_own_posture(
    robot: RobotFile, stand: FollowedStand
) -> None:
    stand.send(stand.goal(-0.08, 0.0, 0.03))
    stand.run(0.5)
    points = stand.bench.sent(VIRTUAL_POINT)
    follower = Bench(Ik(robot))
    for part, state in FieldStand(robot).states.items():
        follower.put(JOINT_STATE[part], state)
    for point in points:
        follower.put(VIRTUAL_POINT, point)
        follower.advance(PERIOD_S)
    answers = follower.sent(IK_SOLUTION)
    assert [answer.q_rad for answer in answers] == [point.q_rad for point in points]
    assert {answer.iterations for answer in answers} == {0}


def test_a_goal_inside_an_obstacle_is_unreachable_and_the_point_waits_outside(
    stand: FollowedStand,
) -> None:
    stand.see(ball("ball", stand.beside(-0.15, 0.0, 0.0), 0.08))
    stand.send(stand.goal(-0.15, 0.0, 0.0))
    stand.run(6.0)
    status = stand.told()
    assert status.state == "unreachable"
    assert status.reason != ""
    assert status.clearance_m > 0.0
    assert status.nearest[1] == "ball"
    stand.see()  # the ball is gone: it goes on by itself
    stand.run(4.0)
    assert stand.told().state == "arrived"


def test_room_kept_around_a_ball_that_moves_is_told_apart_from_the_ball(
    stand: FollowedStand,
) -> None:
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    stand.run(3.0)
    place = stand.beside(-0.05, 0.0, 0.10)
    stand.see(ball("ball", place, 0.03))
    still = stand.told()
    assert (still.state, still.nearest[1]) == ("arrived", "ball")
    stand.see(ball("ball", place, 0.03, velocity_m_s=(0.0, 0.0, -0.6)))
    stand.run(5 * PERIOD_S)
    coming = stand.bench.last(FIELD_STATUS)
    # 4 periods at 0.6 m/s are 24 mm, and the arm has got out of the way by about as much
    assert still.clearance_m == pytest.approx(0.05, abs=0.005)
    assert coming.clearance_m == pytest.approx(still.clearance_m, abs=0.01)
    assert coming.state != "arrived"
    assert "mm inside the room kept around ball" in coming.reason


def test_an_arm_inside_a_ball_is_said_to_be_inside_the_ball(stand: FollowedStand) -> None:
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    stand.run(3.0)
    place = stand.beside(-0.05, 0.0, 0.0)
    stand.see(ball("ball", place, 0.08, velocity_m_s=(0.0, 0.0, -0.1)))
    stand.run(5 * PERIOD_S)
    status = stand.bench.last(FIELD_STATUS)
    assert status.clearance_m < 0.0
    assert status.state != "arrived"
    assert status.reason.endswith("mm inside ball")


def test_a_goal_beyond_all_reach_is_told_at_once_and_the_hand_goes_as_near_as_it_can(
    stand: FollowedStand,
) -> None:
    reply = stand.ask(FieldRequest(action="goal", goal=stand.goal(-0.7, 0.0, 0.0)))
    assert "beyond the reach of right_arm" in reply.reason
    status = stand.told()  # 60 ms after the goal
    begun_m = status.goal_distance_m
    assert (status.state, status.reason) == ("unreachable", reply.reason)
    stand.run(3.0)
    status = stand.told()
    assert (status.state, status.reason) == ("unreachable", reply.reason)
    assert begun_m > 0.65
    assert status.goal_distance_m < begun_m - 0.15
    beyond_mm = float(reply.reason.split()[2])
    assert beyond_mm < 1e3 * status.goal_distance_m
    stand.send(stand.goal(-0.05, 0.0, 0.0))
    assert stand.told().state == "reaching"


def test_the_other_arm_is_kept_clear_of_where_it_is_measured() -> None:
    """The goal is the left hand, and the waist may not turn that away."""
    robot = load_robot("icub:arms")
    stand = FollowedStand(robot, "ulna")
    stand.run(0.05)
    assert stand.told().assumed == ()
    stand.block(robot, "torso_pitch", "torso_roll", "torso_yaw")
    x, y, z = stand.beside(0.0, 0.0, 0.0)
    goal = msgspec.structs.replace(stand.goal(0.0, 0.0, 0.0), position_m=(x, -y, z))
    stand.send(goal)
    closest_m = np.inf
    for _ in range(40):
        stand.run(0.1)
        closest_m = min(closest_m, stand.bench.last(FIELD_STATUS).clearance_m)
    assert stand.told().state in ("planning", "waiting", "unreachable")
    assert 0.0 < closest_m < 0.2


def test_an_arm_that_is_not_heard_is_said_to_be_assumed() -> None:
    stand = FieldStand(load_robot("icub:arms"), "ulna")
    stand.run(0.05)
    state = stand.states["left_arm"]
    stand.states["left_arm"] = msgspec.structs.replace(state, valid=False)
    stand.run(0.2)
    assert stand.told().assumed == ("left_arm",)


def test_gains_change_on_the_way_without_a_jump(stand: FollowedStand) -> None:
    stand.send(stand.goal(-0.15, 0.0, 0.05))
    stand.run(0.4)
    stand.set(gains=(("speed", 0.1), ("margin", 0.03)))
    stand.run(0.3)
    points = stand.bench.sent(VIRTUAL_POINT)
    path = np.array([point.position_m for point in points])
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.004
    assert np.linalg.norm(points[-1].velocity_m_s) < 0.12


def test_a_preview_of_the_arm_tells_postures_and_moves_nothing(stand: FollowedStand) -> None:
    goal = stand.goal(-0.06, 0.0, 0.03)
    found = stand.ask(FieldRequest(action="preview", goal=goal, duration_s=6.0)).preview
    assert found is not None
    assert found.arrives
    assert len(found.path[-1].q_rad) == 10
    assert stand.bench.sent(VIRTUAL_POINT) == []


def test_blocked_joints_stay_where_they_are(robot: RobotFile) -> None:
    stand = FollowedStand(robot, "ulna")
    stand.run(0.05)
    stand.block(robot, "torso_pitch", "torso_roll", "torso_yaw")
    bent = np.radians(robot.reach.home_deg) + 0.15 * np.eye(10)[6]
    place = vector3(limb_model(robot).tip_pose(bent)[1])
    stand.send(msgspec.structs.replace(stand.goal(0.0, 0.0, 0.0), position_m=place))
    stand.run(2.0)
    point = stand.bench.last(VIRTUAL_POINT)
    assert np.abs(point.q_rad[:3]).max() < 1e-9
    assert stand.told().state == "arrived"
