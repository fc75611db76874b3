"""The law of the papers and of the iCub's own controller, by its numbers."""

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget
from dforc.ik.problem import Tip
from dforc.limits import JointLimits

PERIOD_S = 0.01
POLE = 5.3223  # triple, over T
STIFF = (False,) * 10
Move = tuple[Vector, Vector]


def by_reference(
    tip: Tip, limits: JointLimits, time_s: float = 1.0, gamma: float | None = None
) -> CartesianController:
    params = CartesianParams(
        law=Law.REFERENCE, trajectory_time_s=time_s, coupling=CouplingParams(gamma=gamma)
    )
    return CartesianController([tip], limits, params)


def plan(controller: CartesianController, q_start: Vector, targets: list[ReachTarget]) -> Matrix:
    """Plan's postures at 0, 1, 2, ... periods."""
    state, path = controller.start(q_start), [q_start]
    for target in targets:
        measured = Measurement(q_rad=state.q_plan, compliant=STIFF)
        state, _ = controller.step(state, measured, target)
        path.append(state.q_plan)
    return np.array(path)


def triple_pole(t: Vector) -> Vector:
    """Unit step response."""
    x = POLE * t
    return 1.0 - (1.0 + x + 0.5 * x * x) * np.exp(-x)


@pytest.mark.parametrize("time_s", [0.6, 1.0, 2.0])
def test_joints_answer_a_step_with_the_triple_pole(
    tip: Tip, limits: JointLimits, home: Vector, time_s: float
) -> None:
    goal = home.copy()
    goal[6] += 0.4
    periods = round(2.0 * time_s / PERIOD_S)
    target = ReachTarget(tips=[None], q_rad=goal)
    path = plan(by_reference(tip, limits, time_s), home, [target] * periods)
    share = (path[:, 6] - home[6]) / 0.4
    times: Vector = np.arange(periods + 1, dtype=np.float64) * PERIOD_S / time_s
    assert share == pytest.approx(triple_pole(times), abs=0.004)
    assert float(np.interp(1.0, times, share)) == pytest.approx(0.90, abs=0.004)
    assert float(np.interp(0.98, share, times)) == pytest.approx(1.412, rel=0.01)
    assert share.max() < 1.0 + 1e-3


def test_joints_trail_a_ramp_by_0_564_of_the_trajectory_time(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    ramp = np.zeros(10)
    ramp[6] = 0.1
    targets = [
        ReachTarget(tips=[None], q_rad=home + ramp * period * PERIOD_S) for period in range(400)
    ]
    path = plan(by_reference(tip, limits), home, targets)
    lag = home + ramp * 399 * PERIOD_S - path[399]
    assert lag[6] == pytest.approx(0.564 * 0.1, rel=0.01)


def test_hand_trails_a_moving_target_by_0_564_of_the_trajectory_time(
    tip: Tip, limits: JointLimits, home: Vector
) -> None:
    """At a large gamma the hand follows its own generator."""
    R, p = tip.pose(home)
    velocity = np.array([0.0, 0.02, 0.03])
    poses = [
        PoseTarget(position_m=p + velocity * period * PERIOD_S, rotation=R) for period in range(350)
    ]
    targets = [ReachTarget(tips=[pose], q_rad=home) for pose in poses]
    path = plan(by_reference(tip, limits, gamma=1e5), home, targets)
    lag = p + velocity * 349 * PERIOD_S - tip.pose(path[349])[1]
    assert lag == pytest.approx(0.564 * velocity, rel=0.03, abs=1e-4)


def test_path_is_bent_at_the_default_gamma_and_straight_at_a_large_one(
    tip: Tip, limits: JointLimits, moves: list[Move]
) -> None:
    """Measured on iKin's law: 12.7 % in the median at 0.05, 0.6 % at 1000."""
    bent: dict[float | None, float] = {}
    for gamma in (None, 1000.0):
        across = []
        for q_start, q_goal in moves:
            R, p = tip.pose(q_goal)
            pose = PoseTarget(position_m=p, rotation=R)
            target = ReachTarget(tips=[pose], q_rad=q_goal)
            path = plan(by_reference(tip, limits, gamma=gamma), q_start, [target] * 200)
            positions = np.array([tip.pose(q)[1] for q in path])
            way, gone = p - positions[0], positions - positions[0]
            share = gone @ way / (way @ way)
            off = np.linalg.norm(gone - np.outer(share, way), axis=1).max()
            across.append(off / np.linalg.norm(way))
        bent[gamma] = float(np.median(across))
    assert 0.05 < bent[None] < 0.3
    assert bent[1000.0] < 0.02


def test_rows_are_kept_where_the_law_alone_would_cross_them(
    tip: Tip, limits: JointLimits, moves: list[Move]
) -> None:
    alone = JointLimits.make(limits.lower_rad, limits.upper_rad)
    crossed, kept = 0.0, 0.0
    for q_start, q_goal in moves:
        R, p = tip.pose(q_goal)
        target = ReachTarget(tips=[PoseTarget(position_m=p, rotation=R)], q_rad=q_goal)
        for within in (alone, limits):
            path = plan(by_reference(tip, within, gamma=100.0), q_start, [target] * 150)
            outside = max(limits.violation(q) for q in path)
            if within is alone:
                crossed = max(crossed, outside)
            else:
                kept = max(kept, outside)
    assert crossed > np.radians(0.5)
    assert kept <= 1e-8


@pytest.mark.parametrize("gamma", [None, 1000.0])
def test_short_time_stretches_until_no_joint_is_too_fast(
    tip: Tip, limits: JointLimits, moves: list[Move], gamma: float | None
) -> None:
    """With T 0.1 s the law alone would ask for 20 rad/s."""
    controller = by_reference(tip, limits, 0.1, gamma)
    for q_start, q_goal in moves[:4]:
        R, p = tip.pose(q_goal)
        target = ReachTarget(tips=[PoseTarget(position_m=p, rotation=R)], q_rad=q_goal)
        path = plan(controller, q_start, [target] * 800)
        assert np.abs(np.diff(path, axis=0)).max() <= 1.75 * PERIOD_S + 1e-12
        assert max(limits.violation(q) for q in path) <= 1e-9
        assert np.linalg.norm(tip.pose(path[-1])[1] - p) < 1e-3
