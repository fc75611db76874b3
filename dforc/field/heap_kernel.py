"""A heap of nodes by their keys, that knows where each node stands, for numba."""

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Vector
from dforc.compiled import compiled

Indices = NDArray[np.int64]


@compiled
def lift(heap: Indices, keys: Vector, ranks: Indices, rank: int) -> None:
    """Move the node at a place up to where its key, which has become smaller, belongs."""
    node = heap[rank]
    while rank > 0:
        above = (rank - 1) // 2
        if keys[heap[above]] <= keys[node]:
            break
        heap[rank] = heap[above]
        ranks[heap[rank]] = rank
        rank = above
    heap[rank] = node
    ranks[node] = rank


@compiled
def pop(heap: Indices, keys: Vector, ranks: Indices, size: int) -> int:
    """Take the first of `size` nodes out."""
    first, node = heap[0], heap[size - 1]
    size -= 1
    rank = 0
    while 2 * rank + 1 < size:
        below = 2 * rank + 1
        if below + 1 < size and keys[heap[below + 1]] < keys[heap[below]]:
            below += 1
        if keys[heap[below]] >= keys[node]:
            break
        heap[rank] = heap[below]
        ranks[heap[rank]] = rank
        rank = below
    heap[rank] = node
    ranks[node] = rank
    return int(first)
