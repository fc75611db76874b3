"""Array types, and the checks made where data enter the numerics."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dforc.errors import NotFiniteError, ShapeError

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
ArrayLike = Vector | Sequence[float]


def finite_vector(name: str, values: ArrayLike, size: int) -> Vector:
    """A float64 copy of `values`, shape (size,).

    Raises:
        ShapeError: another number of elements.
        NotFiniteError: NaN or infinity among them.
    """
    vector = np.array(values, dtype=np.float64)
    if vector.shape != (size,):
        raise ShapeError(f"{name} has shape {vector.shape}, expected ({size},)")
    # One dot product tells: a NaN or an infinity survives it (as would values above 1e154).
    if not math.isfinite(vector.dot(vector)):
        raise NotFiniteError(f"{name} is not finite: {vector.tolist()}")
    return vector


def constant(values: ArrayLike | Matrix) -> Vector:
    """A read-only float64 copy, for arrays that an object keeps."""
    copy = np.array(values, dtype=np.float64)
    copy.setflags(write=False)
    return copy
