"""The IK service: answers, out of reach, and what it refuses."""

import msgspec
import numpy as np
import pytest

from services.core.testing import Bench
from services.ik import Ik
from services.messages import CartesianStatus
from services.reaching.limb import limb_limits
from services.robotfile.robot_tables import RobotFile
from services.streams import CARTESIAN_STATUS, IK_SOLUTION, VIRTUAL_POINT
from tests.services.postures import point


@pytest.fixture
def bench(robot: RobotFile, at_home: CartesianStatus) -> Bench:
    bench = Bench(Ik(robot))
    bench.put(CARTESIAN_STATUS, at_home)
    return bench


def test_answer_reaches_the_point_within_all_limits(robot: RobotFile, bench: Bench) -> None:
    for i in range(1, 21):
        bench.put(VIRTUAL_POINT, point(robot, (-0.007 * i, -0.007 * i, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "converged"
    assert solution.sequence == 20
    assert solution.position_error_m < 3e-4
    assert solution.orientation_error_rad < np.radians(0.3)
    assert limb_limits(robot).violation(np.array(solution.q_rad)) <= 1e-9


def test_no_joint_jumps_between_two_answers(robot: RobotFile, bench: Bench) -> None:
    for i in range(40):
        bench.put(VIRTUAL_POINT, point(robot, (-0.005 * i, 0.0, 0.0), i))
    postures = np.array([solution.q_rad for solution in bench.sent(IK_SOLUTION)])
    assert np.abs(np.diff(postures, axis=0)).max() <= np.radians(5.0) + 1e-9


def test_out_of_reach_says_so_and_gives_the_nearest(robot: RobotFile, bench: Bench) -> None:
    for i in range(60):
        bench.put(VIRTUAL_POINT, point(robot, (-0.02 * i, 0.0, 0.0), i))
    solution = bench.last(IK_SOLUTION)
    assert solution.status == "infeasible"
    assert solution.position_error_m > 0.1
    assert np.isfinite(solution.q_rad).all()
    assert limb_limits(robot).violation(np.array(solution.q_rad)) <= 1e-9


def test_point_that_is_not_finite_is_refused(robot: RobotFile, bench: Bench) -> None:
    bench.put(VIRTUAL_POINT, point(robot, (float("nan"), 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []
    assert isinstance(bench.service, Ik)
    assert bench.service.refused == 1


def test_is_silent_before_the_joints_are_known(robot: RobotFile) -> None:
    bench = Bench(Ik(robot))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []


@pytest.mark.parametrize("size_rad", [float("nan"), float("inf"), 1e200, 1e160])
def test_rotation_that_is_none_is_refused(robot: RobotFile, bench: Bench, size_rad: float) -> None:
    good = point(robot, (0.0, 0.0, 0.0))
    bad = msgspec.structs.replace(good, rotation_rad=(size_rad, 0.0, 0.0))
    bench.put(VIRTUAL_POINT, bad)
    assert bench.sent(IK_SOLUTION) == []
    bench.put(VIRTUAL_POINT, good)
    assert bench.last(IK_SOLUTION).status == "converged"


@pytest.mark.parametrize("q_rad", [(0.1,), (float("nan"),) * 10])
def test_posture_that_is_none_is_refused(
    robot: RobotFile, at_home: CartesianStatus, q_rad: tuple[float, ...]
) -> None:
    bench = Bench(Ik(robot))
    bench.clock.sleep_until(1_000_000_000)
    bench.put(CARTESIAN_STATUS, msgspec.structs.replace(at_home, q_rad=q_rad))
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.sent(IK_SOLUTION) == []
    bench.put(CARTESIAN_STATUS, at_home)
    bench.put(VIRTUAL_POINT, point(robot, (0.0, 0.0, 0.0)))
    assert bench.last(IK_SOLUTION).status == "converged"
