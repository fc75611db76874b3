"""What may change in motion changes no speed abruptly: goal, T, joints, tip, law, mode, stop."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import CartesianParams, CouplingParams, Law
from dforc.cartesian.state import CartesianState, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget, SpeedTarget, Target, TipSpeed
from dforc.errors import ShapeError
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import Tip, TipTarget
from dforc.limits import JointLimits
from dforc.rotation import angle_between, matrix

PERIOD_S = 0.01
PARAMS = CartesianParams(trajectory_time_s=1.0, coupling=CouplingParams(speed_limit_rad_s=6.0))
STIFF = (False,) * 10
HALF = 50  # periods
ARM_ONLY = (False,) * 3 + (True,) * 7

Under = tuple[CartesianController, CartesianState, Target | None]
Change = Callable[[CartesianController, CartesianState, Target | None], Under]


def to_posture(tip: Tip, q: Vector) -> ReachTarget:
    R, p = tip.pose(q)
    return ReachTarget(tips=[PoseTarget(position_m=p, rotation=R)], q_rad=q)


def by_arm(tip: Tip, solver: InverseKinematics, goal: Vector, q_start: Vector) -> Vector:
    """Posture for the goal's pose with the torso as at the start."""
    arm = InverseKinematics(solver.problem.changed(free=np.array(ARM_ONLY)))
    R, p = tip.pose(goal)
    return arm.solve([TipTarget.checked(p, R)], q_start).q_rad


@pytest.fixture
def goals(tip: Tip, solver: InverseKinematics, home: Vector) -> tuple[Vector, Vector]:
    """Postures of two poses that lie 20 and 16 cm from home, to different sides."""
    R, start = tip.pose(home)
    turned = matrix([0.0, 0.3, 0.2]) @ R
    found = [
        solver.solve([TipTarget.checked(start + way, turned)], home).q_rad
        for way in (np.array([-0.06, 0.1, 0.16]), np.array([-0.08, -0.08, 0.11]))
    ]
    return found[0], found[1]


def ride(
    tip: Tip, limits: JointLimits, home: Vector, goal: Vector, change: Change, periods: int = 250
) -> tuple[Matrix, Matrix, CartesianState]:
    """Positions of the hand and joint speeds of a move that is changed at half time."""
    controller = CartesianController([tip], limits, PARAMS)
    state, target = controller.start(home), to_posture(tip, goal)
    asked: Target | None = target
    positions, speeds = [], []
    for period in range(periods):
        if period == HALF:
            controller, state, asked = change(controller, state, target)
        state, output = controller.step(
            state, Measurement(q_rad=state.q_plan, compliant=STIFF), asked
        )
        positions.append(tip.pose(output.plan_q_rad)[1])
        speeds.append(output.dq_rad_s)
    return np.array(positions), np.array(speeds), state


def largest_steps(positions: Matrix) -> tuple[float, float]:
    """Of the hand's speed from the change on, and of its acceleration at the change; shares."""
    velocity = np.diff(positions, axis=0) / PERIOD_S
    acceleration = np.diff(velocity, axis=0) / PERIOD_S
    peak = np.linalg.norm(velocity, axis=1).max()
    steps = np.linalg.norm(np.diff(velocity, axis=0), axis=1) / peak
    jumps = np.linalg.norm(np.diff(acceleration, axis=0), axis=1)
    most = np.linalg.norm(acceleration, axis=1).max()
    return float(steps[HALF - 4 :].max()), float(jumps[HALF - 4 : HALF + 3].max() / most)


def changes(tip: Tip, solver: InverseKinematics, goals: tuple[Vector, Vector]) -> dict[str, Change]:
    """Every kind of change."""

    def switched(
        controller: CartesianController, state: CartesianState, target: Target | None
    ) -> Under:
        return controller, controller.take_over(state), target

    def blocked(
        controller: CartesianController,
        state: CartesianState,
        target: Target | None,  # noqa: ARG001
    ) -> Under:
        controller = controller.changed(free=ARM_ONLY)
        found = by_arm(tip, solver, goals[0], controller.resting_posture(state))
        return switched(controller, state, to_posture(tip, found))

    def tool(
        controller: CartesianController,
        state: CartesianState,
        target: Target | None,  # noqa: ARG001
    ) -> Under:
        longer = tip.attached(matrix([0.3, 0.5, -0.2]), [0.05, 0.02, 0.1])
        controller = controller.changed(tips=[longer])
        return switched(controller, state, to_posture(longer, goals[0]))

    def law(controller: CartesianController, state: CartesianState, target: Target | None) -> Under:
        return switched(
            controller.changed(params=replace(PARAMS, law=Law.REFERENCE)), state, target
        )

    def slower(
        controller: CartesianController, state: CartesianState, target: Target | None
    ) -> Under:
        slow = replace(PARAMS, trajectory_time_s=1.5)
        return switched(controller.changed(params=slow), state, target)

    def quicker(
        controller: CartesianController, state: CartesianState, target: Target | None
    ) -> Under:
        quick = replace(PARAMS, trajectory_time_s=0.7)
        return switched(controller.changed(params=quick), state, target)

    hurried = TipSpeed(linear_m_s=(0.0, 0.1, 0.05))
    p = tip.pose(goals[0])[1]
    loose = ReachTarget(tips=[PoseTarget(position_m=p, rotation=None)], q_rad=goals[0])
    return {
        "goal": lambda c, s, t: (c, s, to_posture(tip, goals[1])),  # noqa: ARG005
        "slower": slower,
        "quicker": quicker,
        "blocked torso": blocked,
        "tool": tool,
        "law": law,
        "stop": lambda c, s, t: (c, s, None),  # noqa: ARG005
        "speed mode": lambda c, s, t: (c, s, SpeedTarget(tips=[hurried])),  # noqa: ARG005
        "orientation free": lambda c, s, t: (c, s, loose),  # noqa: ARG005
    }


