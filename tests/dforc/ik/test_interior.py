"""IPOPT and fatrop: what they answer, and that it is what the compiled search answers."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from dforc.arrays import Matrix, Vector
from dforc.errors import DforcError
from dforc.ik.interior import FatropSolver, InteriorSolver, IpoptSolver, NotSymbolicError
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, Priority, Tip, TipTarget
from dforc.robot_model import RobotModel
from dforc.rotation import angle_between, matrix

WITHIN_M = 1.001e-4


@pytest.fixture(scope="module", params=[IpoptSolver, FatropSolver])
def interior(request: pytest.FixtureRequest) -> InteriorSolver:
    """One for all tests: what it was asked before must not matter."""
    made: InteriorSolver = request.param()
    return made


def pose_of(tip: Tip, q: Vector) -> TipTarget:
    R, p = tip.pose(q)
    return TipTarget.checked(p, R)


def moved(target: TipTarget, by_m: Vector) -> TipTarget:
    assert target.position_m is not None
    return TipTarget(target.position_m + by_m, target.rotation)


def test_poses_are_met_at_the_cost_of_the_compiled_search(
    interior: InteriorSolver, problem: IkProblem, postures: list[Vector], rest: Vector
) -> None:
    ours, compiled = InverseKinematics(problem, interior), InverseKinematics(problem)
    for q in postures[:8]:
        target = pose_of(problem.tips[0], q)
        result = ours.solve([target], rest)
        assert result.status is IkStatus.CONVERGED
        assert result.position_error_m < WITHIN_M
        assert problem.limits.violation(result.q_rad) <= 0.0
        other = compiled.solve([target], rest)
        assert result.objective == pytest.approx(other.objective, abs=1e-4, rel=0.01)


def test_out_of_reach_ends_where_no_small_change_comes_nearer(
    interior: InteriorSolver, problem: IkProblem, home: Vector
) -> None:
    solver, limits, tip = InverseKinematics(problem, interior), problem.limits, problem.tips[0]
    for direction in np.eye(3):
        target = moved(pose_of(tip, home), direction)
        result = solver.solve([target], home)
        assert result.status is IkStatus.INFEASIBLE
        assert limits.violation(result.q_rad) <= 0.0
        nearer = minimize(
            lambda q, x=target.position_m: float(np.linalg.norm(tip.pose(q)[1] - x)),
            result.q_rad,
            method="SLSQP",
            bounds=list(zip(limits.lower_rad, limits.upper_rad, strict=True)),
            constraints=LinearConstraint(limits.rows, limits.lower[10:], limits.upper[10:]),
        )
        assert result.position_error_m < float(nearer.fun) + 2e-4


def test_position_is_kept_where_the_orientation_is_out_of_reach(
    interior: InteriorSolver, problem: IkProblem, home: Vector
) -> None:
    """The slack is taken away: with it alone the hand would be a few tenths of a mm off."""
    R, p = problem.tips[0].pose(home)
    solver = InverseKinematics(problem, interior)
    for turn in np.eye(3):
        result = solver.solve([TipTarget(p, matrix(2.5 * turn) @ R)], home, starts=1)
        assert result.status is IkStatus.CONVERGED
        assert result.position_error_m < WITHIN_M
        assert result.orientation_error_rad > 0.1


def test_both_hands_meet_their_poses_and_one_alone_leaves_the_other_arm_at_rest(
    interior: InteriorSolver, both_arms: IkProblem
) -> None:
    start = both_arms.limits.project(both_arms.rest_rad)
    targets = []
    for tip, side in zip(both_arms.tips, (1.0, -1.0), strict=True):
        targets.append(moved(pose_of(tip, start), np.array([-0.05, 0.03 * side, 0.04])))
    solver = InverseKinematics(both_arms, interior)
    result = solver.solve(targets, start)
    assert result.status is IkStatus.CONVERGED
    assert result.orientation_error_rad < math.radians(5.0)
    alone = solver.solve([None, targets[1]], start)
    assert alone.status is IkStatus.CONVERGED
    assert alone.q_rad[3:10] == pytest.approx(both_arms.rest_rad[3:10], abs=5e-3)


def test_orientation_comes_first_where_it_has_priority(
    interior: InteriorSolver, problem: IkProblem, home: Vector
) -> None:
    far = moved(pose_of(problem.tips[0], home), np.array([-0.5, 0.0, 0.0]))
    first = problem.changed(priority=Priority.ORIENTATION)
    result = InverseKinematics(first, interior).solve([far], home)
    assert result.status is IkStatus.CONVERGED
    assert result.orientation_error_rad < 1.001e-3
    assert result.position_error_m > 0.1


def test_blocked_joints_stay_and_the_next_search_is_as_before(
    interior: InteriorSolver, problem: IkProblem, home: Vector, rest: Vector
) -> None:
    """fatrop's plug-in would forget its settings here, and take a thousand iterations."""
    target = moved(pose_of(problem.tips[0], home), np.array([0.0, 0.03, 0.03]))
    solver = InverseKinematics(problem, interior)
    before = solver.solve([target], rest)
    free = np.array([False] * 3 + [True] * 7)
    solver.change(problem.changed(free=free))
    blocked = solver.solve([target], home)
    assert blocked.status is IkStatus.CONVERGED
    assert blocked.q_rad[:3] == pytest.approx(home[:3], abs=1e-8)
    solver.change(problem)
    after = solver.solve([target], rest)
    assert np.array_equal(after.q_rad, before.q_rad)
    assert after.iterations == before.iterations


