"""Ridge regression that takes one sample at a time: recursive least squares on the inverse.

With P = (lambda I + sum phi phi')^-1 and weights W (size, outputs), a new sample (phi, y) gives

    k = P phi,  s = 1 + phi'k,  W += k (y - W'phi)' / s,  P -= k k' / s

exactly the ridge solution of all samples so far, in any order, in O(size^2) for every output
together. P is kept as one triangle, updated in place by BLAS. The last few k are held back and
enter it together: what an update costs is the way of P through the memory, and so it is read at
every sample, but written at every eighth. Float64 only: in float32 the same recursion is wrong in
the second digit after some ten thousand samples.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, lapack
from scipy.linalg.blas import dgemv, dger, dsymv, dsyrk

from dforc.arrays import ArrayLike, Matrix, Vector, constant
from dforc.errors import DforcError, NotFiniteError, ShapeError

HELD = 8  # of 4, 8 and 16 the fastest from 500 features on; no difference at 200


class NotDefiniteError(DforcError):
    """P is no longer positive definite: rounding has eaten it. Start again from data or a state."""


@dataclass(frozen=True, slots=True, eq=False)
class RidgeState:
    """Everything that a learner has learned; read-only arrays."""

    P: Matrix  # (size, size), Fortran order, lower triangle
    W: Matrix  # (size, outputs), Fortran order
    regularisation: float
    samples: int
    held: Matrix  # (size, fewer than HELD), Fortran order: what P has yet to take in


class RecursiveRidge:
    """Weights W of y = W'phi, by every sample so far."""

    __slots__ = ("_K", "_P", "_W", "_held", "outputs", "regularisation", "samples", "size")

    def __init__(self, size: int, outputs: int, regularisation: float) -> None:
        """Start without a sample: W = 0, P = I / lambda.

        Args:
            size: number of features.
            outputs: number of outputs, which share P.
            regularisation: lambda > 0; noise variance over signal variance of the kernel.
        """
        if not (math.isfinite(regularisation) and regularisation > 0) or size < 1 or outputs < 1:
            raise ShapeError(f"{size} features, {outputs} outputs, lambda {regularisation}")
        self.size = size
        self.outputs = outputs
        self.regularisation = regularisation
        self.samples = 0
        self._P: Matrix = np.zeros((size, size), order="F")
        self._W: Matrix = np.zeros((size, outputs), order="F")
        self._K: Matrix = np.zeros((size, HELD), order="F")  # columns k / sqrt(s), held back
        self._held = 0
        self.reset()

    @property
    def weights(self) -> Matrix:
        """W (size, outputs), a copy."""
        return self._W.copy(order="F")

    def reset(self) -> None:
        """Forget everything."""
        self._P[:] = 0.0
        np.fill_diagonal(self._P, 1.0 / self.regularisation)
        self._W[:] = 0.0
        self._held = 0
        self.samples = 0

    def predict(self, phi: Vector) -> Vector:
        """W'phi (outputs,)."""
        if phi.shape != (self.size,):
            raise ShapeError(f"features have shape {phi.shape}, expected ({self.size},)")
        prediction: Vector = dgemv(1.0, self._W, phi, trans=1)
        return prediction

    def predict_rows(self, phi: Matrix) -> Matrix:
        """One row (outputs,) per row of `phi` (k, size)."""
        return phi @ self._W

    def update(self, phi: Vector, y: ArrayLike) -> Vector:
        """Take in one sample; return its error y - W'phi (outputs,) from before.

        Raises:
            NotFiniteError: NaN or infinity in the sample; nothing was changed.
            NotDefiniteError: phi'P phi is not above zero; nothing was changed.
        """
        if phi.shape != (self.size,):
            raise ShapeError(f"features have shape {phi.shape}, expected ({self.size},)")
        if len(y) != self.outputs:
            raise ShapeError(f"there are {len(y)} outputs, expected {self.outputs}")
        square = phi.dot(phi)  # a NaN or an infinity survives it
        if not math.isfinite(square):
            raise NotFiniteError("the features are not finite")
        error: Vector = y - dgemv(1.0, self._W, phi, trans=1)
        if error.shape != (self.outputs,):
            raise ShapeError(f"outputs have shape {np.shape(y)}, expected ({self.outputs},)")
        k = self._spread(phi)
        variance = float(phi.dot(k))
        if not math.isfinite(error.dot(error)):
            raise NotFiniteError("the outputs are not finite")
        if not variance > 0.0 and square > 0.0:
            raise NotDefiniteError(f"phi'P phi = {variance:g} after {self.samples} samples")
        gain = 1.0 / (1.0 + variance)
        self._W = dger(gain, k, error, a=self._W, overwrite_a=1)
        np.multiply(k, math.sqrt(gain), out=self._K[:, self._held])
        self._held += 1
        if self._held == HELD:
            self._P = dsyrk(-1.0, self._K, beta=1.0, c=self._P, lower=1, overwrite_c=1)
            self._held = 0
        self.samples += 1
        return error

    def variance(self, phi: Vector) -> float:
        """How much, phi'P phi, is unknown about this input, in units of the noise; 0 = nothing."""
        return float(phi.dot(self._spread(phi)))

    def fit(self, phi: Matrix, y: Matrix) -> None:
        """Start again from a batch: rows phi (k, size) and y (k, outputs).

        Raises:
            NotFiniteError: NaN or infinity among them; nothing was changed.
        """
        if phi.shape != (len(y), self.size) or y.shape != (len(phi), self.outputs):
            raise ShapeError(f"batch of shapes {phi.shape} and {y.shape}")
        if not (np.isfinite(phi).all() and np.isfinite(y).all()):
            raise NotFiniteError("the batch is not finite")
        phi = np.asarray(phi, dtype=np.float64)
        A = phi.T @ phi
        A[np.diag_indices(self.size)] += self.regularisation
        factor, _ = cho_factor(A, lower=True)
        inverse, _ = lapack.dpotri(np.asfortranarray(factor), lower=1)
        weights, _ = lapack.dpotrs(factor, phi.T @ y, lower=1)
        self._P = np.asfortranarray(np.tril(inverse))
        self._W = np.asfortranarray(weights)
        self._held = 0
        self.samples = len(y)

    def definite(self) -> bool:
        """Whether P is positive definite, by a Cholesky factorisation: O(size^3), not per tick."""
        held = self._K[:, : self._held]
        _, info = lapack.dpotrf(dsyrk(-1.0, held, beta=1.0, c=self._P, lower=1), lower=1)
        return int(info) == 0

    def state(self) -> RidgeState:
        """A copy of everything learned."""
        P, W = self._P.copy(order="F"), self._W.copy(order="F")
        held = self._K[:, : self._held].copy(order="F")
        for array in (P, W, held):
            array.setflags(write=False)
        return RidgeState(P, W, self.regularisation, self.samples, held)

    def require_fitting(self, state: RidgeState) -> None:
        """Refuse what `restore` would refuse."""
        if state.P.shape != self._P.shape or state.W.shape != self._W.shape:
            shapes = state.P.shape, state.W.shape
            raise ShapeError(f"state of shapes {shapes}, expected {self._P.shape, self._W.shape}")
        size, held = state.held.shape
        if size != self.size or held >= HELD:
            raise ShapeError(f"state holds back {state.held.shape}, fewer than {HELD} expected")
        if not all(np.isfinite(part).all() for part in (state.P, state.W, state.held)):
            raise NotFiniteError("the state is not finite")
        if not (math.isfinite(state.regularisation) and state.regularisation > 0):
            raise NotFiniteError(f"the state's lambda is {state.regularisation}")

    def restore(self, state: RidgeState) -> None:
        """Continue from `state`, bit by bit as if nothing had happened since.

        Raises:
            ShapeError: the state of another size; nothing was changed.
            NotFiniteError: NaN or infinity in the state, or a lambda that is none; nothing was
                changed.
        """
        self.require_fitting(state)
        self._P = state.P.copy(order="F")
        self._W = state.W.copy(order="F")
        self._held = state.held.shape[1]
        self._K[:, : self._held] = state.held
        self.regularisation = state.regularisation
        self.samples = state.samples

    def _spread(self, phi: Vector) -> Vector:
        """P phi, those held back included."""
        k: Vector = dsymv(1.0, self._P, phi, lower=1)
        if self._held:
            held = self._K[:, : self._held]
            k = dgemv(-1.0, held, dgemv(1.0, held, phi, trans=1), beta=1.0, y=k, overwrite_y=1)
        return k


def batch_weights(phi: Matrix, y: Matrix, regularisation: float) -> Matrix:
    """The ridge solution W (size, outputs) of all rows at once, read-only."""
    A = phi.T @ phi + regularisation * np.eye(phi.shape[1])
    weights: Matrix = cho_solve(cho_factor(A), phi.T @ y)
    return constant(weights)
