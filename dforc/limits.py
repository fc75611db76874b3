"""The postures a limb may take: a range per joint and linear rows over several joints."""

from dataclasses import dataclass, replace

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant
from dforc.errors import LimitsError
from dforc.quadratic import NoSolutionError, minimise

ROUNDING = 1e-9  # rad: what the projection may leave outside a row


@dataclass(frozen=True, slots=True, eq=False)
class JointLimits:
    """lower <= q <= upper [rad] and row_lower <= A q <= row_upper.

    Rows are robot data: cables and covers of the iCub's shoulder and elbow tie joints together.
    A side that is open is -inf or +inf. Make one with `make`, which checks and copies.
    """

    lower_rad: Vector  # (n,)
    upper_rad: Vector  # (n,)
    A: Matrix  # (m, n), m may be 0
    row_lower: Vector  # (m,)
    row_upper: Vector  # (m,)

    @classmethod
    def make(
        cls,
        lower_rad: ArrayLike,
        upper_rad: ArrayLike,
        A: Matrix | None = None,
        row_lower: ArrayLike = (),
        row_upper: ArrayLike = (),
    ) -> "JointLimits":
        """Limits with read-only copies of everything.

        Raises:
            LimitsError: shapes that do not fit, NaN, or limits that leave no posture.
        """
        lower, upper = constant(lower_rad), constant(upper_rad)
        rows = constant(np.zeros((0, len(lower))) if A is None else A)
        limits = cls(lower, upper, rows, constant(row_lower), constant(row_upper))
        limits._check()
        return limits

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.lower_rad)

    def with_ranges(self, lower_rad: ArrayLike, upper_rad: ArrayLike) -> "JointLimits":
        """The same rows with other joint ranges, checked."""
        limits = replace(self, lower_rad=constant(lower_rad), upper_rad=constant(upper_rad))
        limits._check()
        return limits

    def violation(self, q_rad: Vector) -> float:
        """Largest distance outside any limit or row; negative when inside all of them."""
        worst = max(float((self.lower_rad - q_rad).max()), float((q_rad - self.upper_rad).max()))
        if len(self.A):
            rows = self.A @ q_rad
            worst = max(worst, float((self.row_lower - rows).max()))
            worst = max(worst, float((rows - self.row_upper).max()))
        return worst

    def project(self, q_rad: Vector) -> Vector:
        """The nearest posture (least squares) inside all limits and rows (rows to 1e-9)."""
        clipped: Vector = np.clip(q_rad, self.lower_rad, self.upper_rad)
        if not len(self.A) or self.violation(clipped) <= ROUNDING:
            return clipped
        nearest = minimise(np.eye(self.n), -np.asarray(q_rad, dtype=np.float64), *self.stacked())
        result: Vector = np.clip(nearest, self.lower_rad, self.upper_rad)
        return result

    def stacked(self) -> tuple[Matrix, Vector, Vector]:
        """Ranges and rows as one system: C (n + m, n), lower and upper (n + m,)."""
        return (
            np.vstack([np.eye(self.n), self.A]),
            np.concatenate([self.lower_rad, self.row_lower]),
            np.concatenate([self.upper_rad, self.row_upper]),
        )

    def _check(self) -> None:
        n, m = self.n, len(self.A)
        if self.upper_rad.shape != (n,) or self.A.shape != (m, n):
            raise LimitsError(f"limits of {n} joints with rows of shape {self.A.shape}")
        if self.row_lower.shape != (m,) or self.row_upper.shape != (m,):
            raise LimitsError(f"{m} rows need {m} lower and {m} upper bounds")
        _, lower, upper = self.stacked()
        wrong = np.flatnonzero(~(lower <= upper))  # also catches NaN
        if len(wrong):
            i = int(wrong[0])
            name = f"joint {i}" if i < n else f"row {i - n}"
            raise LimitsError(f"{name}: lower limit {lower[i]} is not below upper limit {upper[i]}")
        if not np.isfinite(self.A).all():
            raise LimitsError("the rows hold NaN or infinity")
        middle = np.clip(np.zeros(n), self.lower_rad, self.upper_rad)
        try:
            self.project(middle)
        except NoSolutionError as error:
            raise LimitsError(f"no posture keeps all rows within the joint ranges: {error}") from error
