"""Cartesian controller: two minimum-jerk generators on an internal plan, and an outer correction.

Multi-referential scheme (DForC section III-A): a generator in joint space draws the plan to the
posture q_d that inverse kinematics found, one in task space draws it to the pose (x_d, R_d) along
a straight line, and dforc.cartesian.coupling joins their speeds. The plan (q_plan) runs open loop:
the arm's lag cannot shake it. Both generators work on the error against the target in motion, so a
target whose velocity is told is followed without lag. A target that jumps is reached in minimum
jerk after T; after that, and for a target that moves smoothly, the time to go stays at its floor.

Below the plan, dforc.cartesian.outer_correction moves the reference of compliant joints by the
integral of their measured error.

Lengths in m, angles in rad, base frame, joint vectors (n,) in the order of the model; task vectors
(6,) hold the linear part, then the angular one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.cartesian.aim import Aim, AimTimes, Target
from dforc.cartesian.coupling import Coupling, CouplingParams
from dforc.cartesian.min_jerk import Motion, advance
from dforc.cartesian.outer_correction import CorrectionParams, CorrectionState, corrected
from dforc.errors import NotFiniteError
from dforc.kinematics import HandKinematics
from dforc.limits import JointLimits
from dforc.rotation import rotation_error

STOP_SHARE = 0.4  # of speed times T: where a minimum-jerk stop comes to rest without turning back


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianParams:
    """Tuning of the controller.

    `following_time_s` is the floor of the task's time to go: the plan trails an acceleration a of
    the target by 0.15 of its square times a, and overshoots a corner by 0.2 of it times the change
    of speed. `lead_s` moves the reference ahead by the plan's speed, against a lag of the boards
    below: it helps a stiff arm whose back-EMF is not compensated, and makes a compliant arm with
    compensation overshoot (5 mm of clearance lost at 40 ms).
    """

    period_s: float = 0.01
    trajectory_time_s: float = 0.5  # T: duration of the move to a target that jumps
    following_time_s: float = 0.05
    posture_time_s: float = 0.3  # floor of the joints' time to go
    lead_s: float = 0.0
    coupling: CouplingParams = field(default_factory=CouplingParams)
    correction: CorrectionParams = field(default_factory=CorrectionParams)


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianTarget:
    """Where the hand is to be now, and the posture that reaches it."""

    position_m: ArrayLike  # x_d (3,)
    rotation: Matrix  # R_d (3, 3)
    q_rad: ArrayLike  # q_d (n,): the answer of inverse kinematics for (almost) this pose
    velocity_m_s: ArrayLike = (0.0, 0.0, 0.0)  # dx_d (3,); zeros for a target at rest


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What is known of the arm now."""

    q_rad: ArrayLike  # (n,)
    compliant: Sequence[bool]  # (n,), joints without an integrator of their own
    external_force_n: float = 0.0  # norm of the estimated force on the hand


@dataclass(frozen=True, slots=True, eq=False)
class CartesianState:
    """What the controller carries from period to period. The first comes from `start`."""

    q_plan: Vector  # (n,)
    dq_plan: Vector
    joint_velocity: Vector  # (n,) of the joint generator
    joint_acceleration: Vector
    task_velocity: Vector  # (6,) of the task generator
    task_acceleration: Vector
    aim: Aim
    correction: CorrectionState


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CartesianOutput:
    """The reference for the joints, and what to report."""

    q_rad: Vector  # q_ref (n,): inside the joint ranges
    dq_rad_s: Vector  # velocity of the plan (n,)
    plan_q_rad: Vector  # (n,)
    plan_position_m: Vector  # (3,) at the time of the measurement
    plan_rotation: Matrix
    position_error_m: float  # measured hand to the target
    orientation_error_rad: float
    plan_error_m: float  # measured hand to the plan
    held: bool  # no target
    gated: bool  # the correction stands still because something pushes the arm
    saturated: bool  # the correction is at its bound


