"""Incremental ridge regression on random Fourier features (RFRR), from inputs to outputs.

A wrench has two kernels, one that its three forces share and one for its three moments: they
differ in smoothness and noise, and every further kernel costs a P of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import ShapeError
from dforc.learning.marginal_likelihood import fit_hyperparameters
from dforc.learning.random_features import Form, RandomFeatures
from dforc.learning.recursive_ridge import RecursiveRidge, RidgeState

WRENCH_GROUPS = ((0, 1, 2), (3, 4, 5))


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """Which outputs share a kernel, and its hyperparameters."""

    outputs: tuple[int, ...]
    length_scales: Vector
    regularisation: float


@dataclass(frozen=True, slots=True, eq=False)
class LearnerState:
    """What a learner knows: one state per kernel, and the outputs' mean."""

    mean: Vector
    ridges: tuple[RidgeState, ...]


def fit_kernels(
    x: Matrix, y: Matrix, groups: Sequence[Sequence[int]] = WRENCH_GROUPS
) -> tuple[Kernel, ...]:
    """One kernel per group of outputs by marginal likelihood; every output counts alike."""
    scaled = _standardised(y)
    found = [(tuple(group), fit_hyperparameters(x, scaled[:, list(group)])) for group in groups]
    return tuple(Kernel(group, fit.length_scales, fit.regularisation) for group, fit in found)


def fit_noise(x: Matrix, y: Matrix, kernels: Sequence[Kernel]) -> tuple[Kernel, ...]:
    """The same kernels with the regularisation that fits other outputs y.

    For what a model leaves over: too little of it is more than noise to find length scales by, and
    it stems from the same motion as the whole.
    """
    scaled = _standardised(y)
    return tuple(
        replace(
            kernel,
            regularisation=fit_hyperparameters(
                x, scaled[:, list(kernel.outputs)], kernel.length_scales
            ).regularisation,
        )
        for kernel in kernels
    )


def _standardised(y: Matrix) -> Matrix:
    scaled: Matrix = (y - y.mean(0)) / np.maximum(y.std(0), 1e-12)
    return scaled


class FeatureRidge:
    """Learns y (outputs,) from x (inputs,), one sample at a time."""

    __slots__ = ("_columns", "_features", "_mean", "_ridges", "kernels", "outputs")

    def __init__(
        self,
        kernels: Sequence[Kernel],
        size: int,
        seed: int | Sequence[int] | np.random.Generator,
        form: Form = "pair",
    ) -> None:
        """Draw `size` features for every kernel; together the kernels name each output once."""
        generator = np.random.default_rng(seed)
        named = sorted(index for kernel in kernels for index in kernel.outputs)
        if named != list(range(len(named))):
            raise ShapeError(f"the kernels name the outputs {named}")
        self.kernels = tuple(kernels)
        self.outputs = len(named)
        self._columns = tuple(np.array(kernel.outputs) for kernel in kernels)
        self._features = tuple(
            RandomFeatures(len(k.length_scales), size, k.length_scales, generator, form)
            for k in kernels
        )
        self._ridges = tuple(
            RecursiveRidge(size, len(k.outputs), k.regularisation) for k in kernels
        )
        self._mean = constant(np.zeros(self.outputs))

    @property
    def samples(self) -> int:
        """How many samples were taken in."""
        return self._ridges[0].samples

    def predict(self, x: ArrayLike) -> Vector:
        """The outputs (outputs,) for one input."""
        y = np.empty(self.outputs)
        for columns, features, ridge in self._parts():
            y[columns] = ridge.predict(features.features(x))
        y += self._mean
        return y

    def predict_rows(self, x: Matrix) -> Matrix:
        """One row of outputs per row of `x` (k, inputs)."""
        y = np.empty((len(x), self.outputs))
        for columns, features, ridge in self._parts():
            y[:, columns] = ridge.predict_rows(features.features_of_rows(x))
        return y + self._mean

    def novelty(self, x: ArrayLike) -> float:
        """How little is known about this input: 1 before any sample, towards 0 with many near it.

        Posterior over prior variance of the kernel's process, the largest of the kernels.
        """
        return max(
            ridge.variance(features.features(x)) * ridge.regularisation
            for _, features, ridge in self._parts()
        )

    def update(self, x: ArrayLike, y: ArrayLike) -> Vector:
        """Take in one sample; return its error (outputs,) from before.

        Raises:
            NotFiniteError: NaN or infinity in the sample; nothing was changed.
            NotDefiniteError: of one kernel; those before it have taken the sample in.
        """
        target = finite_vector("outputs", y, self.outputs) - self._mean
        error = np.empty(self.outputs)
        for columns, features, ridge in self._parts():
            error[columns] = ridge.update(features.features(x), target[columns])
        return error

    def fit(self, x: Matrix, y: Matrix) -> None:
        """Start again from a batch; its mean is the prediction where nothing is known."""
        mean = y.mean(0)
        for columns, features, ridge in self._parts():
            ridge.fit(features.features_of_rows(x), (y - mean)[:, columns])
        self._mean = constant(mean)

    def reset(self, mean: ArrayLike | None = None) -> None:
        """Forget everything; `mean` (zero) is the prediction where nothing is known."""
        given = np.zeros(self.outputs) if mean is None else mean
        self._mean = constant(finite_vector("mean", given, self.outputs))
        for ridge in self._ridges:
            ridge.reset()

    def definite(self) -> bool:
        """Whether every P is positive definite; O(size^3)."""
        return all(ridge.definite() for ridge in self._ridges)

    def state(self) -> LearnerState:
        """A copy of everything learned."""
        return LearnerState(self._mean, tuple(ridge.state() for ridge in self._ridges))

    def require_fitting(self, state: LearnerState) -> None:
        """Refuse what `restore` would refuse."""
        if len(state.ridges) != len(self._ridges):
            raise ShapeError(f"state of {len(state.ridges)} kernels, not {len(self._ridges)}")
        finite_vector("mean", state.mean, self.outputs)
        for ridge, given in zip(self._ridges, state.ridges, strict=True):
            ridge.require_fitting(given)

    def restore(self, state: LearnerState) -> None:
        """Continue from `state`.

        Raises:
            ShapeError: the state of another learner; nothing was changed.
            NotFiniteError: NaN or infinity in it; nothing was changed.
        """
        self.require_fitting(state)
        mean = finite_vector("mean", state.mean, self.outputs)
        for ridge, given in zip(self._ridges, state.ridges, strict=True):
            ridge.restore(given)
        self._mean = constant(mean)

    def _parts(self) -> "zip[tuple[np.ndarray, RandomFeatures, RecursiveRidge]]":
        return zip(self._columns, self._features, self._ridges, strict=True)
