"""Cartesian controller: follows the virtual point with minimum-jerk motion of hand and joints.

Reads   ik/ik_solution, field/virtual_point, joint_state and torque_estimate of the limb's parts
Writes  joint_command of the limb's parts, cartesian/status
It commands only while every joint of the limb is valid and in position-direct mode. Without new
solutions the plan stops smoothly and holds. What is not finite or out of order is refused and
counted, and the last target holds.
"""

import numpy as np

from dforc import rotation
from dforc.cartesian import (
    CartesianController,
    CartesianOutput,
    CartesianParams,
    CartesianState,
    CartesianTarget,
    Measurement,
)
from dforc.errors import NotFiniteError
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.limb import joined, limb_limits, limb_model, split
from services.messages import (
    CartesianStatus,
    Floats,
    IkSolution,
    JointCommand,
    TorqueEstimate,
    VirtualPoint,
)
from services.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_STATUS,
    IK_SOLUTION,
    JOINT_COMMAND,
    JOINT_STATE,
    TORQUE_ESTIMATE,
    VIRTUAL_POINT,
)

PERIOD_S = 0.01
STATE_AGE_S = 0.05
FORCE_AGE_S = 0.05
FORGET_AFTER_NS = 500_000_000  # without joint states: the plan no longer fits the arm
SOLUTION_AGE_S = 0.1  # ten periods without a solution: stop and hold
POINTS_KEPT = 32  # virtual points that wait for their solution
DIRECT_MODE = 0x08  # code of position direct, can-protocol 10.1
IN_TARGET_M = 0.003
IN_TARGET_RAD = np.radians(1.5)
AT_REST_M_S = 0.005


class Cartesian(Service):
    """One controller for one limb."""

    trigger = Period(PERIOD_S)

    def __init__(self, robot: RobotFile, params: CartesianParams | None = None) -> None:
        self._robot = robot
        self._model = limb_model(robot)
        params = params or CartesianParams(trajectory_time_s=robot.reach.trajectory_time_s)
        self._controller = CartesianController(self._model, limb_limits(robot), params)
        self._state: CartesianState | None = None
        self._target: CartesianTarget | None = None
        self._points: dict[int, VirtualPoint] = {}
        self._sequence = -1
        self._measured_ns = 0
        self._compliant: list[bool] = []
        self._refused = 0
        parts = robot.reach.parts
        self._states = tuple(JOINT_STATE[part] for part in parts)
        self._estimate = TORQUE_ESTIMATE[parts[-1]]
        self.reads = (IK_SOLUTION, VIRTUAL_POINT, *self._states, self._estimate)
        self.writes = (*(JOINT_COMMAND[part] for part in parts), CARTESIAN_STATUS)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One control period."""
        for point in inputs.all_new(VIRTUAL_POINT):
            self._points[point.sequence] = point
        while len(self._points) > POINTS_KEPT:
            del self._points[next(iter(self._points))]
        solution = inputs.new(IK_SOLUTION)
        if solution is not None:
            self._take_solution(solution)
        q_rad = self._measured(now_ns, inputs)
        if q_rad is None or self._target is None:
            outputs.put(CARTESIAN_STATUS, waiting(now_ns, self._refused))
            return
        if self._state is None:
            # On entering position-direct mode a board holds the posture that it was in.
            self._state = self._controller.start(np.array(q_rad))
        silent = inputs.age_s(IK_SOLUTION) > SOLUTION_AGE_S
        force_n = external_force(inputs.fresh(self._estimate, FORCE_AGE_S))
        measured = Measurement(
            q_rad=np.array(q_rad), compliant=self._compliant, external_force_n=force_n
        )
        try:
            self._state, output = self._controller.step(
                self._state, measured, None if silent else self._target
            )
        except NotFiniteError:
            self._refused += 1
            return
        self._command(now_ns, output, outputs)
        outputs.put(CARTESIAN_STATUS, self._status(now_ns, output, force_n))

    def _take_solution(self, solution: IkSolution) -> None:
        point = self._points.get(solution.sequence)
        if point is None or not np.isfinite(solution.q_rad).all():
            self._refused += 1
            return
        if solution.sequence <= self._sequence < solution.sequence + POINTS_KEPT:
            self._refused += 1
            return
        self._sequence = solution.sequence
        q_rad = np.array(solution.q_rad)
        if solution.status == "converged":
            position = np.array(point.position_m)
            orientation = rotation.matrix(point.rotation_rad)
            velocity = np.array(point.velocity_m_s)
        else:  # out of reach: the nearest posture is the target, not the point beyond it
            orientation, position = self._model.tip_pose(q_rad)
            velocity = np.zeros(3)
        self._target = CartesianTarget(
            position_m=position, rotation=orientation, q_rad=q_rad, velocity_m_s=velocity
        )

    def _measured(self, now_ns: int, inputs: Inputs) -> Floats | None:
        """Angles to control, or None; a short gap keeps the plan, a mode switch ends it."""
        states = tuple(inputs.fresh(state, STATE_AGE_S) for state in self._states)
        joints = joined(states)
        if joints is None:
            if now_ns - self._measured_ns > FORGET_AFTER_NS:
                self._state = None
            return None
        self._measured_ns = now_ns
        self._compliant = [c for state in states if state for c in state.compliant]
        modes = [mode for state in states if state for mode in state.control_mode]
        if any(mode != DIRECT_MODE for mode in modes):
            self._state = None
            return None
        return joints[0]

    def _command(self, now_ns: int, output: CartesianOutput, outputs: Outputs) -> None:
        q = split(self._robot, tuple(output.q_rad.tolist()))
        dq = split(self._robot, tuple(output.dq_rad_s.tolist()))
        for part, q_rad in q.items():
            outputs.put(
                JOINT_COMMAND[part],
                JointCommand(stamp_ns=now_ns, mode="direct", q_rad=q_rad, dq_rad_s=dq[part]),
            )

    def _status(self, now_ns: int, output: CartesianOutput, force_n: float) -> CartesianStatus:
        assert self._target is not None
        arrived = (
            output.position_error_m < IN_TARGET_M
            and output.orientation_error_rad < IN_TARGET_RAD
            and float(np.linalg.norm(self._target.velocity_m_s)) < AT_REST_M_S
        )
        x, y, z = output.plan_position_m.tolist()
        return CartesianStatus(
            stamp_ns=now_ns,
            state="in_target" if arrived else "moving",
            position_error_m=output.position_error_m,
            orientation_error_rad=output.orientation_error_rad,
            external_force_n=force_n,
            gated=output.gated,
            planned_position_m=(x, y, z),
            refused=self._refused,
        )


def external_force(estimate: TorqueEstimate | None) -> float:
    """Size of the force at the hand [N]; 0 when unknown."""
    return 0.0 if estimate is None else float(np.linalg.norm(estimate.external_force_n))


def waiting(now_ns: int, refused: int) -> CartesianStatus:
    """Status of a controller that commands nothing."""
    nan = float("nan")
    return CartesianStatus(
        stamp_ns=now_ns,
        state="waiting",
        position_error_m=nan,
        orientation_error_rad=nan,
        external_force_n=0.0,
        gated=False,
        planned_position_m=(nan, nan, nan),
        refused=refused,
    )


def build(context: Context) -> Cartesian:
    """Load the robot's model."""
    return Cartesian(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("cartesian", build))
