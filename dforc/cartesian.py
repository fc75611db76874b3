"""Cartesian controller: two minimum-jerk generators on an internal plan, and an outer correction.

Multi-referential scheme (DForC section III-A; Hersch and Billard): a generator in joint space
draws the plan to the posture q_d that inverse kinematics found, one in task space draws it to the
pose (x_d, R_d) along a straight line, and Lagrange multipliers join the two speeds:

    dq = v_q + W J' (I + J W J')^-1 (v_x - J v_q),   W = diag(gamma_i(q))

The plan runs open loop (q_plan); the target's own velocity is fed forward, so a moving target is
followed without lag. Below it the integral of the measured error of the hand against the plan moves the
joint reference (this takes out friction, gravity and compliance), and is frozen while something pushes
the arm, so that a compliant arm stays compliant.

Lengths in m, angles in rad, base frame, joint vectors (n,) in the order of the model.
"""

from dataclasses import dataclass
from typing import Protocol

from dforc.arrays import Matrix, Vector
from dforc.limits import JointLimits


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianParams:
    """Tuning of the controller; the integrator may override any of it."""

    period_s: float = 0.01
    trajectory_time_s: float = 0.5  # T: duration of a move to a target that jumps
    force_on_n: float = 2.0  # external force that freezes the outer correction
    force_off_n: float = 1.2
    outer_gain_per_s: float = 4.0  # 0 switches the outer correction off


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianTarget:
    """Where the hand is to be now, and the posture that reaches it."""

    position_m: Vector  # x_d (3,)
    rotation: Matrix  # R_d (3, 3)
    q_rad: Vector  # q_d (n,), IK's answer for (almost) this pose
    velocity_m_s: Vector  # dx_d (3,), zeros for a target at rest


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What is known of the arm now."""

    q_rad: Vector  # (n,)
    external_force_n: float  # norm of the estimated force at the hand; 0 when unknown


@dataclass(frozen=True, slots=True)
class CartesianState:
    """Everything the controller carries from tick to tick. Make the first with `start`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianOutput:
    """The reference for the joints, and what to report."""

    q_rad: Vector  # q_ref (n,): inside limits and rows
    dq_rad_s: Vector  # velocity of the plan (n,)
    plan_q_rad: Vector
    plan_position_m: Vector  # (3,)
    plan_rotation: Matrix
    position_error_m: float  # measured hand to the target
    orientation_error_rad: float
    plan_error_m: float  # measured hand to the plan
    gated: bool  # the outer correction is frozen
    saturated: bool  # the outer correction is at its bound


class HandKinematics(Protocol):
    """What the controller asks of dforc.robot_model.RobotModel."""

    n: int

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]: ...

    def tip_jacobian(self, q_rad: Vector) -> Matrix: ...


class CartesianController:
    """The controller's constants; all that changes is in the state handed in and out."""

    def __init__(
        self, model: HandKinematics, limits: JointLimits, params: CartesianParams = CartesianParams()
    ) -> None: ...

    def start(self, q_ref_rad: Vector) -> CartesianState:
        """At rest at the reference that the joints hold now (not the measured posture: no jump)."""
        raise NotImplementedError

    def step(
        self, state: CartesianState, measured: Measurement, target: CartesianTarget | None
    ) -> tuple[CartesianState, CartesianOutput]:
        """One period. `target` None: the plan stops smoothly within T and holds.

        Raises:
            NotFiniteError: an input holds NaN or infinity; keep the old state and send no command.
        """
        raise NotImplementedError
