"""What a learner has learned, as a file: written whole or not at all, refused if not ours."""

import os
from pathlib import Path

import msgspec
import numpy as np

from dforc.arrays import Matrix
from dforc.learning.feature_ridge import LearnerState
from dforc.learning.recursive_ridge import RidgeState
from services.core.errors import ServiceError

VERSION = 1


class SavedRidge(msgspec.Struct, frozen=True, kw_only=True):
    """One kernel's state; arrays as bytes, column after column, little-endian float64."""

    size: int
    outputs: int
    regularisation: float
    samples: int
    inverse: bytes
    weights: bytes
    held: bytes


class SavedLimb(msgspec.Struct, frozen=True, kw_only=True):
    """One sensor's state, and which joints it is a function of."""

    name: str
    joints: tuple[str, ...]
    lengths: tuple[float, ...]
    seed: int
    mean: tuple[float, ...]
    ridges: tuple[SavedRidge, ...]


class SavedLearner(msgspec.Struct, frozen=True, kw_only=True):
    """The file."""

    version: int
    robot: str
    limbs: tuple[SavedLimb, ...]


class StateFileError(ServiceError):
    """The file cannot be written, read, or is of another learner."""


def write(path: Path, saved: SavedLearner) -> None:
    """Write next to the path, then rename: a reader sees the old file or the new one.

    Raises:
        StateFileError: it cannot be written.
    """
    draft = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        draft.write_bytes(msgspec.msgpack.encode(saved))
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise StateFileError(f"cannot write {path}: {error.strerror}") from error


def read(path: Path) -> SavedLearner:
    """The file's content.

    Raises:
        StateFileError: it cannot be read, or is none of this version.
    """
    try:
        saved = msgspec.msgpack.decode(path.read_bytes(), type=SavedLearner)
    except OSError as error:
        raise StateFileError(f"cannot read {path}: {error.strerror}") from error
    except msgspec.MsgspecError as error:
        raise StateFileError(f"{path} is no state of a learner: {error}") from error
    if saved.version != VERSION:
        raise StateFileError(f"{path} has version {saved.version}, this is {VERSION}")
    return saved


def saved_ridges(state: LearnerState) -> tuple[SavedRidge, ...]:
    """The arrays as they go into the file."""
    return tuple(
        SavedRidge(
            size=ridge.W.shape[0],
            outputs=ridge.W.shape[1],
            regularisation=ridge.regularisation,
            samples=ridge.samples,
            inverse=_bytes(ridge.P),
            weights=_bytes(ridge.W),
            held=_bytes(ridge.held),
        )
        for ridge in state.ridges
    )


def learner_state(limb: SavedLimb) -> LearnerState:
    """The arrays as they come out of it, to the bit.

    Raises:
        StateFileError: their length is not that of their shape.
    """
    ridges = []
    for saved in limb.ridges:
        inverse = _array(saved.inverse, saved.size, saved.size, limb.name)
        weights = _array(saved.weights, saved.size, saved.outputs, limb.name)
        columns = len(saved.held) // (8 * max(saved.size, 1))
        held = _array(saved.held, saved.size, columns, limb.name)
        ridges.append(RidgeState(inverse, weights, saved.regularisation, saved.samples, held))
    return LearnerState(np.array(limb.mean, dtype=np.float64), tuple(ridges))


def _bytes(array: Matrix) -> bytes:
    return array.astype("<f8").tobytes(order="F")


def _array(content: bytes, rows: int, columns: int, name: str) -> Matrix:
    if len(content) != 8 * rows * columns:
        raise StateFileError(f"the state of {name} holds {len(content)} bytes for {rows}x{columns}")
    return (
        np.frombuffer(content, dtype="<f8").reshape((rows, columns), order="F").astype(np.float64)
    )
