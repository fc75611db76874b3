"""A rigid-body model whose parameters are identified, and RFRR on what it leaves over.

y = R(x) theta + rest(x): R (outputs, parameters) is the regressor of the rigid-body model at the
state x, for instance ten inertial parameters per link and a constant offset per output. The model
extrapolates where features cannot, and the rest learns what no rigid body does.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.feature_ridge import FeatureRidge, LearnerState


@dataclass(frozen=True, slots=True, eq=False)
class SemiParametricState:
    """Parameters, the sums that they come from, and the state of the rest."""

    information: Matrix
    moment: Vector
    theta: Vector
    rest: LearnerState


class RigidParameters:
    """theta by weighted least squares around a prior, from any number of samples."""

    __slots__ = ("_information", "_moment", "_prior", "_start", "_weights", "theta")

    def __init__(self, prior: ArrayLike, spread: ArrayLike, noise: ArrayLike) -> None:
        """Begin at the prior.

        Args:
            prior: theta before any sample, for instance from CAD; zeros for offsets.
            spread: standard deviation of each parameter around it, in the parameter's unit.
            noise: standard deviation of each output about the model, in the output's unit.
        """
        size = len(prior)
        self._prior = constant(finite_vector("prior", prior, size))
        spread = finite_vector("spread", spread, size)
        noise = finite_vector("noise", noise, len(noise))
        if min(spread.min(), noise.min()) <= 0:
            raise ShapeError("spread and noise must be above zero")
        self._weights = constant(1.0 / noise)
        self._start = constant(np.diag(spread**-2.0))
        self._information: Matrix = self._start.copy()
        self._moment: Vector = np.zeros(size)
        self.theta = self._prior

    def add(self, regressor: Matrix, y: Matrix) -> None:
        """Take in samples: regressors (k, outputs, parameters), outputs (k, outputs).

        `theta` changes with `solve` only, so that a caller decides when a learner of the rest
        sees another target.
        """
        outputs, size = len(self._weights), len(self._prior)
        if regressor.shape != (len(y), outputs, size) or y.shape != (len(regressor), outputs):
            raise ShapeError(f"samples of shapes {regressor.shape} and {y.shape}")
        if not (np.isfinite(regressor).all() and np.isfinite(y).all()):
            raise NotFiniteError("a sample is not finite")
        rows = (regressor * self._weights[:, None]).reshape(-1, size)
        rest = (y * self._weights).reshape(-1) - rows @ self._prior
        self._information += rows.T @ rows
        self._moment += rows.T @ rest

    def solve(self) -> Vector:
        """Parameters theta (parameters,) by everything added."""
        scale = 1.0 / np.sqrt(np.diag(self._information))  # units differ by orders of magnitude
        scaled = self._information * np.outer(scale, scale)
        self.theta = constant(self._prior + scale * np.linalg.solve(scaled, scale * self._moment))
        return self.theta

    def reset(self) -> None:
        """Back to the prior."""
        self._information = self._start.copy()
        self._moment = np.zeros(len(self._prior))
        self.theta = self._prior

    def sums(self) -> tuple[Matrix, Vector]:
        """Information and moment, copies."""
        return constant(self._information), constant(self._moment)

    def restore(self, information: Matrix, moment: Vector, theta: Vector) -> None:
        """Continue from earlier sums and parameters.

        Raises:
            ShapeError: those of other parameters; nothing was changed.
            NotFiniteError: NaN or infinity among them; nothing was changed.
        """
        size = len(self._prior)
        sums = finite_vector("information", information.ravel(), size * size)
        moments = finite_vector("moment", moment, size)
        self.theta = constant(finite_vector("theta", theta, size))
        self._information, self._moment = sums.reshape(size, size), moments


class SemiParametric:
    """R(x) theta + rest(x)."""

    __slots__ = ("rest", "rigid")

    def __init__(self, rigid: RigidParameters, rest: FeatureRidge) -> None:
        self.rigid = rigid
        self.rest = rest

    def model(self, regressor: Matrix) -> Vector:
        """The rigid-body part (outputs,) for one regressor (outputs, parameters)."""
        return regressor @ self.rigid.theta

    def predict(self, x: ArrayLike, regressor: Matrix) -> Vector:
        """Both parts (outputs,)."""
        return self.model(regressor) + self.rest.predict(x)

    def predict_rows(self, x: Matrix, regressors: Matrix) -> Matrix:
        """One row of outputs per row of x."""
        return regressors @ self.rigid.theta + self.rest.predict_rows(x)

    def fit(self, x: Matrix, regressors: Matrix, y: Matrix) -> None:
        """Start again from a batch: first the parameters, then the rest."""
        self.rigid.reset()
        self.rigid.add(regressors, y)
        self.rest.fit(x, y - regressors @ self.rigid.solve())

    def update(self, x: ArrayLike, regressor: Matrix, y: ArrayLike) -> Vector:
        """The rest takes in one sample; theta stays. Returns the error (outputs,) from before."""
        return self.rest.update(x, y - self.model(regressor))

    def state(self) -> SemiParametricState:
        """A copy of everything learned."""
        information, moment = self.rigid.sums()
        return SemiParametricState(information, moment, self.rigid.theta, self.rest.state())

    def restore(self, state: SemiParametricState) -> None:
        """Continue from `state`.

        Raises:
            ShapeError: the state of another learner; nothing was changed.
            NotFiniteError: NaN or infinity in it; nothing was changed.
        """
        self.rest.require_fitting(state.rest)
        self.rigid.restore(state.information, state.moment, state.theta)
        self.rest.restore(state.rest)
