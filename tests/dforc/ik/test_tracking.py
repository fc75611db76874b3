"""Following a moving pose: near the answer before, on the target, and back from out of reach."""

import math

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import TRACK_STEP_RAD, IkResult, IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from dforc.rotation import matrix

TOLERANCE_M = 1.001e-4


def lemniscate(centre: Vector, gain_m: float, ticks: int) -> list[Vector]:
    """Points 5 mm apart on a figure of eight in the y-z plane."""
    points, phase = [centre], 0.0
    while len(points) < ticks:
        point = points[-1]
        while math.dist(point, points[-1]) < 0.005:
            phase += 2e-3
            y, z = gain_m * math.sin(phase), 0.5 * gain_m * math.sin(2 * phase)
            point = centre + np.array([0.0, y, z])
        points.append(point)
    return points


def test_moving_pose_is_met_at_every_tick_in_a_few_steps_without_jumps(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    R, centre = model.tip_pose(home)
    q, results = home, list[IkResult]()
    for point in lemniscate(centre, 0.1, 400):
        result = solver.track([TipTarget.checked(point, R)], q)
        assert np.abs(result.q_rad - q).max() < math.radians(3.0)
        assert limits.violation(result.q_rad) <= 0.0
        q = result.q_rad
        results.append(result)
    assert {result.status for result in results} == {IkStatus.CONVERGED}
    assert max(result.position_error_m for result in results) < TOLERANCE_M
    assert np.median([result.iterations for result in results]) <= 6


def test_answers_for_a_pose_that_stands_still_converge_to_the_best_one(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target = TipTarget.checked(p + np.array([-0.02, 0.03, 0.05]), R)
    best = solver.solve([target], home)
    q = home
    for _ in range(150):
        q = solver.track([target], q).q_rad
    assert q == pytest.approx(best.q_rad, abs=2e-3)
    assert solver.track([target], q).objective < best.objective + 1e-5


def test_target_leaves_the_reach_and_comes_back(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    away = [p + np.array([-x, 0.0, 0.0]) for x in np.linspace(0.0, 0.4, 80)]
    q, results = home, list[IkResult]()
    for point in away + away[::-1]:
        result = solver.track([TipTarget.checked(point, R)], q)
        assert np.abs(result.q_rad - q).max() <= TRACK_STEP_RAD + 1e-12
        assert limits.violation(result.q_rad) <= 0.0
        q = result.q_rad
        results.append(result)
    assert results[79].status is IkStatus.INFEASIBLE
    assert results[79].position_error_m > 0.05
    assert results[-1].status is IkStatus.CONVERGED
    assert all(result.status is not IkStatus.OUT_OF_TIME for result in results)


def test_pose_far_away_is_approached_by_one_step_per_tick(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target, step = TipTarget.checked(p + np.array([0.0, 0.0, 0.12]), R), math.radians(2.0)
    q, results = home, []
    for _ in range(60):
        result = solver.track([target], q, step_limit_rad=step)
        assert np.abs(result.q_rad - q).max() <= step + 1e-12
        q = result.q_rad
        results.append(result)
    assert results[0].status is IkStatus.INFEASIBLE
    assert results[0].step_limited
    assert results[0].reason.endswith("within this step")
    assert results[-1].status is IkStatus.CONVERGED
    assert not results[-1].step_limited


def test_every_joint_can_have_a_step_of_its_own(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    steps = np.full(10, 0.05)
    steps[6] = 0.002  # the elbow
    R, p = model.tip_pose(home)
    target = TipTarget.checked(p + np.array([0.0, 0.0, 0.12]), R)
    moved = InverseKinematics(problem).track([target], home, step_limit_rad=steps).q_rad - home
    assert abs(moved[6]) == pytest.approx(0.002, abs=1e-9)
    assert (np.abs(moved) <= steps + 1e-12).all()
    assert np.abs(moved).max() > 0.01


def test_used_up_budget_holds_the_posture(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target = TipTarget.checked(p + np.array([0.0, 0.0, 0.02]), R)
    result = solver.track([target], home, budget=1)
    assert result.status is IkStatus.OUT_OF_TIME
    assert np.array_equal(result.q_rad, home)


def test_search_that_comes_to_no_end_goes_on_with_a_smaller_step(
    solver: InverseKinematics, limits: JointLimits
) -> None:
    """The next tick would begin where this one did, and hold for ever what it holds."""
    q = np.array([1.156, -0.347, -0.039, 0.017, 1.109, 0.289, 0.638, 0.497, -0.457, -0.112])
    target = TipTarget.checked([-0.455, 0.044, 0.216], matrix([-0.792, 1.267, -0.562]))
    first = solver.track([target], q)
    assert first.iterations > 100
    assert first.status is IkStatus.INFEASIBLE
    assert first.step_limited
    for _ in range(80):
        result = solver.track([target], q)
        assert np.abs(result.q_rad - q).max() <= TRACK_STEP_RAD + 1e-12
        assert limits.violation(result.q_rad) <= 0.0
        q = result.q_rad
    assert result.status is IkStatus.CONVERGED


def test_pose_that_stands_still_at_the_edge_of_the_reach_is_not_left_again(
    solver: InverseKinematics,
) -> None:
    """Where orientation pulls hard, the next tick must not take a position it has for lost."""
    q = np.array([-0.384, -0.178, 0.948, -0.298, 1.745, -0.57, 0.547, 0.873, -0.017, 0.047])
    target = TipTarget.checked([0.3356, 0.38074, 0.13302], matrix([1.8098, 1.8863, -0.3625]))
    answers = []
    for _ in range(60):
        answers.append(solver.track([target], q))
        q = answers[-1].q_rad
    assert {answer.status for answer in answers[10:]} == {IkStatus.CONVERGED}
    assert np.ptp([answer.q_rad for answer in answers[-20:]], axis=0).max() < 1e-4
