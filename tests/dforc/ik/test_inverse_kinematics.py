"""Inverse kinematics: answers, statuses, limits on every exit."""

import math

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from dforc import rotation
from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, Priority, TipTarget
from dforc.ik.solver import RawAnswer, SearchBounds
from dforc.ik.starts import starts_of
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

TOLERANCE_M = 1.001e-4
BETA = 0.01


def pose(
    model: RobotModel, q: Vector, moved_m: tuple[float, float, float] = (0, 0, 0)
) -> TipTarget:
    R, p = model.tip_pose(q)
    return TipTarget.checked(p + np.array(moved_m), R)


def test_reachable_poses_are_met_within_all_limits(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    for q in postures:
        target = pose(model, q)
        result = solver.solve([target], rest)
        assert result.status is IkStatus.CONVERGED
        assert result.reason == ""
        assert target.position_m is not None
        assert np.linalg.norm(model.tip_pose(result.q_rad)[1] - target.position_m) < TOLERANCE_M
        assert result.orientation_error_rad < math.radians(1.0)
        assert limits.violation(result.q_rad) <= 0.0


def test_answer_costs_no_more_than_the_posture_that_made_the_pose(
    solver: InverseKinematics,
    model: RobotModel,
    rest: Vector,
    rest_weights: Vector,
    postures: list[Vector],
) -> None:
    for q in postures:
        result = solver.solve([pose(model, q)], q)
        angle = rotation.angle_between(model.tip_pose(result.q_rad)[0], model.tip_pose(q)[0])
        ours = angle**2 + BETA * float(rest_weights @ (result.q_rad - rest) ** 2)
        assert result.objective == pytest.approx(ours, rel=1e-9)
        assert ours <= BETA * float(rest_weights @ (q - rest) ** 2) + 1e-9


def test_answer_is_the_one_that_another_method_finds_from_there(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    rest_weights: Vector,
    postures: list[Vector],
) -> None:
    for q in postures[:4]:
        target = pose(model, q)
        result = solver.solve([target], rest)

        def objective(q: Vector, target: TipTarget = target) -> float:
            assert target.rotation is not None
            angle = rotation.angle_between(model.tip_pose(q)[0], target.rotation)
            return angle**2 + BETA * float(rest_weights @ (q - rest) ** 2)

        def miss(q: Vector, target: TipTarget = target) -> Vector:
            assert target.position_m is not None
            return model.tip_pose(q)[1] - target.position_m

        other = minimize(
            objective,
            result.q_rad,
            method="SLSQP",
            bounds=list(zip(limits.lower_rad, limits.upper_rad, strict=True)),
            constraints=[
                LinearConstraint(limits.rows, limits.lower[10:], limits.upper[10:]),
                {"type": "eq", "fun": miss},
            ],
            options={"maxiter": 300, "ftol": 1e-12},
        )
        assert np.linalg.norm(miss(other.x)) < 1e-6
        # The slack of 0.1 mm may be worth as much as its multiplier says: 1e-4 rad^2 at most.
        assert result.objective < float(other.fun) + 2e-4


def test_slack_of_a_loose_position_is_used_for_the_orientation(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target = TipTarget.checked(p, rotation.matrix([0.0, 0.0, 1.6]) @ R)  # beyond the wrist
    tight = InverseKinematics(problem).solve([target], home)
    loose = InverseKinematics(problem.changed(position_tolerance_m=0.02)).solve([target], home)
    assert tight.orientation_error_rad > 0.05
    assert loose.status is IkStatus.CONVERGED
    assert 0.003 < loose.position_error_m <= 0.02
    assert loose.orientation_error_rad < tight.orientation_error_rad - 0.01


def test_position_out_of_reach_gives_the_nearest_posture_and_says_so(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    for direction in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 0.4, -0.4)):
        target = pose(model, home, direction)
        assert target.position_m is not None
        result = solver.solve([target], home)
        assert result.status is IkStatus.INFEASIBLE
        assert result.reason == f"nearest position is {result.position_error_m:.2g} m away"
        assert limits.violation(result.q_rad) <= 0.0
        better = minimize(
            lambda q, x=target.position_m: float(np.linalg.norm(model.tip_pose(q)[1] - x)),
            result.q_rad,
            method="SLSQP",
            bounds=list(zip(limits.lower_rad, limits.upper_rad, strict=True)),
            constraints=LinearConstraint(limits.rows, limits.lower[10:], limits.upper[10:]),
            options={"maxiter": 200},
        )
        assert result.position_error_m < float(better.fun) + 1e-4


def test_orientation_out_of_reach_costs_no_position(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    result = solver.solve([TipTarget.checked(p, rotation.matrix([0, 0, np.pi - 1e-3]) @ R)], home)
    assert result.status is IkStatus.CONVERGED
    assert result.position_error_m < TOLERANCE_M
    assert result.orientation_error_rad > 0.5


def test_priority_of_orientation_keeps_it_and_gives_way_with_the_position(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target = TipTarget.checked(p + np.array([-0.5, 0.0, 0.3]), R)
    first = InverseKinematics(problem.changed(priority=Priority.ORIENTATION))
    result = first.solve([target], home)
    assert result.status is IkStatus.CONVERGED
    assert result.orientation_error_rad <= 1.001e-3
    assert result.position_error_m > 0.1
    nearest = InverseKinematics(problem).solve([target], home)
    assert nearest.status is IkStatus.INFEASIBLE
    assert nearest.position_error_m < result.position_error_m
    reachable = first.solve([pose(model, home, (0.0, 0.0, 0.03))], home)
    assert reachable.orientation_error_rad <= 1.001e-3
    assert reachable.position_error_m < 2e-3


def test_position_alone_leaves_the_orientation_free(
    solver: InverseKinematics, model: RobotModel, home: Vector, rest: Vector, rest_weights: Vector
) -> None:
    whole = pose(model, home, (0.0, 0.1, 0.1))
    free = TipTarget.checked(whole.position_m, None)
    result = solver.solve([free], home)
    assert result.status is IkStatus.CONVERGED
    assert result.position_error_m < TOLERANCE_M
    assert result.orientation_error_rad == 0.0  # of what was asked for
    bound = solver.solve([whole], home)
    away = [float(rest_weights @ (r.q_rad - rest) ** 2) for r in (result, bound)]
    assert away[0] < away[1]


def test_nothing_asked_for_gives_the_rest_posture(
    solver: InverseKinematics, home: Vector, rest: Vector
) -> None:
    assert solver.solve([None], home).q_rad == pytest.approx(rest, abs=1e-9)
    assert solver.solve([None], home).tip_errors == (None,)


def test_present_pose_as_target_is_an_answer_at_once(
    solver: InverseKinematics, model: RobotModel, rest: Vector
) -> None:
    result = solver.solve([pose(model, rest)], rest)
    assert result.status is IkStatus.CONVERGED
    assert result.q_rad == pytest.approx(rest, abs=1e-6)
    assert result.iterations <= 3


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.6, 0.8)])
def test_half_a_turn_away_is_answered_like_any_other_pose(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    home: Vector,
    axis: tuple[float, float, float],
) -> None:
    R, p = model.tip_pose(home)
    turned = rotation.matrix(np.pi * np.array(axis)) @ R
    result = solver.solve([TipTarget.checked(p, turned)], home)
    assert result.status is IkStatus.CONVERGED
    assert result.position_error_m < TOLERANCE_M
    assert limits.violation(result.q_rad) <= 0.0
    assert result.orientation_error_rad < np.pi - 0.3


