"""Inverse kinematics: answers, statuses, limits on every exit, continuity while tracking."""

import math

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from dforc import rotation
from dforc.arrays import Matrix, Vector
from dforc.errors import LimitsError, NotFiniteError, ShapeError
from dforc.ik import IkResult, IkSettings, IkStatus, InverseKinematics
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

TOLERANCE_M = 1.001e-4
BETA = 0.01


@pytest.fixture(scope="module")
def built(
    model: RobotModel, limits: JointLimits, rest: Vector, rest_weights: Vector
) -> InverseKinematics:
    return InverseKinematics(model, limits, rest, rest_weights)


@pytest.fixture
def solver(
    built: InverseKinematics, limits: JointLimits, rest: Vector, rest_weights: Vector
) -> InverseKinematics:
    """As built: whatever a test changed is set back."""
    built.set_limits(limits)
    built.set_rest(rest, rest_weights)
    return built


def cost(model: RobotModel, q: Vector, R: Matrix, rest: Vector, weights: Vector) -> float:
    """Eq. 11's cost, with the model's kinematics."""
    angle = rotation.angle_between(model.tip_pose(q)[0], R)
    return angle**2 + BETA * float(weights @ (q - rest) ** 2)


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


def test_reachable_poses_are_met_within_all_limits(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    for q in postures[:25]:
        R, p = model.tip_pose(q)
        result = solver.solve(p, R, rest)
        assert result.status is IkStatus.CONVERGED
        assert np.linalg.norm(model.tip_pose(result.q_rad)[1] - p) < TOLERANCE_M
        assert result.orientation_error_rad < math.radians(1.0)
        assert limits.violation(result.q_rad) <= 0.0


def test_answer_costs_no_more_than_the_posture_that_made_the_pose(
    solver: InverseKinematics,
    model: RobotModel,
    rest: Vector,
    rest_weights: Vector,
    postures: list[Vector],
) -> None:
    for q in postures[:15]:
        R, p = model.tip_pose(q)
        result = solver.solve(p, R, q)
        ours = cost(model, result.q_rad, R, rest, rest_weights)
        assert ours <= cost(model, q, R, rest, rest_weights) + 1e-9


def test_tracking_stays_converged_in_a_few_steps_without_jumps(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, centre = model.tip_pose(home)
    q, results = home, list[IkResult]()
    for point in lemniscate(centre, 0.1, 300):
        result = solver.solve(point, R, q, math.radians(5.0))
        if results:  # the first goes to the optimal posture for the pose of the start
            assert np.abs(result.q_rad - q).max() < math.radians(3.0)
        q = result.q_rad
        results.append(result)
    assert {result.status for result in results} == {IkStatus.CONVERGED}
    assert max(result.position_error_m for result in results) < TOLERANCE_M
    assert np.median([result.iterations for result in results]) <= 4


def test_following_gives_what_ipopt_gives(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    home: Vector,
    rest: Vector,
    rest_weights: Vector,
) -> None:
    R, centre = model.tip_pose(home)
    afresh = InverseKinematics(model, limits, rest, rest_weights)
    q = home
    for tick, point in enumerate(lemniscate(centre, 0.1, 100)):
        before, q = q, solver.solve(point, R, q).q_rad
        if tick % 10 == 9:
            afresh.reset()
            assert afresh.solve(point, R, before).q_rad == pytest.approx(q, abs=1e-5)


def test_position_out_of_reach_gives_the_nearest_posture_and_says_so(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    for direction in np.eye(3):
        target = p + 1.0 * direction
        result = solver.solve(target, R, home)
        assert result.status is IkStatus.INFEASIBLE
        assert limits.violation(result.q_rad) <= 0.0
        better = minimize(
            lambda q, x=target: float(np.linalg.norm(model.tip_pose(q)[1] - x)),
            result.q_rad,
            method="SLSQP",
            bounds=list(zip(limits.lower_rad, limits.upper_rad, strict=True)),
            constraints=LinearConstraint(limits.rows, limits.lower[10:], limits.upper[10:]),
            options={"maxiter": 200},
        )
        assert result.position_error_m < float(better.fun) + 2e-4


def test_target_leaves_the_reach_and_comes_back(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    away = [p + np.array([-x, 0.0, 0.0]) for x in np.linspace(0.0, 0.4, 80)]
    q, results = home, list[IkResult]()
    for point in away + away[::-1]:
        result = solver.solve(point, R, q, math.radians(5.0))
        assert np.abs(result.q_rad - q).max() <= math.radians(5.0) + 1e-12
        q = result.q_rad
        results.append(result)
    assert results[79].status is IkStatus.INFEASIBLE
    assert results[79].position_error_m > 0.05
    assert results[-1].status is IkStatus.CONVERGED
    assert sum(result.iterations > 30 for result in results) <= 1  # no long search every tick


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_refused_and_leaves_the_solver_as_it_was(
    solver: InverseKinematics, model: RobotModel, home: Vector, bad: float
) -> None:
    R, p = model.tip_pose(home)
    answer = solver.solve(p, R, home)
    spoilt = home.copy()
    spoilt[3] = bad
    for arguments in ((p * bad, R, home), (p, R * bad, home), (p, R, spoilt)):
        with pytest.raises(NotFiniteError):
            solver.solve(*arguments)
    with pytest.raises(NotFiniteError):
        solver.solve(p, R, home, math.nan)
    assert solver.solve(p, R, home) is answer


def test_unchanged_request_gets_the_same_answer_without_a_search(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    first = solver.solve(p + 0.02, R, home)
    assert solver.solve(p + 0.02, R, home) is first
    assert solver.solve(p + 0.02, R, first.q_rad) is first
    assert solver.solve(p + 0.02, R, first.q_rad, math.radians(1.0)) is first
    assert solver.solve(p + 0.021, R, first.q_rad) is not first


def test_answer_under_a_step_limit_is_improved_by_the_next_request(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    target, step = p + np.array([0.0, 0.0, 0.12]), math.radians(2.0)
    q, results = home, []
    for _ in range(60):
        result = solver.solve(target, R, q, step)
        assert np.abs(result.q_rad - q).max() <= step + 1e-12
        q = result.q_rad
        results.append(result)
    assert results[0].status is IkStatus.INFEASIBLE
    assert results[0].step_limited
    assert results[-1].status is IkStatus.CONVERGED
    assert not results[-1].step_limited


def test_blocked_joints_do_not_move_and_can_be_freed_again(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    start = home.copy()
    start[:3] = np.radians([5.0, 0.0, -5.0])
    blocked = [True] * 3 + [False] * 7
    result = solver.solve(p, R, start, blocked=blocked)
    assert result.status is IkStatus.CONVERGED
    assert np.array_equal(result.q_rad[:3], start[:3])
    assert not result.step_limited
    freed = solver.solve(p, R, result.q_rad)
    assert freed is not result
    assert not np.array_equal(freed.q_rad[:3], start[:3])


def test_changed_limits_hold_from_the_next_answer_on(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    free = solver.solve(p + np.array([-0.03, 0.0, 0.08]), R, home)
    upper = limits.upper_rad.copy()
    upper[6] = free.q_rad[6] - 0.1  # elbow
    narrow = JointLimits.make(
        limits.lower_rad, upper, limits.rows, limits.lower[10:], limits.upper[10:]
    )
    solver.set_limits(narrow)
    held = solver.solve(p + np.array([-0.03, 0.0, 0.08]), R, free.q_rad)
    assert held.q_rad[6] <= upper[6]
    with pytest.raises(LimitsError):
        solver.set_limits(JointLimits.make(limits.lower_rad, limits.upper_rad))


def test_changed_rest_posture_draws_the_elbow(
    solver: InverseKinematics, model: RobotModel, home: Vector, rest: Vector
) -> None:
    R, p = model.tip_pose(home)
    before = solver.solve(p, R, home)
    turned = rest.copy()
    turned[0] = 0.4
    solver.set_rest(turned, np.array([1.0] * 3 + [0.1] * 7))
    after = solver.solve(p, R, before.q_rad)
    assert after.q_rad[0] > before.q_rad[0] + 0.05
    with pytest.raises(LimitsError):
        solver.set_rest(rest, -np.ones(10))


def test_start_outside_the_limits_is_brought_inside(
    solver: InverseKinematics, model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    outside = home.copy()
    outside[3:5] = np.radians([-97.0, 20.0])
    result = solver.solve(p, R, outside, math.radians(5.0))
    assert limits.violation(result.q_rad) <= 0.0


def test_iteration_cap_is_reported_and_its_answer_is_safe(
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    rest_weights: Vector,
    postures: list[Vector],
) -> None:
    hurried = InverseKinematics(model, limits, rest, rest_weights, IkSettings(iteration_cap=2))
    for q in postures[:10]:
        R, p = model.tip_pose(q)
        start = rest
        result = hurried.solve(p, R, start)
        assert result.status is IkStatus.OUT_OF_TIME
        assert limits.violation(result.q_rad) <= 1e-9
        assert result.position_error_m <= np.linalg.norm(model.tip_pose(start)[1] - p) + 1e-12


def test_what_is_no_rotation_is_refused(
    solver: InverseKinematics, model: RobotModel, home: Vector
) -> None:
    R, p = model.tip_pose(home)
    for wrong in (R * 1.01, -R, R[:2]):
        with pytest.raises(ShapeError):
            solver.solve(p, wrong, home)


def test_every_answer_to_hostile_requests_is_finite_and_inside_everything(
    solver: InverseKinematics,
    model: RobotModel,
    limits: JointLimits,
    home: Vector,
    postures: list[Vector],
) -> None:
    rng = np.random.default_rng(9)
    q = home
    for _ in range(150):
        far = rng.normal(size=3) * 10.0 ** rng.uniform(-2.0, 5.0)
        position = (far, model.tip_pose(q)[1] + far * 0.01)[rng.integers(2)]
        start = (q, q, rng.normal(size=10) * 3.0, postures[rng.integers(60)])[rng.integers(4)]
        step = (math.inf, 0.1, 0.0)[rng.integers(3)]
        blocked = rng.random(10) < 0.2
        R = rotation.matrix(rng.normal(size=3) * 3.0)
        result = solver.solve(position, R, start, step, list(blocked))
        q = result.q_rad
        begun = limits.project(start)
        assert np.isfinite(q).all()
        assert limits.violation(q) <= 1e-9
        assert (np.abs(q - begun) <= step + 1e-9).all()
        assert np.abs(q - begun)[blocked].max(initial=0.0) <= 1e-12