class CartesianController:
    """The controller's constants; all that changes is in the state handed in and out."""

    def __init__(
        self,
        model: HandKinematics,
        limits: JointLimits,
        params: CartesianParams | None = None,
    ) -> None:
        """Keep model, limits and tuning.

        Args:
            model: kinematics of the hand.
            limits: ranges and rows that plan and reference keep.
            params: tuning.
        """
        self._model = model
        self._limits = limits
        self._params = params or CartesianParams()
        self._times = AimTimes(
            trajectory_s=self._params.trajectory_time_s,
            following_s=self._params.following_time_s,
            posture_s=self._params.posture_time_s,
        )
        self._coupling = Coupling(limits, self._params.coupling)

    def start(self, q_ref_rad: ArrayLike) -> CartesianState:
        """At rest at the reference that the joints hold now (not the measured posture: no jump)."""
        n = self._model.n
        q = self._limits.project(finite_vector("reference", q_ref_rad, n))
        R, p = self._model.tip_pose(q)
        target = Target(p, R, np.zeros(6), q)
        return CartesianState(
            q_plan=q,
            dq_plan=np.zeros(n),
            joint_velocity=np.zeros(n),
            joint_acceleration=np.zeros(n),
            task_velocity=np.zeros(6),
            task_acceleration=np.zeros(6),
            aim=Aim(target, self._times.posture_s, self._times.following_s, held=True),
            correction=CorrectionState.none(n),
        )

    def step(
        self, state: CartesianState, measured: Measurement, target: CartesianTarget | None
    ) -> tuple[CartesianState, CartesianOutput]:
        """One period. `target` None: the plan stops in minimum jerk and holds.

        Raises:
            NotFiniteError: an input holds NaN or infinity; keep the old state, send no command.
        """
        q_measured = finite_vector("measured posture", measured.q_rad, self._model.n)
        if not np.isfinite(measured.external_force_n):
            raise NotFiniteError(f"external force is {measured.external_force_n}")
        aim = self._aim(state, target)
        R, p = self._model.tip_pose(state.q_plan)
        R_measured, p_measured = self._model.tip_pose(q_measured)
        error = np.concatenate([p - p_measured, rotation_error(R_measured, R)])
        correction = corrected(
            state.correction,
            state.q_plan - q_measured,
            measured.compliant,
            measured.external_force_n,
            self._params.period_s,
            self._params.correction,
        )
        after, dq = self._moved(state, aim, (R, p), correction)
        after, q_ref = self._referenced(after, dq)
        return after, CartesianOutput(
            q_rad=q_ref,
            dq_rad_s=dq,
            plan_q_rad=after.q_plan,
            plan_position_m=p,
            plan_rotation=R,
            position_error_m=_length(aim.target.position - p_measured),
            orientation_error_rad=_length(rotation_error(R_measured, aim.target.rotation)),
            plan_error_m=_length(error[:3]),
            held=aim.held,
            gated=correction.gated,
            saturated=after.correction.saturated,
        )

    def _aim(self, state: CartesianState, target: CartesianTarget | None) -> Aim:
        if target is None:
            return state.aim if state.aim.held else self._stop(state)
        checked = Target.checked(
            target.position_m, target.rotation, target.velocity_m_s, target.q_rad, self._model.n
        )
        return state.aim.followed(checked, self._times, self._params.period_s)

    def _stop(self, state: CartesianState) -> Aim:
        """Aim at where the plan comes to rest by itself."""
        T = self._params.trajectory_time_s
        q = self._limits.project(state.q_plan + (STOP_SHARE * T) * state.dq_plan)
        R, p = self._model.tip_pose(q)
        return Aim(Target(p, R, np.zeros(6), q), T, T, held=True)

    def _moved(
        self, state: CartesianState, aim: Aim, plan: tuple[Matrix, Vector], c: CorrectionState
    ) -> tuple[CartesianState, Vector]:
        """The plan one period later, and its joint speeds (n,)."""
        h, target = self._params.period_s, aim.target
        R, p = plan
        away = np.concatenate([p - target.position, rotation_error(target.rotation, R)])
        task = advance(
            Motion(away, state.task_velocity - target.velocity, state.task_acceleration),
            aim.task_time_s,
            h,
        )
        v_task = (task.error - away) / h + target.velocity
        beside = state.q_plan - target.q
        joint = advance(
            Motion(beside, state.joint_velocity, state.joint_acceleration), aim.joint_time_s, h
        )
        J = self._model.tip_jacobian(state.q_plan)
        v_joint = (joint.error - beside) / h
        dq, limited = self._coupling.speeds(state.q_plan, J, v_joint, v_task, h)
        task_velocity = task.velocity + target.velocity
        if limited:  # what limits took from the task's speed leaves its generator, or it winds up
            task_velocity += J @ dq - v_task
        q_plan = self._limits.project(state.q_plan + h * dq)
        after = CartesianState(
            q_plan,
            dq,
            joint.velocity,
            joint.acceleration,
            task_velocity,
            task.acceleration,
            aim,
            c,
        )
        return after, dq

    def _referenced(self, state: CartesianState, dq: Vector) -> tuple[CartesianState, Vector]:
        """q_ref inside the joint ranges; what they cut off is not kept in the correction.

        Not inside the rows: the correction is what a spring needs for the joint to stand at the
        plan, and the plan keeps the rows.
        """
        limits = self._limits
        wanted = state.q_plan + state.correction.offset_rad
        q = np.clip(wanted, limits.lower_rad, limits.upper_rad)
        if (q != wanted).any():
            kept = replace(state.correction, offset_rad=q - state.q_plan, saturated=True)
            state = replace(state, correction=kept)
        led = q + self._params.lead_s * dq
        return state, np.clip(led, limits.lower_rad, limits.upper_rad)


def _length(vector: Vector) -> float:
    return math.sqrt(float(vector @ vector))
