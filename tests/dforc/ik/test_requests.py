"""What inverse kinematics is asked: changes between two answers, and what is refused."""

import math

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from dforc.errors import LimitsError, NotFiniteError, ShapeError
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

TOLERANCE_M = 1.001e-4
BETA = 0.01


def pose(
    model: RobotModel, q: Vector, moved_m: tuple[float, float, float] = (0, 0, 0)
) -> TipTarget:
    R, p = model.tip_pose(q)
    return TipTarget.checked(p + np.array(moved_m), R)


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
