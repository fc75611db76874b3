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
from firmware_sim.plants.driven import WALL_KG_M2, Driven
from firmware_sim.plants.mechanisms import Mechanisms
from firmware_sim.plants.rigid import RigidBodies

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

STEP_S = 0.001
SLIP_RAD_S = 1e-5  # below this speed dry friction falls to zero: 0.03 deg a minute at most
STOP_NM_RAD = 2.0e4  # assumed: 20 Nm press a joint 0.06 deg into its stop
STOP_NMS_RAD = 100.0  # assumed: no bounce at the arm's inertias


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
        self.x: Vector = self.mechanisms.start_rad.copy()
        self.dx: Vector = np.zeros(n)
        self.ddx: Vector = np.zeros(n)
        self.q_rad, self.dq_rad_s = self.x, self.dx
        if len(self.mechanisms.tendon):
            self.q_rad, self.dq_rad_s = np.zeros(n), np.zeros(n)
        self.pwm: Vector = np.zeros(n)
        self._low_stop, self._high_stop = self.mechanisms.stops_rad
        self._step_s = step_s
        self._slip: Vector = np.full(n, SLIP_RAD_S)
        self._dt: Vector = np.full(n, step_s)  # an array, because numpy is slower with a scalar
        self._opposing: Vector = np.zeros(n)
        self._change: Vector = np.zeros(n)
        self._outside = np.zeros((2, n), dtype=np.bool_)
        self._show()
        self._feel()  # before the first step: the weight at rest

    def step(self, pwm: Vector, enabled: Switches, force_n: Vector | None = None) -> None:
        """Advance by one step under these PWM counts; zero where the bridge is off.

        `force_n` (3, N, base frame) acts on the tip's origin during this step.
        """
        if force_n is None:
            self._step(pwm, enabled, None)
            return
        push_nm, point_m = self.rigid.pushed(self.x[self._body], force_n)
        self._step(pwm, enabled, push_nm)
        self.rigid.feel_push(force_n, point_m)

    def tip_pose(self) -> tuple[Vector, Vector]:
        """Position (3, m) and rotation vector (3, rad) of the tip frame in the base frame."""
        return self.rigid.tip_pose(self.x[self._body])

    def motor_torque_nm(self) -> Vector:
        """Torques that the motors exert on the joints at the end of the last step."""
        return self.drives.torque_nm(self.pwm, self.dx)

    def current_a(self) -> Vector:
        """Currents of the motors at the end of the last step, in the sense of the PWM."""
        return self.drives.current_a(self.pwm, self.dx)

    def _step(self, pwm: Vector, enabled: Switches, push_nm: Vector | None) -> None:
        drives, opposing, dx = self.drives, self._opposing, self.dx
        if enabled.tobytes() != drives.enabled.tobytes():
            drives.power(enabled)
        self.pwm[:] = pwm
        tau = drives.torque_nm(self.pwm, dx)
        np.abs(dx, out=opposing)
        np.maximum(opposing, self._slip, out=opposing)
        np.divide(drives.coulomb_nm, opposing, out=opposing)
        opposing += drives.viscous_nms_rad
        outside = self._outside
        np.less(self.x, self._low_stop, out=outside[0])
        np.greater(self.x, self._high_stop, out=outside[1])
        if outside.any():
            self._press_stops(opposing, tau)
        if len(self.mechanisms.tendon):
            self.mechanisms.pull(tau, opposing, self._step_s)
        if push_nm is not None:
            tau[self._body] += push_nm
        self._accelerate(tau, opposing)
        self._feel()
        self._advance()

    def _accelerate(self, tau: Vector, opposing: Vector) -> None:
        drives, body, inertia = self.drives, self._body, self._change
        np.multiply(opposing, self._dt, out=inertia)
        inertia += drives.inertia_diagonal
        opposing *= self.dx
        tau -= opposing
        if len(self.driven.at):
            inertia[self.driven.at] = WALL_KG_M2
            tau[self.driven.at] = WALL_KG_M2 * self.driven.follow(self.x, self.dx)
        if self.mechanisms.others:
            np.divide(tau, inertia + self.mechanisms.own_kg_m2, out=self.ddx)
        off = drives.inertia_kg_m2[self._off_diagonal]
        self.ddx[body] = self.rigid.accelerate(
            self.x[body], self.dx[body], tau[body], inertia[body], off
        )

    def _feel(self) -> None:
        """Find the wrenches between the sensors' sides from the motion at the start of the step."""
        body = self._body
        self.rigid.feel(self.x[body], self.dx[body], self.ddx[body])

    def _advance(self) -> None:
        change = self._change
        np.multiply(self.ddx, self._dt, out=change)
        self.dx += change
        np.multiply(self.dx, self._dt, out=change)
        self.x += change
        self._show()

    def _show(self) -> None:
        if len(self.mechanisms.tendon):
            self.mechanisms.show(self.x, self.dx, self.q_rad, self.dq_rad_s)

    def _press_stops(self, opposing: Vector, tau: Vector) -> None:
        """Add spring and damper of every hard stop that a joint stands in, implicit as friction."""
        for i in np.flatnonzero(self._outside[0] | self._outside[1]).tolist():
            stop = self._low_stop[i] if self._outside[0, i] else self._high_stop[i]
            inside = self.x[i] - stop
            tau[i] -= STOP_NM_RAD * inside
            opposing[i] += STOP_NM_RAD * self._step_s
            if inside * self.dx[i] > 0.0:  # a stop does not hold back what leaves it
                opposing[i] += STOP_NMS_RAD


def _coupled(
    motor_speeds: Matrix, body: Sequence[int]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of body axes that some motor turns together, the lower index first."""
    together = np.abs(motor_speeds.T) @ np.abs(motor_speeds)
    pairs = [(i, j) for i in body for j in body if i < j and together[i, j] > 0.0]
    both = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    return both[:, 0], both[:, 1]
