"""Both hands over one waist, and constraints that are plugged in."""

import math

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.robot_model import RobotModel


def postures_of(problem: IkProblem, count: int) -> list[Vector]:
    """Random ones, near the middle of what limits and rows allow."""
    rng = np.random.default_rng(4)
    limits = problem.limits
    room = limits.upper_rad - limits.lower_rad
    found: list[Vector] = []
    while len(found) < count:
        q = limits.lower_rad + room * rng.uniform(0.2, 0.8, problem.n)
        if limits.violation(q) < 0.0:
            found.append(q)
    return found


def test_both_hands_meet_their_poses_over_one_waist(both_arms: IkProblem) -> None:
    solver = InverseKinematics(both_arms)
    start = both_arms.limits.project(both_arms.rest_rad)
    for q in postures_of(both_arms, 15):
        targets = []
        for tip in both_arms.tips:
            R, p = tip.pose(q)
            targets.append(TipTarget.checked(p, R))
        result = solver.solve(targets, start)
        assert result.status is IkStatus.CONVERGED
        assert both_arms.limits.violation(result.q_rad) <= 0.0
        for tip, target in zip(both_arms.tips, targets, strict=True):
            assert tip.pose(result.q_rad)[1] == pytest.approx(target.position_m, abs=1.001e-4)
        assert result.orientation_error_rad < math.radians(3.0)


def test_one_hand_alone_leaves_the_other_arm_at_rest(both_arms: IkProblem) -> None:
    solver = InverseKinematics(both_arms)
    start = both_arms.limits.project(both_arms.rest_rad)
    R, p = both_arms.tips[1].pose(start)
    result = solver.solve([None, TipTarget.checked(p + np.array([0.0, 0.0, 0.05]), R)], start)
    assert result.status is IkStatus.CONVERGED
    assert result.tip_errors[0] is None
    assert result.q_rad[3:10] == pytest.approx(both_arms.rest_rad[3:10], abs=1e-6)


def test_two_hands_pulled_apart_share_the_miss(both_arms: IkProblem) -> None:
    solver = InverseKinematics(both_arms)
    start = both_arms.limits.project(both_arms.rest_rad)
    targets = []
    for tip, side in zip(both_arms.tips, (-1.0, 1.0), strict=True):
        R, p = tip.pose(start)
        targets.append(TipTarget.checked(p + np.array([0.0, 2.0 * side, 0.0]), R))
    result = solver.solve(targets, start)
    assert result.status is IkStatus.INFEASIBLE
    left, right = result.tip_errors
    assert left is not None
    assert right is not None
    assert min(left[0], right[0]) > 0.5


class KeepOut:
    """The tip stays on one side of a plane: normal . p >= offset."""

    size = 1

    def __init__(self, model: RobotModel, normal: Vector, offset_m: float) -> None:
        self._model, self._normal, self._offset_m = model, normal, offset_m

    def evaluate(self, q_rad: Vector) -> tuple[Vector, Matrix]:
        _, p = self._model.tip_pose(q_rad)
        J = self._model.tip_jacobian(q_rad)
        return np.array([self._normal @ p - self._offset_m]), (self._normal @ J[:3])[None]


@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (-0.6, 0.8, 0.0)])
def test_plugged_in_constraint_is_kept_and_its_nearest_point_found(
    problem: IkProblem, model: RobotModel, home: Vector, direction: tuple[float, float, float]
) -> None:
    R, p = model.tip_pose(home)
    outwards = np.array(direction)
    wall = KeepOut(model, -outwards, float(-outwards @ p) - 0.03)  # 3 cm away
    solver = InverseKinematics(problem.changed(extra=wall))
    result = solver.solve([TipTarget.checked(p + 0.06 * outwards, R)], home)
    assert result.status is IkStatus.INFEASIBLE
    assert result.position_error_m == pytest.approx(0.03, abs=1e-4)
    assert wall.evaluate(result.q_rad)[0][0] >= -1e-6
    inside = solver.solve([TipTarget.checked(p + 0.02 * outwards, R)], home)
    assert inside.status is IkStatus.CONVERGED
    tracked = home
    for step in range(12):
        point = TipTarget.checked(p + 0.005 * step * outwards, R)
        tracked = solver.track([point], tracked).q_rad
        assert wall.evaluate(tracked)[0][0] >= -1e-6


def test_constraint_that_nothing_can_keep_is_no_answer(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    nowhere = KeepOut(model, np.array([0.0, 0.0, 1.0]), 50.0)
    result = InverseKinematics(problem.changed(extra=nowhere)).solve(
        [TipTarget.checked(p, R)], home
    )
    assert result.status is IkStatus.OUT_OF_TIME
    assert np.array_equal(result.q_rad, home)
