"""Brushed drives of all axes at once: PWM counts to current and to torque at the joint.

Supply and winding:  V pwm / full = R i + Kj dq       Kj = torque constant x gear, N m per ampere
Torque at the joint: tau = Kj i
Winding inductance is left out (2 ms of it changed nothing). With the bridge off no current flows:
neither drive nor braking.

Positive PWM and positive current turn a joint by its polarity; angles and torques are joint-sided.
Rotor inertia and friction belong to the mechanics; their joint-side values are kept here.
Source of the values: the robot file; of the law: the inner-loop fact sheet, section 1.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import MotorSpec

Vector = NDArray[np.float64]


class Drives:
    """Constants of n drives as arrays of shape (n,), and the state of their bridges.

    The arrays that depend on a bridge follow `power`: read them from the object, each step.
    """

    def __init__(
        self, motors: Sequence[MotorSpec], full_pwm: Sequence[int], polarity: Sequence[int]
    ) -> None:
        sign = np.array(polarity, dtype=np.float64)
        nm_per_a = np.array([m.torque_constant_nm_a * m.gear for m in motors])
        resistance_ohm = np.array([m.resistance_ohm for m in motors])
        supply_v = np.array([m.supply_v for m in motors])
        self.a_per_count: Vector = supply_v / (resistance_ohm * np.array(full_pwm))
        self.nm_per_count: Vector = sign * nm_per_a * self.a_per_count
        self.coulomb_nm: Vector = np.array([m.coulomb_nm for m in motors])
        self.rotor_kg_m2: Vector = np.array([m.rotor_inertia_kg_m2 * m.gear**2 for m in motors])
        self._viscous_nms_rad = np.array([m.viscous_nms_rad for m in motors])
        self._back_emf_nms_rad = nm_per_a**2 / resistance_ohm
        self._back_emf_as_rad = sign * nm_per_a / resistance_ohm
        self.enabled: tuple[bool, ...] = ()
        self.damping_nms_rad: Vector = np.empty(0)  # viscous friction and electric braking
        self.braking_as_rad: Vector = np.empty(0)  # current that a joint's speed takes away
        self.braking_nms_rad: Vector = np.empty(0)  # torque that a joint's speed takes away
        self.power((False,) * len(motors))

    def power(self, enabled: tuple[bool, ...]) -> None:
        """Switch every bridge on or off."""
        on = np.array(enabled, dtype=np.float64)
        self.enabled = enabled
        self.braking_as_rad = self._back_emf_as_rad * on
        self.braking_nms_rad = self._back_emf_nms_rad * on
        self.damping_nms_rad = self._viscous_nms_rad + self.braking_nms_rad

    def current_a(self, pwm: Vector, dq_rad_s: Vector) -> Vector:
        """Winding currents in the sign of the PWM; `pwm` is zero where the bridge is off."""
        current: Vector = self.a_per_count * pwm
        current -= self.braking_as_rad * dq_rad_s
        return current

    def torque_nm(self, pwm: Vector, dq_rad_s: Vector) -> Vector:
        """Torques that the motors exert on the joints, friction not yet taken off."""
        torque: Vector = self.nm_per_count * pwm
        torque -= self.braking_nms_rad * dq_rad_s
        return torque
