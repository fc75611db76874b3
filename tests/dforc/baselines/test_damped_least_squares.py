"""Damped least squares: its time course in a gantry, its damping, and what it does to rows."""

import math

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.baselines.damped_least_squares import DampedLeastSquares, DampedParams
from dforc.errors import NotFiniteError
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.experiments.cartesian.metrics import judge_move

PERIOD_S = 0.01
GOAL = np.array([0.2, -0.1, 0.05])


class Gantry:
    """Three rails and three turns about the base axes: a unit Jacobian near no turn."""

    n = 6

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        return np.eye(3), q_rad[:3].copy()

    def tip_jacobian(self, q_rad: Vector) -> Matrix:  # noqa: ARG002
        return np.eye(6)


@pytest.fixture
def box() -> JointLimits:
    return JointLimits.make([-1.0] * 6, [1.0] * 6)


def run(dls: DampedLeastSquares, q: Vector, p: Vector, R: Matrix, periods: int) -> Matrix:
    """References of every period, the start first."""
    state = dls.start(q)
    references = [q]
    for _ in range(periods):
        state = dls.step(state, p, R)
        references.append(state.q_ref_rad)
    return np.array(references)


def test_with_little_damping_the_error_falls_as_one_over_e_per_second(box: JointLimits) -> None:
    params = DampedParams(largest_damping=1e-5)
    q = run(DampedLeastSquares(Gantry(), box, params), np.zeros(6), GOAL, np.eye(3), 100)
    left = 1.0 - q[-1, :3] / GOAL
    assert left == pytest.approx([0.99**100] * 3, rel=1e-6)


def test_the_damping_shrinks_while_the_error_falls_and_grows_when_it_rises(
    box: JointLimits,
) -> None:
    dls = DampedLeastSquares(Gantry(), box)
    first = dls.start(np.zeros(6))
    nearer = dls.step(first, GOAL, np.eye(3))
    assert nearer.damping == pytest.approx(9.0)  # 0.229 m is less than the first comparison's 1
    farther = dls.step(nearer, 2.0 * GOAL, np.eye(3))
    assert farther.damping == pytest.approx(9.9)
    assert first.damping == 10.0
    assert nearer.dq_ref_rad_s[:3] == pytest.approx(GOAL / 101.0)  # e / (1 + d^2)


def test_a_joint_outside_its_safe_middle_is_pulled_back_where_the_task_leaves_room(
    model: RobotModel, limits: JointLimits, home: Vector
) -> None:
    q = home.copy()
    q[9] = limits.upper_rad[9] - 0.001  # wrist yaw
    R, p = model.tip_pose(q)
    moved = run(DampedLeastSquares(model, limits), q, p, R, 1000)
    assert moved[-1, 9] < q[9] - math.radians(0.1)
    assert np.linalg.norm(model.tip_pose(moved[-1])[1] - p) < 0.002


def test_stops_a_joint_whose_next_step_would_leave_its_range(box: JointLimits) -> None:
    q = run(
        DampedLeastSquares(Gantry(), box), np.zeros(6), np.array([1.5, 0.0, 0.0]), np.eye(3), 900
    )
    assert 0.95 < q[:, 0].max() <= 1.0


def test_crosses_rows_of_the_shoulder_it_does_not_know_and_takes_its_time(
    model: RobotModel, limits: JointLimits, postures: list[Vector]
) -> None:
    dls = DampedLeastSquares(model, limits)
    worst, times, peaks = 0.0, [], []
    for start, goal in zip(postures[0:20:2], postures[1:20:2], strict=True):
        R, p = model.tip_pose(goal)
        q = run(dls, start, p, R, 900)
        assert (q >= limits.lower_rad).all()
        assert (q <= limits.upper_rad).all()
        worst = max(worst, *(limits.violation(one) for one in q))
        hand = np.array([model.tip_pose(one)[1] for one in q])
        found = judge_move(hand, hand[0], p, PERIOD_S)
        times.append(found.t98_s)
        peaks.append(found.peak_share)
    assert math.degrees(worst) > 2.0
    assert np.median(times) == pytest.approx(4.3, abs=0.8)
    assert np.median(peaks) < 0.2


def test_a_joint_without_range_stays(
    model: RobotModel, limits: JointLimits, home: Vector, postures: list[Vector]
) -> None:
    lower, upper = limits.lower_rad.copy(), limits.upper_rad.copy()
    lower[:3] = upper[:3] = 0.0
    goal = postures[0].copy()
    goal[:3] = 0.0
    R, p = model.tip_pose(goal)
    q = run(DampedLeastSquares(model, JointLimits.make(lower, upper)), home, p, R, 200)
    assert (q[:, :3] == 0.0).all()
    assert np.abs(q[-1, 3:] - home[3:]).max() > 0.05


def test_refuses_a_target_that_is_not_finite(box: JointLimits) -> None:
    dls = DampedLeastSquares(Gantry(), box)
    with pytest.raises(NotFiniteError):
        dls.step(dls.start(np.zeros(6)), [0.0, math.inf, 0.0], np.eye(3))
