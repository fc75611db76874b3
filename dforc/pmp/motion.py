"""Passive Motion Paradigm: a virtual arm that gives way to the forces on its hand (Table I, 8).

F  = K (x_t - x) and eq. 5 of the obstacles, at the hand
T  = J' F + alpha S(q)
dq = Gamma(t) A T
x  = integral of J dq (variant A, eq. 6) or kin(integral of dq) (variant B, eq. 7)

Explicit Euler, 10 ms in the papers. Base frame; joint vectors in the order of the kinematics.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError
from dforc.field.force import FieldParams, scene_of
from dforc.field.kernel_force import Scene
from dforc.field.rollout import PERIOD_S
from dforc.ik.kernel_chain import chain_arrays
from dforc.kinematics import ChainKinematics
from dforc.pmp.kernel_motion import (
    LOGARITHM,
    NOT_TURNED,
    RAW,
    ArmConstants,
    Pull,
    move,
    move_many,
    place_tip,
)
from dforc.pmp.params import Orientation, PmpError, PmpParams, Variant, per_joint

NO_OBSTACLES = scene_of((), (), FieldParams())
MOST_STEPS = 1_000_000  # of a roll-out
TURNED = {Orientation.NONE: NOT_TURNED, Orientation.RAW: RAW, Orientation.LOG: LOGARITHM}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PmpTarget:
    """A place for the hand, and an orientation where one is wanted."""

    position_m: Vector  # (3,)
    rotation: Matrix | None = None  # (3, 3)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PmpState:
    """The virtual arm: posture, the pose that Table I calls x, and the time since the start."""

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
        kinematics: ChainKinematics,
        lower_rad: ArrayLike,
        upper_rad: ArrayLike,
        params: PmpParams,
    ) -> None:
        """Raise PmpError where limits or constants do not belong to the joints."""
        n = kinematics.n
        self.n, self.params = n, params
        self._chain = chain_arrays(kinematics.chain_description())
        lower = constant(finite_vector("lower limits", lower_rad, n))
        upper = constant(finite_vector("upper limits", upper_rad, n))
        wrong = np.flatnonzero(lower >= upper)
        if len(wrong):
            raise PmpError(f"joint {wrong[0]}: its lower limit is not below its upper one")
        self._arm = ArmConstants(
            lower_rad=lower,
            upper_rad=upper,
            limit_gain_nm=_joints("limit gain", params.limit_gain_nm, n),
            admittance_rad_nms=_joints("admittance", params.admittance_rad_nms, n),
            stiffness_n_m=params.stiffness_n_m,
            angular_stiffness_nm_rad=params.angular_stiffness_nm_rad,
            has_time_base=params.has_time_base,
            duration_s=params.duration_s,
            epsilon=params.epsilon,
            clamped=params.clamped,
            integrates=params.variant == Variant.A,
        )

    def hand(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,) of the hand in a posture."""
        x, R = np.empty(3), np.empty((3, 3))
        place_tip(q_rad, self._chain, x, R)
        return R, x

    def begin(self, q_rad: ArrayLike) -> PmpState:
        """The arm at rest in a posture, at time zero."""
        q = finite_vector("the posture", q_rad, self.n)
        R, x = self.hand(q)
        return PmpState(q_rad=q, dq_rad_s=np.zeros(self.n), position_m=x, rotation=R, time_s=0.0)

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
        """Move the arm by one period; `obstacles` is a scene of the force field.

        Raises:
            NotFiniteError: target or dt_s is not finite, or the result would not be.
            ShapeError: a target of another shape.
            PmpError: a dt_s that is not positive.
        """
        pull = self._pull(target, dt_s)
        q, dq = state.q_rad.copy(), np.empty(self.n)
        x, R = state.position_m.copy(), state.rotation.copy()
        move(q, dq, x, R, state.time_s, pull, obstacles, self._chain, self._arm, dt_s)
        _refuse_runaway(state, q, x)
        return PmpState(q_rad=q, dq_rad_s=dq, position_m=x, rotation=R, time_s=state.time_s + dt_s)

    def roll_out(
        self,
        state: PmpState,
        target: PmpTarget,
        obstacles: Scene = NO_OBSTACLES,
        *,
        steps: int,
        dt_s: float = PERIOD_S,
    ) -> PmpPath:
        """Where the arm would go in `steps` periods if nothing changed; nothing is moved.

        Raises what `step` raises, and PmpError for a number of steps outside 0..MOST_STEPS.
        """
        pull = self._pull(target, dt_s)
        if not 0 <= steps <= MOST_STEPS:
            raise PmpError(f"a roll-out of {steps} steps is outside 0..{MOST_STEPS}")
        path = PmpPath(
            np.empty((steps + 1, self.n)), np.empty((steps + 1, 3)), np.empty((steps + 1, 3, 3))
        )
        q, x, R = path
        q[0], x[0], R[0] = state.q_rad, state.position_m, state.rotation
        move_many(q, x, R, state.time_s, pull, obstacles, self._chain, self._arm, dt_s)
        _refuse_runaway(state, q[-1], x[-1])
        return path

    def _pull(self, target: PmpTarget, dt_s: float) -> Pull:
        if not math.isfinite(dt_s):
            raise NotFiniteError(f"PMP was given a period of {dt_s} s")
        if dt_s <= 0.0:
            raise PmpError(f"period must be positive, not {dt_s} s")
        position = finite_vector("the target", target.position_m, 3)
        if target.rotation is None:
            return Pull(position, np.eye(3), NOT_TURNED)
        rotation = finite_vector("the target's rotation", target.rotation.ravel(), 9)
        return Pull(position, rotation.reshape(3, 3), TURNED[self.params.orientation])


def _joints(name: str, value: float | tuple[float, ...], n: int) -> Vector:
    values = per_joint(value, n)
    if len(values) != n:
        raise PmpError(f"PMP's {name} has {len(values)} values for {n} joints")
    return constant(values)


def _refuse_runaway(state: PmpState, q_rad: Vector, position_m: Vector) -> None:
    if not (np.isfinite(q_rad).all() and np.isfinite(position_m).all()):
        raise NotFiniteError(f"PMP drives the arm from {state.q_rad} beyond all numbers")
