"""A virtual point that carries a posture: taken where it checks out, else searched near it."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from dforc import rotation
from services.core.testing import Bench
from services.messages import IkSolution, VirtualPoint
from services.reaching.limb import limb_model
from services.reaching.tip_poses import vector3
from services.robotfile.robot_tables import RobotFile
from services.streams import IK_SOLUTION, VIRTUAL_POINT
from tests.services.asking import HOME_RAD, standing

HOME = np.array(HOME_RAD)
NULL_MOTION = 0.02  # rad of each joint


def point_at(
    robot: RobotFile, q_rad: NDArray[np.float64], sequence: int = 1, **more: object
) -> VirtualPoint:
    """The hand of a posture as a point that carries the posture."""
    turned, place = limb_model(robot).tip_pose(q_rad)
    plain = VirtualPoint(
        stamp_ns=0,
        sequence=sequence,
        position_m=vector3(place),
        velocity_m_s=(0.0, 0.0, 0.0),
        rotation_rad=vector3(rotation.rotation_vector(turned)),
        q_rad=tuple(q_rad.tolist()),
    )
    return msgspec.structs.replace(plain, **more)


def answer(bench: Bench, point: VirtualPoint) -> IkSolution:
    bench.put(VIRTUAL_POINT, point)
    return bench.last(IK_SOLUTION)


@pytest.fixture
def bench(robot: RobotFile) -> Bench:
    return standing(robot)


def test_a_posture_that_checks_out_is_the_answer_to_the_last_digit(
    robot: RobotFile, bench: Bench
) -> None:
    q_rad = HOME + NULL_MOTION * np.array([1, -1, 1, -1, 1, -1, 1, -1, 1, -1])
    solution = answer(bench, point_at(robot, q_rad))
    assert solution.q_rad == tuple(q_rad.tolist())
    assert (solution.status, solution.iterations, solution.sequence) == ("converged", 0, 1)
    assert solution.position_error_m < 1e-9


@pytest.mark.parametrize(
    "why", ["hand elsewhere", "turned otherwise", "too far", "not finite", "too short", "outside"]
)
def test_a_posture_that_does_not_check_out_is_searched_for(
    robot: RobotFile, bench: Bench, why: str
) -> None:
    q_rad = HOME + NULL_MOTION * np.array([1, -1, 1, -1, 1, -1, 1, -1, 1, -1])
    point = point_at(robot, q_rad)
    x, y, z = point.position_m
    a, b, c = point.rotation_rad
    point = {
        "hand elsewhere": msgspec.structs.replace(point, position_m=(x, y, z + 0.001)),
        "turned otherwise": msgspec.structs.replace(point, rotation_rad=(a, b, c + 0.01)),
        "too far": point_at(robot, HOME + 0.3),
        "not finite": msgspec.structs.replace(point, q_rad=(float("nan"), *point.q_rad[1:])),
        "too short": msgspec.structs.replace(point, q_rad=point.q_rad[1:]),
        "outside": point_at(robot, HOME + np.eye(10)[6] * 4.0),
    }[why]
    solution = answer(bench, point)
    assert solution.iterations > 0
    assert solution.q_rad != point.q_rad
    assert np.isfinite(solution.q_rad).all()
    assert np.abs(np.array(solution.q_rad) - HOME).max() < 0.2


def test_a_search_rests_at_the_posture_that_was_given(robot: RobotFile, bench: Bench) -> None:
    """The waist is redundant: it comes to where the given posture has it."""
    leaning = HOME.copy()
    leaning[2] += 0.15
    far = point_at(robot, leaning)
    for sequence in range(1, 200):
        point = msgspec.structs.replace(far, sequence=sequence, position_only=True)
        x, y, z = point.position_m
        solution = answer(bench, msgspec.structs.replace(point, position_m=(x, y, z + 0.0005)))
        bench.advance(0.01)
    assert solution.q_rad[2] == pytest.approx(leaning[2], abs=0.03)


def test_orientation_is_not_looked_at_where_it_does_not_matter(
    robot: RobotFile, bench: Bench
) -> None:
    q_rad = HOME + NULL_MOTION
    point = point_at(robot, q_rad, position_only=True, rotation_rad=(0.0, 0.0, 0.0))
    assert answer(bench, point).q_rad == tuple(q_rad.tolist())
