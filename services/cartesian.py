"""Cartesian controller: follows the virtual point with minimum-jerk motion of hand and joints.

Reads   ik/ik_solution, field/virtual_point, joint_state of the limb's parts, dynamics/status
Writes  joint_command of the limb's parts, cartesian/status
It commands only while every joint of the limb is valid and in position-direct mode. Without new
solutions the plan stops smoothly and holds. What is not finite or out of order is refused and
counted, and the last target holds.
"""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from dforc import rotation
from dforc.cartesian.controller import (
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
from services.messages import (
    NAN3,
    CartesianStatus,
    DynamicsStatus,
    Floats,
    IkSolution,
    JointCommand,
    JointState,
    Vector3,
    VirtualPoint,
)
from services.reaching.limb import joined, limb_limits, limb_model, split
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_STATUS,
    DYNAMICS_STATUS,
    IK_SOLUTION,
    JOINT_COMMAND,
    JOINT_STATE,
    VIRTUAL_POINT,
)

PERIOD_S = 0.01
STATE_AGE_S = 0.05
FORCE_AGE_S = 0.05
FORGET_AFTER_NS = 500_000_000  # without joint states: the plan no longer fits the arm
SOLUTION_AGE_NS = 100_000_000  # ten periods without a good solution: stop and hold
POINTS_KEPT = 32
STATUS_EVERY_STEPS = 2
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
        self._points: dict[int, VirtualPoint] = {}  # that wait for their solution
        self._followed: VirtualPoint | None = None
        self._sequence = -1
        self._measured_ns = 0
        self._solved_ns = 0
        self._in_direct_mode = False
        self._compliant: list[bool] = []
        self._steps = 0
        self._solution: IkSolution | None = None
        self._refused = 0
        parts = robot.reach.parts
        self._states = tuple(JOINT_STATE[part] for part in parts)
        self.reads = (IK_SOLUTION, VIRTUAL_POINT, *self._states, DYNAMICS_STATUS)
        self.writes = (*(JOINT_COMMAND[part] for part in parts), CARTESIAN_STATUS)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One control period."""
        for point in inputs.all_new(VIRTUAL_POINT):
            self._points[point.sequence] = point
        while len(self._points) > POINTS_KEPT:
            del self._points[next(iter(self._points))]
        solution = inputs.new(IK_SOLUTION)
        if solution is not None:
            self._take_solution(now_ns, solution)
        joints = self._measured(now_ns, inputs)
        force_n = external_force(inputs.fresh(DYNAMICS_STATUS, FORCE_AGE_S))
        output = None
        if joints is not None and self._in_direct_mode and self._target is not None:
            silent = now_ns - self._solved_ns > SOLUTION_AGE_NS
            output = self._control(joints, force_n, None if silent else self._target)
        if output is not None:
            self._command(now_ns, output, outputs)
        self._steps += 1
        if self._steps % STATUS_EVERY_STEPS == 0:
            status = self._status(now_ns, joints)
            if output is not None:
                status = self._following(status, output, force_n)
            outputs.put(CARTESIAN_STATUS, status)

    def _control(
        self, q_rad: Floats, force_n: float, target: CartesianTarget | None
    ) -> CartesianOutput | None:
        if self._state is None:
            # On entering position-direct mode a board holds the posture that it was in.
            self._state = self._controller.start(np.array(q_rad))
        measured = Measurement(
            q_rad=np.array(q_rad), compliant=self._compliant, external_force_n=force_n
        )
        try:
            self._state, output = self._controller.step(self._state, measured, target)
        except NotFiniteError:
            self._refused += 1
            return None
        return output

    def _take_solution(self, now_ns: int, solution: IkSolution) -> None:
        point = self._points.get(solution.sequence)
        if point is None or not self._is_good(solution, point):
            self._refused += 1
            return
        if solution.sequence <= self._sequence < solution.sequence + POINTS_KEPT:
            self._refused += 1
            return
        self._sequence = solution.sequence
        self._solved_ns = now_ns
        self._solution = solution
        self._followed = point
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

    def _is_good(self, solution: IkSolution, point: VirtualPoint) -> bool:
        numbers = (*solution.q_rad, *point.position_m, *point.velocity_m_s, *point.rotation_rad)
        # A sum of squares is finite only if every term is, and no term is beyond squaring.
        return len(solution.q_rad) == self._model.n and math.isfinite(sum(x * x for x in numbers))

    def _measured(self, now_ns: int, inputs: Inputs) -> Floats | None:
        """Angles, or None; a short gap keeps the plan, a mode switch ends it."""
        states = tuple(inputs.fresh(state, STATE_AGE_S) for state in self._states)
        joints = joined(states)
        if joints is not None and not self._is_posture(joints[0], states):
            self._refused += 1
            joints = None
        if joints is None:
            if now_ns - self._measured_ns > FORGET_AFTER_NS:
                self._state = None
            return None
        self._measured_ns = now_ns
        self._compliant = [c for state in states if state for c in state.compliant]
        modes = [mode for state in states if state for mode in state.control_mode]
        self._in_direct_mode = all(mode == DIRECT_MODE for mode in modes)
        if not self._in_direct_mode:
            self._state = None
        return joints[0]

    def _is_posture(self, q_rad: Floats, states: tuple[JointState | None, ...]) -> bool:
        for state in states:
            if state and not len(state.q_rad) == len(state.compliant) == len(state.control_mode):
                return False
        return len(q_rad) == self._model.n and math.isfinite(sum(q * q for q in q_rad))

    def _command(self, now_ns: int, output: CartesianOutput, outputs: Outputs) -> None:
        q = split(self._robot, tuple(output.q_rad.tolist()))
        dq = split(self._robot, tuple(output.dq_rad_s.tolist()))
        for part, q_rad in q.items():
            outputs.put(
                JOINT_COMMAND[part],
                JointCommand(stamp_ns=now_ns, mode="direct", q_rad=q_rad, dq_rad_s=dq[part]),
            )

    def _status(self, now_ns: int, q_rad: Floats | None) -> CartesianStatus:
        """What is measured; for a controller that commands nothing that is all."""
        position, turned = NAN3, NAN3
        if q_rad is not None:
            hand_rotation, hand_m = self._model.tip_pose(np.array(q_rad))
            position, turned = vector3(hand_m), vector3(rotation.rotation_vector(hand_rotation))
        return CartesianStatus(
            stamp_ns=now_ns,
            state="waiting",
            q_rad=q_rad or (),
            hand_position_m=position,
            hand_rotation_rad=turned,
            refused=self._refused,
        )

    def _following(
        self, status: CartesianStatus, output: CartesianOutput, force_n: float
    ) -> CartesianStatus:
        target, solution, point = self._target, self._solution, self._followed
        assert target is not None
        assert solution is not None
        assert point is not None
        arrived = (
            output.position_error_m < IN_TARGET_M
            and output.orientation_error_rad < IN_TARGET_RAD
            and float(np.linalg.norm(target.velocity_m_s)) < AT_REST_M_S
        )
        return msgspec.structs.replace(
            status,
            state="in_target" if arrived else "moving",
            position_error_m=output.position_error_m,
            orientation_error_rad=output.orientation_error_rad,
            external_force_n=force_n,
            gated=output.gated,
            plan_position_m=vector3(output.plan_position_m),
            point_position_m=point.position_m,
            ik_status=solution.status,
            ik_position_error_m=solution.position_error_m,
        )


def external_force(status: DynamicsStatus | None) -> float:
    """Size of the force on the hand [N]; 0 when unknown."""
    return 0.0 if status is None else float(np.linalg.norm(status.external_force_n))


def vector3(values: NDArray[np.float64]) -> Vector3:
    """A vector (3,) as a message carries it."""
    x, y, z = values.tolist()
    return (x, y, z)


def build(context: Context) -> Cartesian:
    """Load the robot's model."""
    return Cartesian(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("cartesian", build))
