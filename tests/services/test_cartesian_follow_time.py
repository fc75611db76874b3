"""The trajectory time that a stream of points asks for."""

import math

import msgspec
import numpy as np
import pytest

from services.cartesian import Cartesian
from services.core.testing import Bench
from services.messages import IkSolution, JointState
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_STATUS,
    IK_SOLUTION,
    JOINT_COMMAND,
    JOINT_STATE,
    VIRTUAL_POINT,
)
from tests.services.postures import point

PERIOD_S = 0.01


class Following:
    """A controller that is given one point in every period, and its posture."""

    def __init__(self, robot: RobotFile, home: dict[str, JointState]) -> None:
        self.bench = Bench(Cartesian(robot))
        self._robot = robot
        self._home = home
        self._q = np.concatenate([home[part].q_rad for part in robot.reach.parts])
        self._sequence = 0

    def run(self, seconds: float, time_s: float) -> None:
        """The target is 5 cm above home, with the elbow bent by what that takes about."""
        for _ in range(round(seconds / PERIOD_S)):
            for part, state in self._home.items():
                self.bench.put(JOINT_STATE[part], state)
            self._sequence += 1
            here = point(self._robot, (0.0, 0.0, 0.05), self._sequence)
            self.bench.put(VIRTUAL_POINT, msgspec.structs.replace(here, trajectory_time_s=time_s))
            q_rad = self._q + 0.1 * np.eye(10)[6]
            solution = IkSolution(
                stamp_ns=0,
                sequence=self._sequence,
                q_rad=tuple(q_rad.tolist()),
                status="converged",
                position_error_m=0.0,
                orientation_error_rad=0.0,
                iterations=1,
            )
            self.bench.put(IK_SOLUTION, solution)
            self.bench.advance(PERIOD_S)

    def speeds(self) -> np.ndarray:
        """Of all joints of the arm, one row for each period."""
        sent = self.bench.sent(JOINT_COMMAND["right_arm"])
        return np.array([command.dq_rad_s for command in sent])


def rise_s(robot: RobotFile, home: dict[str, JointState], time_s: float) -> float:
    """When the plan is half way to the point."""
    following = Following(robot, home)
    following.run(0.1, time_s)
    start = np.array(following.bench.last(CARTESIAN_STATUS).plan_position_m)
    for i in range(200):
        following.run(PERIOD_S, time_s)
        status = following.bench.last(CARTESIAN_STATUS)
        left = math.dist(status.plan_position_m, status.point_position_m)
        if left < 0.5 * math.dist(start, status.point_position_m):
            return 0.1 + i * PERIOD_S
    raise AssertionError("the plan does not move")


def test_a_jump_takes_the_time_that_the_point_asks_for(
    robot: RobotFile, home: dict[str, JointState]
) -> None:
    assert rise_s(robot, home, 1.2) > 1.5 * rise_s(robot, home, 0.6)


def test_without_one_it_takes_the_robot_file_s(
    robot: RobotFile, home: dict[str, JointState]
) -> None:
    own_s = robot.reach.trajectory_time_s
    assert rise_s(robot, home, 0.0) == rise_s(robot, home, own_s)


def test_a_time_that_changes_on_the_way_does_not_step_the_speed(
    robot: RobotFile, home: dict[str, JointState]
) -> None:
    steady, changed = Following(robot, home), Following(robot, home)
    steady.run(0.6, 0.6)
    changed.run(0.2, 0.6)
    changed.run(0.4, 1.5)
    usual = np.abs(np.diff(steady.speeds(), axis=0)).max()
    assert np.abs(np.diff(changed.speeds(), axis=0)).max() <= 1.2 * usual
    assert not np.allclose(steady.speeds()[-1], changed.speeds()[-1], rtol=0.05)


@pytest.mark.parametrize("time_s", [-1.0, 0.05, 61.0, math.nan])
def test_a_time_that_is_none_is_refused(
    robot: RobotFile, home: dict[str, JointState], time_s: float
) -> None:
    following = Following(robot, home)
    following.run(0.1, time_s)
    status = following.bench.last(CARTESIAN_STATUS)
    assert status.refused > 0
    assert status.mode == "idle"
