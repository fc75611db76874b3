"""The contacts of one sub-model from the wrench that is missing in it, by numpy's SVD.

The same rules as in kernel_contacts.py, written down a second time for where numba is absent.
"""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.estimation.plan import LEVER_M, RANK_TOLERANCE

TO_NEWTONS = np.array([1.0, 1.0, 1.0, 1.0 / LEVER_M, 1.0 / LEVER_M, 1.0 / LEVER_M])
ALL_OF_A_WRENCH = np.eye(6)


def about(wrench: Vector, point: Vector) -> Vector:
    """A wrench about the origin, taken about a point."""
    moved = wrench.copy()
    moved[3:] -= np.cross(point, wrench[:3])
    return moved


def solve_sub_model(
    missing: Vector,
    reference: Vector,
    points: Matrix,
    directions: Matrix,
    unknowns: tuple[int, ...],
    found: Matrix,
) -> tuple[Vector, int]:
    """Fill in the wrenches of a sub-model's contacts.

    Args:
        missing: (6,), what the world exerts on the sub-model, about the origin.
        reference: (3,), where moments are taken.
        points: (k, 3), the contacts that count.
        directions: (k, 3), theirs.
        unknowns: theirs: 6, 3 or 1.
        found: (k, 6), the result.

    Returns:
        The residual (6,) about the reference, and the rank.
    """
    target = about(missing, reference) * TO_NEWTONS
    shapes = [_shape(count, n) for count, n in zip(unknowns, directions, strict=True)]
    if not shapes:
        return target / TO_NEWTONS, 0
    columns = [
        _about_reference(shape, (point - reference) / LEVER_M)
        for shape, point in zip(shapes, points, strict=True)
    ]
    U, S, Vt = np.linalg.svd(np.vstack(columns).T, full_matrices=False)
    rank = int((RANK_TOLERANCE * S[0] < S).sum())
    along = target @ U[:, :rank]
    values = (along / S[:rank]) @ Vt[:rank]
    start = 0
    for i, shape in enumerate(shapes):
        found[i] = values[start : start + len(shape)] @ shape / TO_NEWTONS
        start += len(shape)
    return (target - U[:, :rank] @ along) / TO_NEWTONS, rank


def _shape(unknowns: int, direction: Vector) -> Matrix:
    """A row (6) for each unknown: the wrench about the contact point of one newton of it."""
    if unknowns == 1:
        return np.concatenate([direction, np.zeros(3)])[None, :]
    return ALL_OF_A_WRENCH[:unknowns]


def _about_reference(shape: Matrix, lever: Vector) -> Matrix:
    moved = shape.copy()
    moved[:, 3:] += np.cross(lever, shape[:, :3])
    return moved
