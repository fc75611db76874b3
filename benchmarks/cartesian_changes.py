"""Changes in motion: how far the hand's speed and acceleration step in one period."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.cartesian_moves import PERIOD_S, Move, params_of, reached
from dforc.arrays import Matrix, Vector
from dforc.cartesian.controller import CartesianController
from dforc.cartesian.params import Law
from dforc.cartesian.state import CartesianState, Measurement
from dforc.cartesian.targets import PoseTarget, ReachTarget, SpeedTarget, Target, TipSpeed
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import TipTarget
from dforc.rotation import matrix
from services.experiments.cartesian.arm import Arm
from services.experiments.rows import Row, at_most
from services.reaching.limb import limb_problem

PERIODS = 260
FIRST, LAST = 30, 70  # the change comes between these periods
STEP_BAR = 5.0  # %
ACCELERATION_BAR = 20.0  # %: minimum jerk from rest begins with 60 h / 5.8 T, 10 %

Under = tuple[CartesianController, CartesianState, Target | None]
Change = Callable[[CartesianController, CartesianState, Move], Under | None]


class Changes:
    """Every kind of change, for one arm."""

    def __init__(self, arm: Arm, draw: np.random.Generator) -> None:
        self._arm = arm
        self._draw = draw
        self._problem = limb_problem(arm.robot, arm.limb.name)
        self.kinds: dict[str, Change] = {
            "another goal": self.goal,
            "T 1.5 s": lambda c, s, m: self.time(c, s, m, 1.5),
            "T 0.8 s": lambda c, s, m: self.time(c, s, m, 0.8),
            "torso blocked": self.blocked,
            "tool attached": self.tool,
            "stop": lambda c, s, m: (c, s, None),  # noqa: ARG005
            "speed mode": self.speed,
            "orientation free": self.loose,
        }

    def goal(
        self,
        controller: CartesianController,
        state: CartesianState,
        move: Move,  # noqa: ARG002
    ) -> Under | None:
        """Another one, 12 to 41 cm from here."""
        arm = self._arm
        here = arm.pose(state.q_plan).position_m
        for _ in range(200):
            q = self._draw.uniform(arm.limits.lower_rad, arm.limits.upper_rad)
            pose = arm.pose(q)
            near = 0.12 <= np.linalg.norm(pose.position_m - here) <= 0.41
            if arm.limits.violation(q) < 0.0 and near:
                found = reached(arm, pose, state.q_plan)
                if found is None:
                    continue
                return controller, state, _target(arm, found.q_rad)
        return None

    def time(
        self, controller: CartesianController, state: CartesianState, move: Move, time_s: float
    ) -> Under:
        """Another T."""
        params = replace(controller.params, trajectory_time_s=time_s)
        controller = controller.changed(params=params)
        return controller, controller.take_over(state), move.target

    def blocked(
        self, controller: CartesianController, state: CartesianState, move: Move
    ) -> Under | None:
        """The torso comes to rest; None where the arm alone does not reach the goal."""
        torso = self._arm.robot.parts["torso"]
        free = np.array([joint not in torso for joint in self._arm.joints])
        controller = controller.changed(free=tuple(free.tolist()))
        state = controller.take_over(state)
        ik = InverseKinematics(self._problem.changed(free=free))
        goal = TipTarget.checked(move.goal.position_m, move.goal.rotation)
        found = ik.solve([goal], controller.resting_posture(state))
        if found.status is not IkStatus.CONVERGED or found.orientation_error_rad > 1e-3:
            return None
        return controller, state, _target(self._arm, found.q_rad)

    def tool(self, controller: CartesianController, state: CartesianState, move: Move) -> Under:
        """A frame 11 cm off, turned."""
        tool = self._arm.tip.attached(matrix([0.3, 0.5, -0.2]), [0.05, 0.02, 0.1])
        controller = controller.changed(tips=[tool])
        R, p = tool.pose(move.q_goal)
        target = ReachTarget(tips=[PoseTarget(position_m=p, rotation=R)], q_rad=move.q_goal)
        return controller, controller.take_over(state), target

    def speed(
        self,
        controller: CartesianController,
        state: CartesianState,
        move: Move,  # noqa: ARG002
    ) -> Under:
        """Up and to the side."""
        return controller, state, SpeedTarget(tips=[TipSpeed(linear_m_s=(0.0, 0.05, 0.05))])

    def loose(self, controller: CartesianController, state: CartesianState, move: Move) -> Under:
        """Only the position of the same goal."""
        pose = PoseTarget(position_m=move.goal.position_m, rotation=None)
        return controller, state, ReachTarget(tips=[pose], q_rad=move.q_goal)


def _target(arm: Arm, q: Vector) -> ReachTarget:
    pose = arm.pose(q)
    tip = PoseTarget(position_m=pose.position_m, rotation=pose.rotation)
    return ReachTarget(tips=[tip], q_rad=q)


def ride(arm: Arm, move: Move, change: Change, at: int) -> tuple[Matrix, Matrix] | None:
    """Positions of the hand and joint speeds; None where there is nothing to change to."""
    controller = CartesianController([arm.tip], arm.limits, params_of(Law.TIME_TO_GO))
    state, stiff = controller.start(move.q_start), (False,) * len(arm.joints)
    target: Target | None = move.target
    positions, speeds = [], []
    for period in range(PERIODS):
        if period == at:
            under = change(controller, state, move)
            if under is None:
                return None
            controller, state, target = under
        measured = Measurement(q_rad=state.q_plan, compliant=stiff)
        state, output = controller.step(state, measured, target)
        positions.append(arm.pose(output.plan_q_rad).position_m)
        speeds.append(output.dq_rad_s)
    return np.array(positions), np.array(speeds)


def change_rows(arm: Arm, moves: list[Move], seed: int) -> list[Row]:
    """K6, one kind after the other."""
    draw = np.random.default_rng(seed)
    rows = []
    for kind, change in Changes(arm, draw).kinds.items():
        steps, jumps = [], []
        for move in moves:
            at = int(draw.integers(FIRST, LAST))
            ridden = ride(arm, move, change, at)
            if ridden is None:
                continue
            velocity = np.diff(ridden[0], axis=0) / PERIOD_S
            acceleration = np.diff(velocity, axis=0) / PERIOD_S
            peak = np.linalg.norm(velocity, axis=1).max()
            most = np.linalg.norm(acceleration, axis=1).max()
            change_m_s = np.linalg.norm(np.diff(velocity, axis=0), axis=1)
            jump = np.linalg.norm(np.diff(acceleration, axis=0), axis=1)
            steps.append(float(change_m_s[at - 4 : at + 3].max() / peak) * 100.0)
            jumps.append(float(jump[at - 4 : at + 3].max() / most) * 100.0)
        what = f"{kind} in motion, {len(steps)} moves"
        rows += [
            at_most(f"{what}: change of speed in a period, largest", max(steps), "%", STEP_BAR),
            Row(f"{what}: change of speed in a period, median", float(np.median(steps)), "%"),
            at_most(
                f"{what}: change of acceleration in a period, largest",
                max(jumps),
                "%",
                ACCELERATION_BAR,
            ),
        ]
    return rows
