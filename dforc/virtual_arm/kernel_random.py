"""Postures at random inside limits and rows, for numba, the same with and without it.

L'Ecuyer's combined generator (1988): all its integers stay far inside 64 bits.
"""

from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.limits import JointLimits

FIRST_FACTOR, FIRST_PRIME = 40014, 2147483563
SECOND_FACTOR, SECOND_PRIME = 40692, 2147483399
WIDEST_RAD = 2.0 * np.pi
EVERYWHERE = 2.0  # as a share of the joints' ranges, around any posture
DRAWS = 8  # before a posture outside the rows is drawn towards one inside


class Room(NamedTuple):
    """Limits and rows of the joints, with finite ranges."""

    C: Matrix  # (n + m, n)
    lower: Vector  # (n + m,)
    upper: Vector


def room_of(limits: JointLimits) -> Room:
    """The room of limits; a joint without an end has one turn to each side."""
    n = limits.n
    lower, upper = limits.lower.copy(), limits.upper.copy()
    lower[:n] = np.maximum(lower[:n], -WIDEST_RAD)
    upper[:n] = np.minimum(upper[:n], WIDEST_RAD)
    return Room(limits.C.copy(), lower, upper)


def seeds(seed: int) -> tuple[int, int]:
    """State of a generator (2,), never zero."""
    first = (seed * 2654435761 + 12345) % (FIRST_PRIME - 1) + 1
    second = (seed * 40503 + 6789) % (SECOND_PRIME - 1) + 1
    return first, second


@compiled
def uniform(state: Indices) -> float:
    """The next number in 0 to 1, both excluded."""
    state[0] = (FIRST_FACTOR * state[0]) % FIRST_PRIME
    state[1] = (SECOND_FACTOR * state[1]) % SECOND_PRIME
    mixed = (state[0] - state[1]) % (FIRST_PRIME - 1)
    share: float = (mixed + 0.5) / (FIRST_PRIME - 1)
    return share


@compiled
def inside_share(room: Room, a: Vector, b: Vector) -> float:
    """How far the rows let one go from a, inside them, towards b (0 to 1)."""
    n, share = len(a), 1.0
    for row in range(n, len(room.lower)):
        here, step = 0.0, 0.0
        for j in range(n):
            here += room.C[row, j] * a[j]
            step += room.C[row, j] * (b[j] - a[j])
        if here + step > room.upper[row]:
            share = min(share, max(0.0, (room.upper[row] - here) / step))
        elif here + step < room.lower[row]:
            share = min(share, max(0.0, (room.lower[row] - here) / step))
    return share


@compiled
def draw(state: Indices, room: Room, anchor: Vector, spread: float, q: Vector) -> None:
    """A posture in q; the anchor is one inside the rows.

    `spread` is the share of each joint's range that is drawn from, around the anchor.
    """
    n, share = len(q), 0.0
    for _ in range(DRAWS):
        for j in range(n):
            half = 0.5 * spread * (room.upper[j] - room.lower[j])
            low = max(room.lower[j], min(anchor[j] - half, room.upper[j] - 2.0 * half))
            high = min(room.upper[j], max(anchor[j] + half, room.lower[j] + 2.0 * half))
            q[j] = low + uniform(state) * (high - low)
        share = inside_share(room, anchor, q)
        if share >= 1.0:
            return
    for j in range(n):
        q[j] = anchor[j] + share * (q[j] - anchor[j])
