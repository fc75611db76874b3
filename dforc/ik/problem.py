"""What inverse kinematics is asked for: eq. 1 of DForC, eq. 11 of the force control paper.

    q* = argmin |alpha_d - K_alpha(q)|^2 + beta (q_rest - q)' W (q_rest - q)
    subject to |x_d - K_x(q)|^2 <= eps,  q_L <= q <= q_U,  row_L <= A q <= row_U

|alpha_d - K_alpha(q)| is the angle of R_d R(q)'. With the other priority orientation is the
condition and position the cost. Any number of tips may be asked for at once (both hands over one
waist): costs add up, conditions stand beside each other.

A problem is a value: everything in it may be another from one answer to the next, and nothing is
built or compiled for it. Lengths in m, angles in rad, base frame, joint vectors (n,) in the order
of the model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import LimitsError, NotFiniteError, ShapeError
from dforc.kinematics import ChainKinematics
from dforc.limits import JointLimits

ORTHOGONAL = 1e-6  # how far R R' may be from the identity
POSITION_WEIGHT = 100.0  # rad^2/m^2: what 1 m^2 costs where orientation is the condition

Flags = NDArray[np.bool_]


class Priority(StrEnum):
    """Which part of a pose is the condition; the other one is a cost."""

    POSITION = "position"
    ORIENTATION = "orientation"


@dataclass(frozen=True, slots=True, eq=False)
class Tip:
    """A frame of the robot that is to be placed: the model's tip, or one attached to it."""

    name: str
    model: ChainKinematics  # over all joints of the problem
    offset_rotation: Matrix = field(default_factory=lambda: constant(np.eye(3)))
    offset_m: Vector = field(default_factory=lambda: constant(np.zeros(3)))
    is_attached: bool = False  # whether there is an offset at all

    @property
    def n(self) -> int:
        """Joints."""
        return self.model.n

    def attached(self, rotation: Matrix, offset_m: ArrayLike) -> "Tip":
        """The same link with the tip frame moved by (R (3, 3), p (3,)) in the model's tip frame.

        Raises:
            ShapeError, NotFiniteError: no rotation, or not finite.
        """
        return replace(
            self,
            offset_rotation=constant(checked_rotation(rotation)),
            offset_m=constant(finite_vector("tip offset", offset_m, 3)),
            is_attached=True,
        )

    def pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,), by the model's own kinematics."""
        R, p = self.model.tip_pose(q_rad)
        if not self.is_attached:
            return R, p
        return R @ self.offset_rotation, p + R @ self.offset_m

    def jacobian(self, q_rad: Vector) -> Matrix:
        """Geometric Jacobian (6, n), linear rows first."""
        J = self.model.tip_jacobian(q_rad)
        if not self.is_attached:
            return J
        R, _ = self.model.tip_pose(q_rad)
        lever = R @ self.offset_m
        moved = J.copy()
        moved[:3] += np.cross(J[3:].T, lever).T
        return moved


@dataclass(frozen=True, slots=True, eq=False)
class TipTarget:
    """Where a tip is to be; None for a part that does not matter."""

    position_m: Vector | None  # (3,)
    rotation: Matrix | None  # (3, 3)

    @classmethod
    def checked(cls, position_m: ArrayLike | None, rotation: Matrix | None) -> "TipTarget":
        """A copy.

        Raises:
            NotFiniteError: NaN or infinity.
            ShapeError: another shape, or no rotation matrix.
        """
        return cls(
            None if position_m is None else finite_vector("target position", position_m, 3),
            None if rotation is None else checked_rotation(rotation),
        )


