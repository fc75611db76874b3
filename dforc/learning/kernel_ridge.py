"""Kernel ridge regression with a Gaussian kernel: exact, static, and slow in the sample count."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.errors import NotFiniteError, ShapeError


def squared_distances(a: Matrix, b: Matrix) -> Matrix:
    """|a_i - b_j|^2 (len(a), len(b)), never below zero."""
    squares = (a * a).sum(1)[:, None] + (b * b).sum(1)[None, :] - 2.0 * (a @ b.T)
    distances: Matrix = np.maximum(squares, 0.0, out=squares)
    return distances


def gaussian_kernel(a: Matrix, b: Matrix, length_scales: Vector) -> Matrix:
    """exp(-1/2 sum ((a_i - b_i) / l_i)^2) for every pair of rows."""
    return np.exp(-0.5 * squared_distances(a / length_scales, b / length_scales))


class KernelRidge:
    """y = k(x, X) (K + lambda I)^-1 Y."""

    def __init__(self, length_scales: ArrayLike, regularisation: float) -> None:
        """Keep the kernel.

        Args:
            length_scales: one per input, in the input's unit.
            regularisation: lambda > 0; noise variance over signal variance.
        """
        self._lengths = finite_vector("length scales", length_scales, len(length_scales))
        if self._lengths.min() <= 0 or not 0 < regularisation < np.inf:
            raise ShapeError(f"length scales {length_scales}, lambda {regularisation}")
        self._regularisation = regularisation
        self._centre: Vector = np.zeros(len(self._lengths))
        self._scaled: Matrix = np.zeros((0, len(self._lengths)))
        self._squares: Vector = np.zeros(0)
        self._dual: Matrix = np.zeros((0, 1))

    def fit(self, x: Matrix, y: Matrix) -> "KernelRidge":
        """Solve for all rows x (k, inputs), y (k, outputs), in O(k^3). Returns itself.

        Raises:
            NotFiniteError: NaN or infinity among them; nothing was changed.
        """
        if x.ndim != 2 or x.shape[1] != len(self._lengths) or y.ndim != 2 or len(x) != len(y):
            raise ShapeError(f"batch of shapes {x.shape} and {y.shape}")
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise NotFiniteError("the batch is not finite")
        centre = x.mean(0)  # far from zero, differences would drown in rounding
        K = gaussian_kernel(x - centre, x - centre, self._lengths)
        K[np.diag_indices(len(x))] += self._regularisation
        self._dual = cho_solve(cho_factor(K, lower=True, overwrite_a=True), y)
        self._centre = centre
        self._scaled = (x - centre) / self._lengths
        self._squares = (self._scaled * self._scaled).sum(1)
        return self

    def predict(self, x: Matrix) -> Matrix:
        """One row of outputs per row of x."""
        given = (np.atleast_2d(x) - self._centre) / self._lengths
        K = (given * given).sum(1)[:, None] + self._squares
        K -= 2.0 * (given @ self._scaled.T)
        np.maximum(K, 0.0, out=K)
        K *= -0.5
        np.exp(K, out=K)
        outputs: Matrix = K @ self._dual
        return outputs
