"""Other ways to learn one sample at a time, as well as they can be done, beside ours."""

import numpy as np
from scipy.linalg.blas import dger
from scipy.linalg.lapack import dpotrs

from dforc.arrays import Matrix, Vector


def _rank_one(L: Matrix, x: Vector) -> None:
    """Turn L with LL' = A into the factor of A + xx', column after column, in place."""
    size = len(x)
    for k in range(size):
        old, pushed = L[k, k], x[k]
        new = np.sqrt(old * old + pushed * pushed)
        c, s = old / new, pushed / new
        L[k, k] = new
        for i in range(k + 1, size):  # down a column: contiguous, so that it is vectorised
            below, left = L[i, k], x[i]
            L[i, k] = c * below + s * left
            x[i] = c * left - s * below


class CholeskyRidge:
    """The papers' scheme: a rank-1 update of the factor, then all outputs solved anew."""

    def __init__(self, size: int, outputs: int, regularisation: float) -> None:
        from numba import njit  # where it is missing, a row says so

        self._update_factor = njit(cache=False, fastmath=True)(_rank_one)
        self._L: Matrix = np.asfortranarray(np.eye(size) * np.sqrt(regularisation))
        self._moment: Matrix = np.zeros((size, outputs), order="F")
        self.weights: Matrix = np.zeros((size, outputs), order="F")

    def fit(self, phi: Matrix, y: Matrix, regularisation: float) -> None:
        """Start from a batch."""
        A = phi.T @ phi + regularisation * np.eye(phi.shape[1])
        self._L = np.asfortranarray(np.linalg.cholesky(A))
        self._moment = np.asfortranarray(phi.T @ y)

    def update(self, phi: Vector, y: Vector) -> None:
        """Take in one sample."""
        self._moment = dger(1.0, phi, y, a=self._moment, overwrite_a=1)
        self._update_factor(self._L, phi.copy())
        self.weights, _ = dpotrs(self._L, self._moment, lower=1)


class GradientDescent:
    """scikit-learn's SGDRegressor, one per output: its partial_fit takes one target only."""

    def __init__(self, outputs: int) -> None:
        from sklearn.linear_model import SGDRegressor

        self._models = [
            SGDRegressor(alpha=1e-7, learning_rate="constant", eta0=0.5) for _ in range(outputs)
        ]

    def update(self, phi: Vector, y: Vector) -> None:
        """Take in one sample, for every output."""
        row = phi[None]
        for model, value in zip(self._models, y, strict=True):
            model.partial_fit(row, [value])
