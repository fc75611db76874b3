"""One request to inverse kinematics, checked and brought into the solver's form."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError, ShapeError
from dforc.limits import JointLimits
from dforc.path_following import Constraints

ROW_MARGIN_RAD = 1e-7  # rows are kept this far inside, so that rounding never crosses one
ORTHOGONAL = 1e-6  # how far R_d R_d' may be from the identity
AT_BOUND_RAD = 1e-9
TARGET = 12  # leading parameters: x_d, then R_d


@dataclass(frozen=True, slots=True, eq=False)
class IkRequest:
    """What one solve is to reach, from where, and within what."""

    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)
    q_start: Vector  # (n,), inside limits and rows
    parameters: Vector  # of dforc.symbolic.reaching
    constraints: Constraints  # limits, rows and the step of this solve
    step_bounded: bool

    def target_moved(self, other: "IkRequest") -> float:
        """Largest change of a coordinate [m] or of an element of the rotation matrix."""
        return float(np.abs(self.parameters[:TARGET] - other.parameters[:TARGET]).max())

    def same_range(self, other: "IkRequest") -> bool:
        """Whether the joints may go to the same places."""
        a, b = self.constraints, other.constraints
        return np.array_equal(a.lower, b.lower) and np.array_equal(a.upper, b.upper)

    def confining(self, q: Vector, limits: JointLimits) -> NDArray[np.bool_]:
        """Which joints (n,) are held at q by this request alone, not by their own limits."""
        lower, upper = self.constraints.lower[: len(q)], self.constraints.upper[: len(q)]
        below = (q - lower < AT_BOUND_RAD) & (lower > limits.lower_rad + AT_BOUND_RAD)
        above = (upper - q < AT_BOUND_RAD) & (upper < limits.upper_rad - AT_BOUND_RAD)
        held: NDArray[np.bool_] = below | above
        return held


class RequestCheck:
    """Makes requests for one limb."""

    def __init__(self, limits: JointLimits, posture: Vector) -> None:
        """Keep limits and the posture's parameters, q_rest and w (2n,)."""
        self._limits = limits
        self._posture = posture
        margin = np.minimum(ROW_MARGIN_RAD, 0.25 * (limits.upper - limits.lower))
        margin[: limits.n] = 0.0
        self._lower = constant(limits.lower + margin)
        self._upper = constant(limits.upper - margin)

    def request(
        self,
        position_m: ArrayLike,
        rotation: Matrix,
        q_start_rad: ArrayLike,
        step_limit_rad: float | ArrayLike,
        blocked: Sequence[bool] | None,
    ) -> IkRequest:
        """The arguments of `InverseKinematics.solve`.

        Raises:
            NotFiniteError: NaN or infinity among them, or a negative step.
            ShapeError: a vector of another length, or R_d is no rotation.
        """
        n = self._limits.n
        position = finite_vector("target position", position_m, 3)
        q_start = finite_vector("start posture", q_start_rad, n)
        R = checked_rotation(rotation)
        if self._limits.violation(q_start) > 0.0:
            q_start = self._limits.project(q_start)
        step = np.broadcast_to(np.asarray(step_limit_rad, dtype=np.float64), (n,))
        if not (step >= 0.0).all():  # also catches NaN
            raise NotFiniteError(f"joint step must be >= 0, not {step.tolist()}")
        bounded = bool(np.isfinite(step).all())
        if blocked is not None:
            step = np.where(np.asarray(blocked, dtype=bool), 0.0, step)
        lower, upper = self._lower.copy(), self._upper.copy()
        lower[:n] = np.maximum(lower[:n], q_start - step)
        upper[:n] = np.minimum(upper[:n], q_start + step)
        parameters = np.concatenate([position, R.flatten("F"), self._posture])
        constraints = Constraints(self._limits.C, lower, upper)
        return IkRequest(position, R, q_start, parameters, constraints, bounded)


def checked_rotation(rotation: Matrix) -> Matrix:
    """A copy of a rotation matrix (3, 3).

    Raises:
        ShapeError: another shape, or no rotation.
        NotFiniteError: NaN or infinity.
    """
    R = np.array(rotation, dtype=np.float64)
    if R.shape != (3, 3):
        raise ShapeError(f"target rotation has shape {R.shape}, expected (3, 3)")
    if not np.isfinite(R).all():
        raise NotFiniteError(f"target rotation is not finite: {R.tolist()}")
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if np.abs(R @ R.T - np.eye(3)).max() > ORTHOGONAL or determinant < 0.0:
        raise ShapeError(f"target rotation is no rotation matrix: {R.tolist()}")
    return R
