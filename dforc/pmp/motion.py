"""Passive Motion Paradigm: a virtual arm that gives way to the forces on its hand (Table I, 8).

F  = K (x_t - x) and eq. 5 of the obstacles, at the hand
T  = J' F + alpha S(q)
dq = Gamma(t) A T
x  = integral of J dq (variant A, eq. 6) or kin(integral of dq) (variant B, eq. 7)

Explicit Euler, 10 ms in the papers. Base frame; joint vectors in the order of the kinematics.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from dforc import rotation
from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError
from dforc.field.force import FieldParams, scene_of
from dforc.field.kernel_force import Scene, add_repulsion
from dforc.field.rollout import PERIOD_S
from dforc.kinematics import HandKinematics
from dforc.pmp.fields import limit_field, time_base
from dforc.pmp.params import Orientation, PmpError, PmpParams, Variant, per_joint

NO_OBSTACLES = scene_of((), (), FieldParams())


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PmpTarget:
    """A place for the hand, and an orientation where one is wanted."""

    position_m: Vector  # (3,)
    rotation: Matrix | None = None  # (3, 3)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PmpState:
    """The virtual arm: posture, the point that Table I calls x, and the time since the start."""

    q_rad: Vector  # (n,)
    dq_rad_s: Vector  # (n,) of the last step
    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)
    time_s: float


class PmpPath(NamedTuple):
    """Postures (k, n), positions (k, 3) and rotations (k, 3, 3), the start first."""

    q_rad: Matrix
    positions_m: Matrix
    rotations: Matrix


class Pmp:
    """One virtual arm. It holds constants only: whoever asks keeps the state."""

    def __init__(
        self,
        kinematics: HandKinematics,
        lower_rad: ArrayLike,
        upper_rad: ArrayLike,
        params: PmpParams,
    ) -> None:
        """Raise PmpError where limits or constants do not belong to the joints."""
        n = kinematics.n
        self.params = params
        self._kinematics = kinematics
        self._lower = constant(finite_vector("lower limits", lower_rad, n))
        self._upper = constant(finite_vector("upper limits", upper_rad, n))
        wrong = np.flatnonzero(self._lower >= self._upper)
        if len(wrong):
            raise PmpError(f"joint {wrong[0]}: its lower limit is not below its upper one")
        self._limit_gain = self._joints("limit gain", params.limit_gain_nm)
        self._admittance = self._joints("admittance", params.admittance_rad_nms)

    def begin(self, q_rad: ArrayLike) -> PmpState:
        """The arm at rest in a posture, at time zero."""
        q = constant(finite_vector("the posture", q_rad, self._kinematics.n))
        R, p = self._kinematics.tip_pose(q)
        return PmpState(q_rad=q, dq_rad_s=np.zeros(len(q)), position_m=p, rotation=R, time_s=0.0)

    def again(self, state: PmpState) -> PmpState:
        """The same arm with its clock at zero: for a new target."""
        return replace(state, time_s=0.0)

    def step(
        self,
        state: PmpState,
        target: PmpTarget,
        obstacles: Scene = NO_OBSTACLES,
        dt_s: float = PERIOD_S,
    ) -> PmpState:
        """Move the arm by one period. `obstacles` is a scene of the force field.

        Raises:
            NotFiniteError: target or dt_s is not finite, or the result would not be.
            PmpError: a dt_s that is not positive.
        """
        _refuse_bad_input(target, dt_s)
        J = self._kinematics.tip_jacobian(state.q_rad)
        torque = J.T @ self._wrench(state, target, obstacles)
        torque += self._limit_gain * limit_field(state.q_rad, self._lower, self._upper)
        dq = self._gain(state.time_s) * self._admittance * torque
        q: Vector = state.q_rad + dt_s * dq
        if self.params.clamped:
            q = np.clip(q, self._lower, self._upper)
            dq = (q - state.q_rad) / dt_s
        if not np.isfinite(q).all():
            raise NotFiniteError(f"PMP drives the arm from {state.q_rad} beyond all numbers")
        R, p = self._hand(state, q, J @ dq, dt_s)
        return PmpState(q_rad=q, dq_rad_s=dq, position_m=p, rotation=R, time_s=state.time_s + dt_s)

    def roll_out(
        self,
        state: PmpState,
        target: PmpTarget,
        obstacles: Scene = NO_OBSTACLES,
        *,
        steps: int,
        dt_s: float = PERIOD_S,
    ) -> PmpPath:
        """Where the arm would go in `steps` periods if nothing changed; nothing is moved."""
        states = [state]
        for _ in range(steps):
            states.append(self.step(states[-1], target, obstacles, dt_s))
        return PmpPath(
            np.array([s.q_rad for s in states]),
            np.array([s.position_m for s in states]),
            np.array([s.rotation for s in states]),
        )

    def _wrench(self, state: PmpState, target: PmpTarget, obstacles: Scene) -> Vector:
        """Force and torque on the hand (6,), about its origin."""
        wrench = np.zeros(6)
        wrench[:3] = self.params.stiffness_n_m * (target.position_m - state.position_m)
        add_repulsion(state.position_m, obstacles, wrench[:3])
        if target.rotation is not None and self.params.orientation is not Orientation.NONE:
            error = self._turn(state.rotation, target.rotation)
            wrench[3:] = self.params.angular_stiffness_nm_rad * error
        return wrench

    def _turn(self, R: Matrix, wanted: Matrix) -> Vector:
        if self.params.orientation is Orientation.LOG:
            return rotation.rotation_error(R, wanted)
        return rotation.rotation_vector(wanted) - rotation.rotation_vector(R)

    def _gain(self, time_s: float) -> float:
        if not self.params.has_time_base:
            return 1.0
        return time_base(time_s, self.params.duration_s, self.params.epsilon)

    def _hand(
        self, state: PmpState, q: Vector, twist: Vector, dt_s: float
    ) -> tuple[Matrix, Vector]:
        if self.params.variant is Variant.B:
            return self._kinematics.tip_pose(q)
        R = rotation.matrix(dt_s * twist[3:]) @ state.rotation
        return R, state.position_m + dt_s * twist[:3]

    def _joints(self, name: str, value: float | tuple[float, ...]) -> Vector:
        n = self._kinematics.n
        values = per_joint(value, n)
        if len(values) != n:
            raise PmpError(f"PMP's {name} has {len(values)} values for {n} joints")
        return constant(values)


def _refuse_bad_input(target: PmpTarget, dt_s: float) -> None:
    total = float(np.sum(target.position_m)) + dt_s
    if target.rotation is not None:
        total += float(np.sum(target.rotation))
    if not np.isfinite(total):
        raise NotFiniteError(f"PMP was given {target}, period {dt_s} s")
    if dt_s <= 0.0:
        raise PmpError(f"period must be positive, not {dt_s} s")
