"""The plant: every axis of the robot in free motion, one millisecond a step.

Dry friction, damping and hard stops are implicit (inner-loop fact sheet, 7.3): what opposes the
motion is written as c dq', with dq' the velocity at the end of the step, so that

    (M + B + dt c) ddq = tau - h - c dq        c = D + Fc / max(|dq|, slip)

with B what the drives add: rotors, and the braking of their windings over a step. A joint whose
drive stays below the Coulomb torque then creeps at less than `slip`: it sticks.

Coordinates, angles and speeds have the order of the axes handed in. SI units, radians.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import AxisSpec, PlantSpec, SensorSpec
from firmware_sim.motor import Drives, Switches
from firmware_sim.plants import kernel
from firmware_sim.plants.driven import WALL_KG_M2, Driven
from firmware_sim.plants.mechanisms import Mechanisms
from firmware_sim.plants.rigid import Push, RigidBodies

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]

STEP_S = 0.001


class Plant:
    """Drives, mechanisms and links of one robot, and the wrenches at its sensors."""

    def __init__(
        self,
        spec: PlantSpec,
        axes: Sequence[AxisSpec],
        sensors: Sequence[SensorSpec],
        full_pwm: Sequence[int],
        motor_speeds: Matrix,
        step_s: float = STEP_S,
    ) -> None:
        """`full_pwm` is the count of 100 % PWM per motor, `motor_speeds` the S of couplings.py."""
        n = len(axes)
        self.joints: tuple[str, ...] = tuple(str(axis.joint) for axis in axes)
        motors = [None if axis.driven else axis.motor for axis in axes]
        self.drives = Drives(motors, full_pwm, motor_speeds, step_s)
        self.mechanisms = Mechanisms(axes)
        self.driven = Driven(axes, step_s)
        self._body = self.mechanisms.body
        self._off_diagonal = _coupled(motor_speeds, self._body.tolist())
        at = {axis: k for k, axis in enumerate(self._body.tolist())}
        self.rigid = RigidBodies(
            spec,
            [self.joints[i] for i in self._body],
            [sensor.frame for sensor in sensors],
            [(at[i], at[j]) for i, j in zip(*self._off_diagonal, strict=True)],
        )
        self.wrenches = self.rigid.wrenches
        self._columns = self._spread(self.rigid.columns, n)
        self._cut_columns = self._spread(self.rigid.cut_columns, n)
        self._step_s = step_s
        self.state: Matrix = np.zeros((kernel.STATE_ROWS, n))
        self.x, self.dx, self.ddx = (
            self.state[kernel.X],
            self.state[kernel.DX],
            self.state[kernel.DDX],
        )
        self.pwm, self.pull_nm = self.state[kernel.PWM], self.state[kernel.PULL]
        self.x[:] = self.mechanisms.start_rad
        self.q_rad: Vector = np.zeros(n)
        self.dq_rad_s: Vector = np.zeros(n)
        self.constants = self._constants()
        self._power(self.drives.enabled)
        self._stand()

    def step(self, pwm: Vector, enabled: Switches, pushes: Sequence[Push] = ()) -> None:
        """Advance by one step under these PWM counts; zero where the bridge is off.

        `pushes` act during this step.
        """
        if not pushes:
            self._step(pwm, enabled)
            return
        torque_nm, q_rad = self.state[kernel.PUSH], self.x[self._body]
        wrenches = []
        for push in pushes:
            tau_nm, wrench = self.rigid.pushed(q_rad, push)
            torque_nm[self._body] += tau_nm
            wrenches.append(wrench)
        self._step(pwm, enabled)
        torque_nm[:] = 0.0
        for push, wrench in zip(pushes, wrenches, strict=True):
            self.rigid.feel_push(push.at, wrench)

    def tip_pose(self) -> tuple[Vector, Vector]:
        """Position (3, m) and rotation vector (3, rad) of the tip frame in the base frame."""
        return self.rigid.tip_pose(self.x[self._body])

    def motor_torque_nm(self) -> Vector:
        """Torques that the motors exert on the joints at the end of the last step."""
        return self.drives.torque_nm(self.pwm, self.dx)

    def _stand(self) -> None:
        """Stand at rest, with everything compiled: no board waits for it in the first step."""
        self._load()
        kernel.advance(self.state, 0.0)
        self.ddx[:] = 0.0
        self._show()
        self._feel(np.zeros(self.rigid.motion.shape[1]))

    def _load(self) -> None:
        kernel.load(
            self.state,
            self.constants,
            self.drives.links,
            self.drives.shares,
            self._columns,
            self.rigid.motion,
            self._step_s,
        )

    def _step(self, pwm: Vector, enabled: Switches) -> None:
        if enabled.tobytes() != self.drives.enabled.tobytes():
            self._power(enabled)
        self.pwm[:] = pwm
        led = len(self.driven.at) > 0
        accelerations = self.driven.follow(self.x, self.dx) if led else None
        self._load()
        if accelerations is not None:
            self._lead(accelerations)
        self._feel(self.rigid.accelerate(self._off))
        kernel.advance(self.state, self._step_s)
        self._show()

    def _lead(self, accelerations: Vector) -> None:
        """Let the driven axes accelerate as told, whatever the others do."""
        at = self.driven.at
        self.ddx[at] = accelerations
        columns = self._columns[at]
        inside = columns >= 0
        self.rigid.motion[kernel.ARMATURE, columns[inside]] = WALL_KG_M2
        self.rigid.motion[kernel.TAU, columns[inside]] = WALL_KG_M2 * accelerations[inside]

    def _feel(self, accelerations: Vector) -> None:
        """Take over the bodies' accelerations, and find what the sensors feel of the motion."""
        rigid = self.rigid
        kernel.spread(self.state, accelerations, self._columns, self._cut_columns, rigid.cut_motion)
        rigid.feel()

    def _show(self) -> None:
        hands = self.mechanisms
        tables = hands.tendons
        kernel.pull(
            self.state, hands.tendon, tables.wound_rad, tables.table, self.q_rad, self.dq_rad_s
        )

    def _power(self, enabled: Switches) -> None:
        drives, constants = self.drives, self.constants
        drives.power(enabled)
        constants[kernel.BRAKING_NMS_RAD] = drives.braking_nms_rad
        constants[kernel.BRAKING_AS_RAD] = drives.braking_as_rad
        constants[kernel.INERTIA_DRIVE] = drives.inertia_diagonal
        self._off: Vector = drives.inertia_kg_m2[self._off_diagonal]

    def _constants(self) -> Matrix:
        drives, mechanisms = self.drives, self.mechanisms
        constants: Matrix = np.zeros((kernel.CONSTANT_ROWS, len(self.joints)))
        constants[kernel.NM_PER_COUNT] = drives.nm_per_count
        constants[kernel.A_PER_COUNT] = drives.a_per_count
        constants[kernel.COULOMB_NM] = drives.coulomb_nm
        constants[kernel.VISCOUS_NMS_RAD] = drives.viscous_nms_rad
        constants[kernel.INERTIA_OWN] = mechanisms.own_kg_m2
        constants[kernel.LOW_STOP], constants[kernel.HIGH_STOP] = mechanisms.stops_rad
        return constants

    def _spread(self, columns: Indices, axes: int) -> Indices:
        """Columns of a model by axis, -1 for axes that are not in it."""
        spread = np.full(axes, -1, dtype=np.intp)
        spread[self._body] = columns
        return spread


def _coupled(
    motor_speeds: Matrix, body: Sequence[int]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of body axes that some motor turns together, the lower index first."""
    together = np.abs(motor_speeds.T) @ np.abs(motor_speeds)
    pairs = [(i, j) for i in body for j in body if i < j and together[i, j] > 0.0]
    both = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    return both[:, 0], both[:, 1]
