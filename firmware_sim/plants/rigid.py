"""The rigid plant: an arm of links and drives in free motion, one millisecond a step.

Forward dynamics is pinocchio's articulated-body algorithm. Dry friction, damping and hard stops are
implicit (inner-loop fact sheet, 7.3): what opposes the motion is written as c dq', with dq' the
velocity at the end of the step, so that

    (M + rotor + dt c) ddq = tau - h - c dq        c = D + Fc / max(|dq|, slip)

and `rotor + dt c` goes where pinocchio keeps the rotor inertia. A joint whose drive stays below the
Coulomb torque then creeps at less than `slip`: it sticks.

The sensors read the same step's motion: a second model, in which each sensor is a joint frozen at
zero, gives the wrench between its two sides. Bodies are heavier or lighter than the URDF says and
their centres of mass are off, by the seed; no object is shared with any controller's model.
Joint vectors have the order of the axes handed in. SI units, radians.
"""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dforc.robot_model import frame_index, joint_columns, load_model
from firmware_sim.description import AxisSpec, PlantSpec, SensorSpec
from firmware_sim.draws import Draw, generator
from firmware_sim.motor import Drives

Vector = NDArray[np.float64]

STEP_S = 0.001
SLIP_RAD_S = 1e-5  # below this speed dry friction falls to zero: 0.03 deg a minute at most
STOP_NM_RAD = 2.0e4  # assumed: 20 Nm press a joint 0.06 deg into its stop
STOP_NMS_RAD = 100.0  # assumed: no bounce at the arm's inertias