def test_used_up_budget_gives_the_start_and_says_so(
    solver: InverseKinematics, model: RobotModel, rest: Vector, postures: list[Vector]
) -> None:
    for q in postures[:10]:
        result = solver.solve([pose(model, q)], rest, budget=2)
        assert result.status is IkStatus.OUT_OF_TIME
        assert np.array_equal(result.q_rad, rest)
        assert "2 iterations" in result.reason


class Liar:
    """A solver that calls anything an answer."""

    def __init__(self, answer: Vector) -> None:
        self._answer = answer

    def solve(self, *_: object) -> RawAnswer:
        return RawAnswer(self._answer, 1, solved=True)


def test_answers_are_checked_whoever_gives_them(
    problem: IkProblem, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    target = pose(model, home)
    wrong = InverseKinematics(problem, Liar(home + 0.1)).solve([target], home)
    assert wrong.status is IkStatus.INFEASIBLE
    assert wrong.position_error_m > 0.02
    nothing = InverseKinematics(problem, Liar(np.full(10, np.nan))).solve([target], home)
    assert nothing.status is IkStatus.OUT_OF_TIME
    assert np.array_equal(nothing.q_rad, home)
    crossed = home.copy()
    crossed[4:6] = limits.lower_rad[4] + 0.05, limits.lower_rad[5]
    assert limits.violation(crossed) > 0.05  # a row, with every joint inside its range
    outside = InverseKinematics(problem, Liar(crossed)).solve([target], home)
    assert outside.status is IkStatus.OUT_OF_TIME
    assert np.array_equal(outside.q_rad, home)


def test_joints_without_an_end_have_other_starts_too(problem: IkProblem, home: Vector) -> None:
    endless = JointLimits.make([-np.inf] * 10, [*[np.inf] * 5, *problem.limits.upper_rad[5:]])
    bounds = SearchBounds(endless.lower, endless.upper)
    starts = list(starts_of(problem.changed(limits=endless), home, bounds))
    assert len(starts) > 5
    assert np.abs(np.array(starts) - home).max() < 4.0 * np.pi
