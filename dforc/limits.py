"""The postures a limb may take: a range per joint and linear rows over several joints."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant
from dforc.errors import LimitsError
from dforc.quadratic import NoSolutionError, minimise

ROUNDING = 1e-9  # rad: what the projection may leave outside a row


@dataclass(frozen=True, slots=True, eq=False)
class JointLimits:
    """lower <= q <= upper [rad] and row_lower <= A q <= row_upper, as one system C q.

    Rows are robot data: cables and covers of the iCub's shoulder and elbow tie joints together.
    A side that is open is -inf or +inf. Make one with `make`, which checks and copies.
    """

    n: int  # joints
    C: Matrix  # (n + m, n): identity over A
    lower: Vector  # (n + m,)
    upper: Vector  # (n + m,)
    lower_rad: Vector  # (n,), of the joints alone
    upper_rad: Vector  # (n,)

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
        n = len(lower_rad)
        rows = np.zeros((0, n)) if A is None else np.asarray(A, dtype=np.float64)
        if len(upper_rad) != n or rows.ndim != 2 or rows.shape[1] != n:
            raise LimitsError(f"limits of {n} and {len(upper_rad)} joints, rows of {rows.shape}")
        if len(row_lower) != len(rows) or len(row_upper) != len(rows):
            raise LimitsError(f"{len(rows)} rows need as many lower and upper bounds")
        lower, upper = np.array([*lower_rad, *row_lower]), np.array([*upper_rad, *row_upper])
        limits = cls(
            n=n,
            C=constant(np.vstack([np.eye(n), rows])),
            lower=constant(lower),
            upper=constant(upper),
            lower_rad=constant(lower[:n]),
            upper_rad=constant(upper[:n]),
        )
        limits._check()
        return limits

    @property
    def rows(self) -> Matrix:
        """The rows' matrix (m, n)."""
        return self.C[self.n :]

    def violation(self, q_rad: Vector) -> float:
        """Largest distance outside any limit or row; negative when inside all of them."""
        values = self.C.dot(q_rad)
        return float(np.maximum(self.lower - values, values - self.upper).max())

    def project(self, q_rad: Vector) -> Vector:
        """The nearest posture (least squares) inside all limits and rows (rows to 1e-9)."""
        clipped: Vector = np.minimum(np.maximum(q_rad, self.lower_rad), self.upper_rad)
        if len(self.C) == self.n or self.violation(clipped) <= ROUNDING:
            return clipped
        nearest = minimise(np.eye(self.n), -q_rad, self.C, self.lower, self.upper)
        result: Vector = np.minimum(np.maximum(nearest, self.lower_rad), self.upper_rad)
        return result

    def _check(self) -> None:
        wrong = np.flatnonzero(~(self.lower <= self.upper))  # also catches NaN
        if len(wrong):
            i = int(wrong[0])
            name = f"joint {i}" if i < self.n else f"row {i - self.n}"
            raise LimitsError(f"{name}: lower limit {self.lower[i]} above upper {self.upper[i]}")
        if not np.isfinite(self.C).all():
            raise LimitsError("the rows hold NaN or infinity")
        try:
            self.project(np.clip(np.zeros(self.n), self.lower_rad, self.upper_rad))
        except NoSolutionError as error:
            raise LimitsError(
                f"no posture keeps all rows in the joints' ranges: {error}"
            ) from error