class RigidPlant:
    """Joints with their drives, and the wrenches at the sensors."""

    def __init__(
        self,
        spec: PlantSpec,
        axes: Sequence[AxisSpec],
        sensors: Sequence[SensorSpec],
        full_pwm: Sequence[int],
        step_s: float = STEP_S,
    ) -> None:
        """`axes` all have a joint and a motor; `full_pwm` is the count of 100 % PWM per axis."""
        self.joints: tuple[str, ...] = tuple(str(axis.joint) for axis in axes)
        motors = [axis.motor for axis in axes if axis.motor is not None]
        self.drives = Drives(motors, full_pwm, [axis.pwm_polarity for axis in axes])
        self._load(spec, tuple(sensor.frame for sensor in sensors))
        n = len(self.joints)
        self.q_rad: Vector = np.radians([axis.start_deg for axis in axes])
        self.dq_rad_s: Vector = np.zeros(n)
        self.ddq_rad_s2: Vector = np.zeros(n)
        self.pwm: Vector = np.zeros(n)
        self._low_stop = [math.radians(axis.hard_stop_deg[0]) for axis in axes]
        self._high_stop = [math.radians(axis.hard_stop_deg[1]) for axis in axes]
        self._step_s = step_s
        self._slip: Vector = np.full(n, SLIP_RAD_S)
        self._dt: Vector = np.full(n, step_s)  # an array, because numpy is slower with a scalar
        self._opposing: Vector = np.zeros(n)
        self._inertia: Vector = np.zeros(n)
        self._tau: Vector = np.zeros(n)
        self._feel()
        self._show_wrenches()  # before the first step: the weight at rest

    def _load(self, spec: PlantSpec, sensor_frames: tuple[str, ...]) -> None:
        self._cut = load_model(spec.urdf, self.joints, sensor_frames)
        _disturb(self._cut, spec)
        frozen = [self._cut.getJointId(frame) for frame in sensor_frames]
        self._model = pin.buildReducedModel(self._cut, frozen, pin.neutral(self._cut))
        self._data, self._cut_data = self._model.createData(), self._cut.createData()
        self._at = joint_columns(self._model, self.joints)
        self._cut_at = joint_columns(self._cut, self.joints)
        self._armature = self._model.armature  # a live view, as are the wrenches
        self._state = [np.zeros(self._model.nv) for _ in range(3)]
        self._cut_state = [np.zeros(self._cut.nv) for _ in range(3)]
        self._tip = frame_index(self._model, spec.tip_frame)
        self._sensor_places = [self._cut_data.oMi[i] for i in frozen]
        self._near_on_far = [self._cut_data.f[i].vector for i in frozen]
        self.wrenches: list[Vector] = [np.zeros(6) for _ in frozen]

    def step(self, pwm: Sequence[int], enabled: tuple[bool, ...]) -> None:
        """Advance by one step under these PWM counts; zero where the bridge is off."""
        self._step(pwm, enabled)
        self._show_wrenches()

    def step_pushed(self, pwm: Sequence[int], enabled: tuple[bool, ...], force_n: Vector) -> None:
        """Advance by one step while a force (3, N, base frame) acts on the tip's origin."""
        self._state[0][self._at] = self.q_rad
        J = pin.computeFrameJacobian(
            self._model, self._data, self._state[0], self._tip, pin.LOCAL_WORLD_ALIGNED
        )
        pin.updateFramePlacement(self._model, self._data, self._tip)
        point_m = self._data.oMf[self._tip].translation.copy()
        self._step(pwm, enabled, J[:3, self._at].T @ force_n)
        pin.updateGlobalPlacements(self._cut, self._cut_data)  # rnea leaves them as they were
        for i, place in enumerate(self._sensor_places):
            push = pin.Force(force_n, pin.skew(point_m) @ force_n)
            np.subtract(place.actInv(push).vector, self._near_on_far[i], out=self.wrenches[i])

    def tip_pose(self) -> tuple[Vector, Vector]:
        """Position (3, m) and rotation vector (3, rad) of the tip frame in the base frame."""
        self._state[0][self._at] = self.q_rad
        pin.forwardKinematics(self._model, self._data, self._state[0])
        place = pin.updateFramePlacement(self._model, self._data, self._tip)
        rotation_rad: Vector = pin.log3(place.rotation)
        return place.translation.copy(), rotation_rad

    def motor_torque_nm(self) -> Vector:
        """Torques that the motors exert on the joints at the end of the last step."""
        return self.drives.torque_nm(self.pwm, self.dq_rad_s)

    def current_a(self) -> Vector:
        """Currents of the motors at the end of the last step, in the sign of the PWM."""
        return self.drives.current_a(self.pwm, self.dq_rad_s)

    def _step(
        self, pwm: Sequence[int], enabled: tuple[bool, ...], tau_ext_nm: Vector | None = None
    ) -> None:
        drives, opposing, tau, dq = self.drives, self._opposing, self._tau, self.dq_rad_s
        if enabled != drives.enabled:
            drives.power(enabled)
        self.pwm[:] = pwm
        np.multiply(drives.nm_per_count, self.pwm, out=tau)
        np.abs(dq, out=opposing)
        np.maximum(opposing, self._slip, out=opposing)
        np.divide(drives.coulomb_nm, opposing, out=opposing)
        opposing += drives.damping_nms_rad
        for low, angle, high in zip(
            self._low_stop, self.q_rad.tolist(), self._high_stop, strict=True
        ):
            if not low <= angle <= high:
                self._press_stops(opposing, tau)
                break
        if tau_ext_nm is not None:
            tau += tau_ext_nm
        np.multiply(opposing, self._dt, out=self._inertia)
        self._inertia += drives.rotor_kg_m2
        self._armature[self._at] = self._inertia
        opposing *= dq
        tau -= opposing
        self._integrate()

    def _integrate(self) -> None:
        at, q, dq, ddq = self._at, self.q_rad, self.dq_rad_s, self.ddq_rad_s2
        q_all, dq_all, tau_all = self._state
        q_all[at], dq_all[at], tau_all[at] = q, dq, self._tau
        ddq[:] = pin.aba(self._model, self._data, q_all, dq_all, tau_all)[at]
        self._feel()
        change = self._inertia
        np.multiply(ddq, self._dt, out=change)
        dq += change
        np.multiply(dq, self._dt, out=change)
        q += change

    def _feel(self) -> None:
        """Find the wrenches between the sensors' sides from the motion at the start of the step."""
        at, (q, dq, ddq) = self._cut_at, self._cut_state
        q[at], dq[at], ddq[at] = self.q_rad, self.dq_rad_s, self.ddq_rad_s2
        pin.rnea(self._cut, self._cut_data, q, dq, ddq)

    def _show_wrenches(self) -> None:
        for wrench, near_on_far in zip(self.wrenches, self._near_on_far, strict=True):
            np.negative(near_on_far, out=wrench)

    def _press_stops(self, opposing: Vector, tau: Vector) -> None:
        """Add spring and damper of every hard stop that a joint stands in, implicit as friction."""
        stops = zip(self._low_stop, self.q_rad.tolist(), self._high_stop, strict=True)
        for i, (low, angle, high) in enumerate(stops):
            if low <= angle <= high:
                continue
            inside = angle - (low if angle < low else high)
            tau[i] -= STOP_NM_RAD * inside
            opposing[i] += STOP_NM_RAD * self._step_s
            if inside * self.dq_rad_s[i] > 0.0:  # a stop does not hold back what leaves it
                opposing[i] += STOP_NMS_RAD


def _disturb(model: "pin.Model", spec: PlantSpec) -> None:
    """Change mass and centre of mass of every moving body, in place.

    In place because pinocchio's Inertia constructor refuses one link of iCubLisboa01.
    """
    mass_rng, lever_rng = generator(spec.seed, Draw.MASS), generator(spec.seed, Draw.LEVER)
    for i in range(1, model.njoints):
        factor = 1.0 + mass_rng.uniform(-spec.mass_error, spec.mass_error)
        direction = lever_rng.standard_normal(3)
        body = model.inertias[i]
        if body.mass > 0.0:
            body.mass = body.mass * factor
            body.lever = body.lever + spec.com_error_m * direction / np.linalg.norm(direction)
