"""Brushed drives of all axes at once: PWM counts to current and to torque at the joints.

Supply and winding:  V pwm / full = R i + Kj w        Kj = torque constant x gear, N m per ampere
Torque of a motor:   Kj i, behind its gear
At the joints:       w = S dq, tau = S' Kj i          S = speed of each motor per speed of a joint
Winding inductance is left out (2 ms of it changed nothing). With the bridge off no current flows:
neither drive nor braking.

S is in the sense of the PWM: without couplings it holds the polarities. Angles and torques are
joint-sided. Rotor inertia and friction belong to the mechanics; their joint-side values are kept
here. An axis without a motor is driven from elsewhere and gives no torque.
Source of the values: the robot file; of the law: the inner-loop fact sheet, section 1.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import MotorSpec

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Switches = NDArray[np.bool_]

NO_MOTOR = MotorSpec(
    supply_v=0.0,
    torque_constant_nm_a=0.0,
    resistance_ohm=1.0,
    gear=0.0,
    rotor_inertia_kg_m2=0.0,
    coulomb_nm=0.0,
    viscous_nms_rad=0.0,
)


class Drives:
    """Constants of n drives as arrays of shape (n,), and the state of their bridges.

    The arrays that depend on a bridge follow `power`: read them from the object, each step.
    """

    def __init__(
        self,
        motors: Sequence[MotorSpec | None],
        full_pwm: Sequence[int],
        motor_speeds: Matrix,
        step_s: float,
    ) -> None:
        """`motor_speeds` is S (n, n); `step_s` is the time over which damping is implicit."""
        specs = [NO_MOTOR if motor is None else motor for motor in motors]
        n = len(specs)
        self.S: Matrix = motor_speeds.copy()
        self.S_T: Matrix = np.ascontiguousarray(motor_speeds.T)
        nm_per_a = np.array([m.torque_constant_nm_a * m.gear for m in specs])
        resistance_ohm = np.array([m.resistance_ohm for m in specs])
        supply_v = np.array([m.supply_v for m in specs])
        self.a_per_count: Vector = supply_v / (resistance_ohm * np.array(full_pwm))
        self.nm_per_count: Vector = nm_per_a * self.a_per_count
        self.coulomb_nm: Vector = np.array([m.coulomb_nm for m in specs])
        self.viscous_nms_rad: Vector = np.array([m.viscous_nms_rad for m in specs])
        self._rotor_kg_m2 = np.array([m.rotor_inertia_kg_m2 * m.gear**2 for m in specs])
        self._back_emf_nms_rad = nm_per_a**2 / resistance_ohm
        self._back_emf_as_rad = nm_per_a / resistance_ohm
        self._step_s = step_s
        self.links = np.array(np.nonzero(motor_speeds), dtype=np.int64)  # (motor, joint) by column
        self.shares: Vector = motor_speeds[np.nonzero(motor_speeds)]
        self.enabled: Switches = np.ones(n, dtype=np.bool_)
        self.braking_as_rad: Vector = np.zeros(n)  # current that a motor's speed takes away
        self.braking_nms_rad: Vector = np.zeros(n)  # torque that a motor's speed takes away
        self.inertia_kg_m2: Matrix = np.zeros((n, n))  # rotors and braking over one step, at joints
        self.inertia_diagonal: Vector = np.zeros(n)
        self.power(np.zeros(n, dtype=np.bool_))

    def power(self, enabled: Switches) -> None:
        """Switch every bridge on or off."""
        on = enabled.astype(np.float64)
        self.enabled = enabled.copy()
        self.braking_as_rad = self._back_emf_as_rad * on
        self.braking_nms_rad = self._back_emf_nms_rad * on
        at_motors = self._rotor_kg_m2 + self._step_s * self.braking_nms_rad
        self.inertia_kg_m2 = self.S_T @ (at_motors[:, None] * self.S)
        self.inertia_diagonal = self.inertia_kg_m2.diagonal().copy()

    def torque_nm(self, pwm: Vector, dq_rad_s: Vector) -> Vector:
        """Torques that the motors exert on the joints, friction not yet taken off."""
        braking: Vector = self.S @ dq_rad_s
        braking *= self.braking_nms_rad
        at_motors: Vector = self.nm_per_count * pwm
        at_motors -= braking
        torque: Vector = self.S_T @ at_motors
        return torque