def test_nothing_is_built_for_another_rest_tip_priority_or_limit(
    interior: InteriorSolver, problem: IkProblem, home: Vector, rest: Vector
) -> None:
    tip = problem.tips[0].attached(matrix(np.array([0.3, 0.2, -0.4])), [0.02, -0.03, 0.05])
    solver = InverseKinematics(problem, interior)
    solver.solve([pose_of(problem.tips[0], home)], rest)
    built = len(interior._kept)
    solver.change(problem.changed(tips=(tip,), rest_rad=home, beta=0.1))
    result = solver.solve([pose_of(tip, home)], rest)
    assert result.status is IkStatus.CONVERGED
    assert result.q_rad == pytest.approx(home, abs=0.02)
    solver.change(problem.changed(priority=Priority.ORIENTATION))
    solver.solve([pose_of(problem.tips[0], home)], rest)
    assert len(interior._kept) == built


def test_a_part_that_does_not_matter_costs_nothing(
    interior: InteriorSolver, problem: IkProblem, home: Vector, rest: Vector
) -> None:
    solver, whole = InverseKinematics(problem, interior), pose_of(problem.tips[0], home)
    assert whole.position_m is not None
    there = solver.solve([TipTarget(whole.position_m + np.array([0.0, 0.0, 0.05]), None)], rest)
    assert there.status is IkStatus.CONVERGED
    assert there.objective < 0.003
    turned = solver.solve([TipTarget(None, whole.rotation)], rest)
    assert turned.status is IkStatus.CONVERGED
    assert whole.rotation is not None
    R, _ = problem.tips[0].pose(turned.q_rad)
    assert angle_between(R, whole.rotation) < math.radians(1.0)


def test_a_stream_is_followed_without_jumps(
    interior: InteriorSolver, problem: IkProblem, home: Vector
) -> None:
    solver, target = InverseKinematics(problem, interior), pose_of(problem.tips[0], home)
    q = solver.solve([target], home).q_rad
    for tick in range(20):
        step = moved(target, np.array([0.0, 0.003 * tick, 0.003 * tick]))
        result = solver.track([step], q)
        assert result.status is IkStatus.CONVERGED
        assert np.abs(result.q_rad - q).max() < math.radians(2.0)
        q = result.q_rad


def test_a_budget_that_is_no_search_gives_the_start(
    interior: InteriorSolver, problem: IkProblem, postures: list[Vector], rest: Vector
) -> None:
    target = pose_of(problem.tips[0], postures[0])
    result = InverseKinematics(problem, interior).solve([target], rest, budget=5)
    assert result.status is IkStatus.OUT_OF_TIME
    assert np.array_equal(result.q_rad, rest)


class Ceiling:
    """The elbow stays below an angle; written out as well."""

    size = 1
    ELBOW = 6

    def __init__(self, upper_rad: float) -> None:
        self._upper_rad = upper_rad

    def evaluate(self, q_rad: Vector) -> tuple[Vector, Matrix]:
        J = np.zeros((1, len(q_rad)))
        J[0, self.ELBOW] = -1.0
        return np.array([self._upper_rad - q_rad[self.ELBOW]]), J

    def symbolic(self, q: ca.SX) -> ca.SX:
        return self._upper_rad - q[self.ELBOW]


class OnlyNumbers:
    size = 1

    def evaluate(self, q_rad: Vector) -> tuple[Vector, Matrix]:
        return np.ones(1), np.zeros((1, len(q_rad)))


def test_plugged_in_constraints_are_kept(
    interior: InteriorSolver, problem: IkProblem, home: Vector
) -> None:
    target = pose_of(problem.tips[0], home)
    bent = problem.changed(extra=Ceiling(math.radians(40.0)))
    result = InverseKinematics(bent, interior).solve([target], home)
    assert result.status is IkStatus.CONVERGED
    assert result.q_rad[Ceiling.ELBOW] <= math.radians(40.0) + 1e-6


def test_constraints_without_an_expression_are_refused(
    interior: InteriorSolver, problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    solver = InverseKinematics(problem.changed(extra=OnlyNumbers()), interior)
    with pytest.raises(NotSymbolicError, match="OnlyNumbers"):
        solver.solve([pose_of(Tip("hand", model), home)], home)
    assert issubclass(NotSymbolicError, DforcError)
