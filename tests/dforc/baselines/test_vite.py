"""VITE: its own time course in a gantry, and on the iCub's arm."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.baselines.vite import VelocityLoop, Vite, ViteParams, ViteState
from dforc.errors import NotFiniteError
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.experiments.cartesian.metrics import judge_move

PERIOD_S = 0.01
W = 4.0  # rad/s: sqrt(8 * 2) per s of the gains of 2010


class Gantry:
    """A hand on three rails: joints and hand are the same thing."""

    n = 3

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        return np.eye(3), q_rad.copy()

    def tip_jacobian(self, q_rad: Vector) -> Matrix:  # noqa: ARG002
        return np.vstack([np.eye(3), np.zeros((3, 3))])


GOAL = np.array([0.2, -0.1, 0.05])


@pytest.fixture
def rails() -> JointLimits:
    return JointLimits.make([-1.0] * 3, [1.0] * 3)


def run(vite: Vite, q: Vector, goal_m: Vector, R: Matrix, q_goal: Vector, periods: int) -> Matrix:
    """References of every period, the start first."""
    state = vite.start(q)
    references = [q]
    for _ in range(periods):
        state = vite.step(state, goal_m, R, q_goal)
        references.append(state.q_ref_rad)
    return np.array(references)


def test_approaches_critically_damped_at_the_root_of_both_gains(rails: JointLimits) -> None:
    q = run(Vite(Gantry(), rails), np.zeros(3), GOAL, np.eye(3), GOAL, 300)
    at_s = np.arange(301) * PERIOD_S
    course = 1.0 - (1.0 + W * at_s) * np.exp(-W * at_s)
    assert q[:, 0] / GOAL[0] == pytest.approx(course, abs=0.03)  # by steps of 10 ms, not exactly
    assert np.linalg.norm(q[-1] - GOAL) < 1e-4


def test_is_fastest_after_a_sixth_of_its_time_and_jerks_at_the_onset(rails: JointLimits) -> None:
    q = run(Vite(Gantry(), rails), np.zeros(3), GOAL, np.eye(3), GOAL, 400)
    found = judge_move(q, q[0], GOAL, PERIOD_S)
    assert found.t98_s == pytest.approx(5.834 / W, abs=0.05)
    assert found.peak_share == pytest.approx(0.17, abs=0.02)
    assert 15.0 < found.jerk < 35.0
    assert found.perpendicular < 1e-9  # both generators agree: the line is straight


def test_a_velocity_loop_comes_behind_and_keeps_its_speed_limit(rails: JointLimits) -> None:
    slow = Vite(Gantry(), rails, ViteParams(loop=VelocityLoop(speed_limit_rad_s=0.1)))
    q = run(slow, np.zeros(3), GOAL, np.eye(3), GOAL, 600)
    assert np.abs(np.diff(q, axis=0)).max() == pytest.approx(0.1 * PERIOD_S, rel=1e-9)
    assert np.linalg.norm(q[-1] - GOAL) < 1e-4


def test_stops_at_the_end_of_a_range(rails: JointLimits) -> None:
    beyond = np.array([1.5, 0.0, 0.0])
    q = run(Vite(Gantry(), rails), np.zeros(3), beyond, np.eye(3), beyond, 400)
    assert q[:, 0].max() <= 1.0
    assert q[-1, 0] == pytest.approx(1.0, abs=1e-6)


def test_reaches_poses_of_the_arm_and_never_leaves_its_joint_ranges(
    model: RobotModel, limits: JointLimits, postures: list[Vector]
) -> None:
    vite = Vite(model, limits)
    for start, goal in zip(postures[0:10:2], postures[1:10:2], strict=True):
        R, p = model.tip_pose(goal)
        q = run(vite, start, p, R, goal, 600)
        assert (q >= limits.lower_rad - 1e-12).all()
        assert (q <= limits.upper_rad + 1e-12).all()
        assert np.linalg.norm(model.tip_pose(q[-1])[1] - p) < 1e-4


def test_a_joint_without_range_stays(
    model: RobotModel, limits: JointLimits, home: Vector, postures: list[Vector]
) -> None:
    lower, upper = limits.lower_rad.copy(), limits.upper_rad.copy()
    lower[:3] = upper[:3] = 0.0
    vite = Vite(model, JointLimits.make(lower, upper))
    goal = postures[0].copy()
    goal[:3] = 0.0
    R, p = model.tip_pose(goal)
    q = run(vite, home, p, R, goal, 600)
    assert (q[:, :3] == 0.0).all()
    assert np.linalg.norm(model.tip_pose(q[-1])[1] - p) < 1e-4


def test_refuses_a_target_that_is_not_finite(rails: JointLimits) -> None:
    vite = Vite(Gantry(), rails)
    state: ViteState = vite.start(np.zeros(3))
    with pytest.raises(NotFiniteError):
        vite.step(state, [np.nan, 0.0, 0.0], np.eye(3), GOAL)