class ExtraConstraints(Protocol):
    """Inequalities beyond limits and rows, such as distances to obstacles: h(q) >= 0."""

    size: int  # m

    def evaluate(self, q_rad: Vector) -> tuple[Vector, Matrix]:
        """H (m,) and its derivative dh/dq (m, n)."""
        ...


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IkProblem:
    """All but the target. Make one with `make`, and others from it with `changed`."""

    tips: tuple[Tip, ...]
    limits: JointLimits
    rest_rad: Vector  # (n,)
    rest_weights: Vector  # (n,), diagonal of W; 0 = free
    free: Flags  # (n,); the others stay where a search starts
    beta: float = 0.01  # rad^2 of orientation error that one rad^2 of W-weighted posture is worth
    position_tolerance_m: float = 1e-4  # sqrt(eps)
    orientation_tolerance_rad: float = 1e-3  # where orientation is the condition
    priority: Priority = Priority.POSITION
    extra: ExtraConstraints | None = None

    @property
    def n(self) -> int:
        """Joints."""
        return self.limits.n

    @classmethod
    def make(
        cls,
        tips: Sequence[Tip],
        limits: JointLimits,
        rest_rad: ArrayLike,
        rest_weights: ArrayLike,
    ) -> "IkProblem":
        """A problem with all joints free and the defaults of the rest.

        Raises:
            LimitsError, NotFiniteError, ShapeError: what does not fit together.
        """
        return cls(
            tips=tuple(tips),
            limits=limits,
            rest_rad=np.asarray(rest_rad, dtype=np.float64),
            rest_weights=np.asarray(rest_weights, dtype=np.float64),
            free=np.ones(limits.n, dtype=np.bool_),
        ).changed()

    def changed(self, **changes: object) -> "IkProblem":
        """Another problem that differs in the named fields.

        A rest posture outside the limits is taken as it is: a cost pulls towards it, and the
        answer stays inside.

        Raises:
            LimitsError, NotFiniteError, ShapeError: what does not fit together.
            TypeError: there is no such field.
        """
        problem: IkProblem = replace(self, **changes)  # type: ignore[arg-type]  # checked below
        n = problem.n
        if not problem.tips:
            raise ShapeError("no tip to place")
        for tip in problem.tips:
            if tip.n != n:
                raise ShapeError(f"tip {tip.name}: {tip.n} joints, limits of {n}")
        weights = finite_vector("rest weights", problem.rest_weights, n)
        if weights.min(initial=0.0) < 0.0:
            raise LimitsError(f"rest weights must not be negative: {weights.tolist()}")
        free = np.array(problem.free, dtype=np.bool_)
        if free.shape != (n,):
            raise ShapeError(f"{free.size} flags of free joints, {n} joints")
        free.setflags(write=False)
        for name in ("beta", "position_tolerance_m", "orientation_tolerance_rad"):
            value = getattr(problem, name)
            if not (np.isfinite(value) and value > 0.0):
                raise NotFiniteError(f"{name} must be a positive number, not {value}")
        return replace(
            problem,
            rest_rad=constant(finite_vector("rest posture", problem.rest_rad, n)),
            rest_weights=constant(weights),
            free=free,
            priority=Priority(problem.priority),
        )


def checked_rotation(rotation: Matrix) -> Matrix:
    """A copy of a rotation matrix (3, 3).

    Raises:
        ShapeError: another shape, or no rotation.
        NotFiniteError: NaN or infinity.
    """
    R = np.array(rotation, dtype=np.float64)
    if R.shape != (3, 3):
        raise ShapeError(f"target rotation has shape {R.shape}, expected (3, 3)")
    rows: list[list[float]] = R.tolist()
    (a, b, c), (d, e, f), (g, h, i) = rows
    if not np.isfinite(a + b + c + d + e + f + g + h + i):
        raise NotFiniteError(f"target rotation is not finite: {rows}")
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    off = max(
        abs(a * a + b * b + c * c - 1.0),
        abs(d * d + e * e + f * f - 1.0),
        abs(g * g + h * h + i * i - 1.0),
        abs(a * d + b * e + c * f),
        abs(a * g + b * h + c * i),
        abs(d * g + e * h + f * i),
    )
    if off > ORTHOGONAL or determinant < 0.0:
        raise ShapeError(f"target rotation is no rotation matrix: {rows}")
    return R
