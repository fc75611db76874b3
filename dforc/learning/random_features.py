"""Random Fourier features: an explicit map whose inner products approximate a Gaussian kernel.

k(x, z) = exp(-1/2 sum ((x_i - z_i) / l_i)^2) = E[phi(x)' phi(z)], frequencies drawn from the
kernel's spectrum, a normal distribution of standard deviation 1 / l_i (Rahimi and Recht 2007).
`pair` holds a cosine and a sine per frequency, so phi'phi = 1 exactly; `phase` holds one cosine
with a random phase per frequency: twice the frequencies at the same size.
"""

from typing import Literal

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError, ShapeError

Form = Literal["pair", "phase"]


class RandomFeatures:
    """The map x (inputs,) -> phi (size,) with phi'phi about 1."""

    __slots__ = ("_phase", "_scale", "form", "frequencies", "inputs", "size")

    def __init__(
        self,
        inputs: int,
        size: int,
        length_scales: ArrayLike,
        seed: int | np.random.Generator,
        form: Form = "pair",
    ) -> None:
        """Draw the frequencies.

        Args:
            inputs: elements of x.
            size: number of features D; even for `pair`.
            length_scales: one per input, in the input's unit; all above zero.
            seed: the same seed gives the same features.
            form: see above.
        """
        lengths = finite_vector("length scales", length_scales, inputs)
        if lengths.min() <= 0:
            raise ShapeError(f"length scales must be above zero: {lengths.tolist()}")
        if size < 2 or (form == "pair" and size % 2):
            raise ShapeError(f"{size} features; pairs need an even number of 2 or more")
        generator = np.random.default_rng(seed)
        count = size // 2 if form == "pair" else size
        # x W with the frequencies as columns: one BLAS call on contiguous memory
        self.frequencies = constant(generator.standard_normal((count, inputs)).T / lengths[:, None])
        self._phase = constant(generator.uniform(0.0, 2 * np.pi, count))
        self._scale = float(np.sqrt(1.0 / count if form == "pair" else 2.0 / count))
        self.form = form
        self.inputs = inputs
        self.size = size

    def features(self, x: ArrayLike) -> Vector:
        """Features (size,) of one input.

        Raises:
            NotFiniteError: NaN or infinity in x.
        """
        return self._map(finite_vector("input", x, self.inputs))

    def features_of_rows(self, x: Matrix) -> Matrix:
        """One row (size,) per row of `x` (k, inputs)."""
        if x.ndim != 2 or x.shape[1] != self.inputs:
            raise ShapeError(f"inputs have shape {x.shape}, expected (k, {self.inputs})")
        if not np.isfinite(x).all():
            raise NotFiniteError("an input is not finite")
        return self._map(x)

    def _map(self, x: Matrix) -> Matrix:
        angles = x @ self.frequencies
        if self.form == "phase":
            angles += self._phase
            phi = np.cos(angles, out=angles)
        else:
            count = angles.shape[-1]
            phi = np.empty((*angles.shape[:-1], self.size))
            np.cos(angles, out=phi[..., :count])
            np.sin(angles, out=phi[..., count:])
        phi *= self._scale
        return phi