@pytest.mark.parametrize(
    "kind",
    [
        "goal",
        "slower",
        "quicker",
        "blocked torso",
        "tool",
        "law",
        "stop",
        "speed mode",
        "orientation free",
    ],
)
def test_change_in_motion_steps_no_speed_by_5_percent_and_no_acceleration(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
    goals: tuple[Vector, Vector],
    kind: str,
) -> None:
    change = changes(tip, solver, goals)[kind]
    positions, speeds, _ = ride(tip, limits, home, goals[0], change)
    speed_step, acceleration_step = largest_steps(positions)
    assert speed_step <= 0.05
    assert acceleration_step <= 0.22  # 0.10 of minimum jerk's onset, 0.19 of the lag law's jerk
    joint_step = np.abs(np.diff(speeds[HALF - 2 : HALF + 3], axis=0)).max()
    assert joint_step < 0.06 * np.abs(speeds).max()


def test_blocked_joints_come_to_rest_where_the_plan_said_and_the_hand_arrives(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
    goals: tuple[Vector, Vector],
) -> None:
    resting = []

    def noting(
        controller: CartesianController, state: CartesianState, target: Target | None
    ) -> Under:
        resting.append(controller.resting_posture(state))
        return changes(tip, solver, goals)["blocked torso"](controller, state, target)

    _, speeds, state = ride(tip, limits, home, goals[0], noting)
    assert np.abs(speeds[HALF + 41 :, :3]).max() < 1e-6
    assert np.abs(speeds[HALF - 1, :3]).max() > 0.02  # they did move
    assert state.q_plan[:3] == pytest.approx(resting[0][:3], abs=1e-5)
    R, p = tip.pose(state.q_plan)
    R_goal, goal = tip.pose(by_arm(tip, solver, goals[0], resting[0]))
    assert np.linalg.norm(p - goal) < 5e-4
    assert angle_between(R, R_goal) < 0.005


def test_freed_joints_take_part_again_without_a_jolt(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
    goals: tuple[Vector, Vector],
) -> None:
    controller = CartesianController([tip], limits, PARAMS, ARM_ONLY)
    state, speeds = controller.start(home), []
    target = to_posture(tip, by_arm(tip, solver, goals[0], home))
    for period in range(260):
        if period == HALF:
            controller = controller.changed(free=(True,) * 10)
            state = controller.take_over(state)
            target = to_posture(tip, goals[0])
        state, output = controller.step(
            state, Measurement(q_rad=state.q_plan, compliant=STIFF), target
        )
        speeds.append(output.dq_rad_s)
    history = np.array(speeds)
    assert np.abs(history[:HALF, :3]).max() == 0.0
    assert np.abs(history[HALF:, :3]).max() > 0.02
    steps = np.abs(np.diff(history, axis=0)).max(axis=1)
    assert steps[HALF - 2 : HALF + 3].max() < 0.06 * np.abs(history).max()
    assert state.q_plan == pytest.approx(goals[0], abs=0.01)


def test_stop_in_motion_comes_to_rest_in_time_along_the_way(
    tip: Tip,
    limits: JointLimits,
    solver: InverseKinematics,
    home: Vector,
    goals: tuple[Vector, Vector],
) -> None:
    stop = changes(tip, solver, goals)["stop"]
    positions, speeds, _ = ride(tip, limits, home, goals[0], stop)
    assert np.abs(speeds[HALF + 40 :]).max() < 1e-6
    way = tip.pose(goals[0])[1] - tip.pose(home)[1]
    gone = positions - tip.pose(home)[1]
    share = gone @ way / (way @ way)
    assert np.linalg.norm(gone - np.outer(share, way), axis=1).max() < 0.01 * np.linalg.norm(way)
    speed = np.linalg.norm(positions[HALF - 1] - positions[HALF - 2]) / PERIOD_S
    ran_on = np.linalg.norm(positions[-1] - positions[HALF - 1])
    assert ran_on == pytest.approx(0.5 * PARAMS.stop_time_s * speed, rel=0.05)
    assert (np.diff(share) > -1e-6).all()


def test_plan_of_another_number_of_joints_is_not_taken_over(
    tip: Tip, limits: JointLimits, home: Vector, both_hands: tuple[tuple[Tip, Tip], JointLimits]
) -> None:
    hands, whole = both_hands
    state = CartesianController([tip], limits).start(home)
    with pytest.raises(ShapeError):
        CartesianController(hands, whole).take_over(state)


def test_narrower_limits_in_motion_are_entered_smoothly_and_kept(
    tip: Tip, limits: JointLimits, home: Vector, goals: tuple[Vector, Vector]
) -> None:
    """The elbow's range is cut to end 5 degrees before where it is."""
    controller = CartesianController([tip], limits, PARAMS)
    state, target, speeds = controller.start(home), to_posture(tip, goals[0]), []
    narrow = limits
    for period in range(300):
        if period == HALF:
            upper = limits.upper[:10].copy()
            upper[6] = state.q_plan[6] - np.radians(5.0)
            narrow = JointLimits.make(
                limits.lower[:10], upper, limits.rows, limits.lower[10:], limits.upper[10:]
            )
            controller = controller.changed(limits=narrow)
            state = controller.take_over(state)
        state, output = controller.step(
            state, Measurement(q_rad=state.q_plan, compliant=STIFF), target
        )
        speeds.append(output.dq_rad_s)
        if period > HALF + 100:
            assert narrow.violation(output.plan_q_rad) < 1e-8
    assert np.abs(np.diff(speeds, axis=0)).max() < 50.0 * PERIOD_S
