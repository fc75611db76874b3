"""What a limb moves of the body, and how far at most: bounds that hold in every posture."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.body import BodyArrays
from dforc.ik.kernel_chain import Indices

LEAST_LEVER_M = 0.05  # of a joint in the metric, so that turning the wrist is not free


class Moving(NamedTuple):
    """The limb among the body's joints and capsules.

    A lever is a bound of the speed of any point of a capsule's axis, over the joint's speed.
    """

    columns: Indices  # (n,) the limb's joints in the body vector
    capsules: Indices  # (k,) those that the limb moves and that count against obstacles
    levers: Matrix  # (k, n) [m]
    pairs: Indices  # (p, 2) capsules that the limb moves against each other
    pair_levers: Matrix  # (p, n) [m], of the distance between the two
    metric: Vector  # (n,) [m] weight of a joint in distances between postures


def moving_of(body: BodyArrays, columns: Indices, mask: NDArray[np.bool_] | None = None) -> Moving:
    """The tables of a limb; of the capsules in `mask` only, where one is given."""
    count = len(body.carriers)
    levers = np.array([_levers(body, c, columns) for c in range(count)]).reshape(count, -1)
    counts = np.ones(count, dtype=np.bool_) if mask is None else mask
    capsules = np.flatnonzero(counts & (levers > 0.0).any(axis=1)).astype(np.int64)
    pair_levers = np.array([_apart(levers[a], levers[b]) for a, b in body.pairs.tolist()])
    pair_levers = pair_levers.reshape(len(body.pairs), len(columns))
    moved = (pair_levers > 0.0).any(axis=1)
    longest = levers.max(axis=0, initial=0.0)
    return Moving(
        columns=np.ascontiguousarray(columns, dtype=np.int64),
        capsules=capsules,
        levers=np.ascontiguousarray(levers[capsules]),
        pairs=np.ascontiguousarray(body.pairs[moved], dtype=np.int64).reshape(-1, 2),
        pair_levers=np.ascontiguousarray(pair_levers[moved]),
        metric=np.maximum(longest, LEAST_LEVER_M),
    )


def _levers(body: BodyArrays, capsule: int, columns: Indices) -> Vector:
    """Largest distance (n,) of the capsule's axis from every joint's axis; 0 if it is not moved."""
    ends = np.stack([body.starts[capsule], body.ends[capsule]])
    found: dict[int, float] = {}
    joint = int(body.carriers[capsule])
    beyond = float(np.linalg.norm(ends, axis=1).max())  # from the joint's origin
    across = float(np.linalg.norm(ends[:, :2], axis=1).max())  # from its axis
    while joint >= 0:
        found[joint] = across
        place = body.places[joint]
        across = float(np.linalg.norm(place[:2])) + beyond
        beyond += float(np.linalg.norm(place))
        joint = int(body.parents[joint])
    return np.array([found.get(int(column), 0.0) for column in columns])


def _apart(first: Vector, second: Vector) -> Vector:
    """Levers of the distance between two capsules: of the joints that move one of them alone."""
    return np.where((first > 0.0) & (second > 0.0), 0.0, np.maximum(first, second))
