"""Inverse kinematics: answers, statuses, limits on every exit."""

import math

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from dforc import rotation
from dforc.arrays import Vector
from dforc.errors import LimitsError, NotFiniteError, ShapeError
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


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_refused(
    solver: InverseKinematics, model: RobotModel, home: Vector, bad: float
) -> None:
    target = pose(model, home)
    assert target.position_m is not None
    assert target.rotation is not None
    spoilt = home.copy()
    spoilt[3] = bad
    for wrong in (
        TipTarget(target.position_m * bad, target.rotation),
        TipTarget(target.position_m, target.rotation * bad),
    ):
        with pytest.raises(NotFiniteError):
            solver.solve([wrong], home)
    with pytest.raises(NotFiniteError):
        solver.solve([target], spoilt)
    with pytest.raises(NotFiniteError):
        solver.solve([target], home, step_limit_rad=math.nan)


def test_what_is_no_rotation_is_refused(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    for wrong in (R * 1.01, -R, R[:2], np.zeros((3, 3))):
        with pytest.raises(ShapeError):
            solver.solve([TipTarget(p, wrong)], home)
    with pytest.raises(ShapeError, match="2 targets for 1 tips"):
        solver.solve([None, None], home)


def test_blocked_joints_do_not_move_and_can_be_freed_again(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    start = home.copy()
    start[:3] = np.radians([5.0, 0.0, -5.0])
    solver = InverseKinematics(problem.changed(free=[False] * 3 + [True] * 7))
    result = solver.solve([pose(model, home)], start)
    assert result.status is IkStatus.CONVERGED
    assert np.array_equal(result.q_rad[:3], start[:3])
    assert not result.step_limited
    solver.change(problem)
    freed = solver.solve([pose(model, home)], result.q_rad)
    assert not np.array_equal(freed.q_rad[:3], start[:3])


def test_all_joints_blocked_stay_and_say_how_far_away_the_pose_is(
    problem: IkProblem, model: RobotModel, home: Vector
) -> None:
    solver = InverseKinematics(problem.changed(free=[False] * 10))
    away = solver.solve([pose(model, home, (0.0, 0.0, 0.05))], home)
    assert np.array_equal(away.q_rad, home)
    assert away.status is IkStatus.INFEASIBLE
    assert away.position_error_m == pytest.approx(0.05)
    there = solver.solve([pose(model, home)], home)
    assert there.status is IkStatus.CONVERGED


def test_changed_limits_rest_tip_and_tolerance_hold_from_the_next_answer_on(
    problem: IkProblem, model: RobotModel, limits: JointLimits, home: Vector, rest: Vector
) -> None:
    target = pose(model, home, (-0.03, 0.0, 0.08))
    solver = InverseKinematics(problem)
    first = solver.solve([target], home)
    upper = limits.upper_rad.copy()
    upper[6] = first.q_rad[6] - 0.1  # elbow
    rows = (limits.rows, limits.lower[10:], limits.upper[10:])
    solver.change(problem.changed(limits=JointLimits.make(limits.lower_rad, upper, *rows)))
    assert solver.solve([target], first.q_rad).q_rad[6] <= upper[6]
    turned = rest.copy()
    turned[0] = 0.4
    solver.change(problem.changed(rest_rad=turned))
    assert solver.solve([target], first.q_rad).q_rad[0] > first.q_rad[0] + 0.05
    offset = np.array([0.0, 0.0, 0.1])
    solver.change(problem.changed(tips=(problem.tips[0].attached(np.eye(3), offset),)))
    result = solver.solve([target], home)
    R, p = model.tip_pose(result.q_rad)
    assert p + R @ offset == pytest.approx(target.position_m, abs=TOLERANCE_M)
    solver.change(problem)
    assert solver.solve([target], home).q_rad == pytest.approx(first.q_rad, abs=1e-9)


def test_rest_posture_outside_the_limits_only_pulls(
    problem: IkProblem, limits: JointLimits, rest: Vector, home: Vector
) -> None:
    far = rest.copy()
    far[6] = 3.0  # the elbow ends at 106 degrees
    solver = InverseKinematics(problem.changed(rest_rad=far))
    result = solver.solve([None], home)
    assert result.status is IkStatus.CONVERGED
    assert limits.violation(result.q_rad) <= 0.0
    assert result.q_rad[6] == pytest.approx(limits.upper_rad[6], abs=1e-3)


def test_start_outside_the_limits_is_brought_inside(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    outside = home.copy()
    outside[3:5] = np.radians([-97.0, 20.0])
    result = solver.solve([pose(model, home)], outside, step_limit_rad=math.radians(5.0))
    assert limits.violation(result.q_rad) <= 1e-12
    inside = limits.project(outside)
    assert np.abs(result.q_rad - inside).max() <= math.radians(5.0) + 1e-9


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


def test_every_answer_to_hostile_requests_is_finite_and_inside_everything(
    problem: IkProblem,
    model: RobotModel,
    limits: JointLimits,
    home: Vector,
    postures: list[Vector],
) -> None:
    rng = np.random.default_rng(9)
    solver = InverseKinematics(problem)
    q = home
    for _ in range(150):
        far = rng.normal(size=3) * 10.0 ** rng.uniform(-2.0, 5.0)
        position = (far, model.tip_pose(q)[1] + far * 0.01)[rng.integers(2)]
        start = (q, q, rng.normal(size=10) * 3.0, postures[rng.integers(60)])[rng.integers(4)]
        step = (math.inf, 0.1, 0.0)[rng.integers(3)]
        free = rng.random(10) > 0.2
        solver.change(problem.changed(free=free))
        target = TipTarget.checked(position, rotation.matrix(rng.normal(size=3) * 3.0))
        result = solver.solve([target], start, step_limit_rad=step)
        q = result.q_rad
        begun = limits.project(start)
        assert np.isfinite(q).all()
        assert limits.violation(q) <= 1e-9
        assert (np.abs(q - begun) <= step + 1e-9).all()
        assert np.abs(q - begun)[~free].max(initial=0.0) <= 1e-12


def test_what_does_not_fit_together_is_refused(problem: IkProblem, rest: Vector) -> None:
    with pytest.raises(LimitsError, match="must not be negative"):
        problem.changed(rest_weights=-np.ones(10))
    with pytest.raises(ShapeError):
        problem.changed(rest_rad=rest[:9])
    with pytest.raises(ShapeError):
        problem.changed(free=[True] * 9)
    with pytest.raises(NotFiniteError):
        problem.changed(beta=math.nan)
    with pytest.raises(NotFiniteError):
        problem.changed(position_tolerance_m=0.0)
    with pytest.raises(ValueError, match="sideways"):
        problem.changed(priority="sideways")
    with pytest.raises(ShapeError, match="no tip"):
        problem.changed(tips=())


def test_steps_of_another_number_of_joints_are_refused(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    with pytest.raises(ShapeError, match=r"\(9,\), expected \(10,\)"):
        solver.track([pose(model, home)], home, step_limit_rad=np.ones(9))


def test_joints_without_an_end_have_other_starts_too(problem: IkProblem, home: Vector) -> None:
    endless = JointLimits.make([-np.inf] * 10, [*[np.inf] * 5, *problem.limits.upper_rad[5:]])
    bounds = SearchBounds(endless.lower, endless.upper)
    starts = list(starts_of(problem.changed(limits=endless), home, bounds))
    assert len(starts) > 5
    assert np.abs(np.array(starts) - home).max() < 4.0 * np.pi
