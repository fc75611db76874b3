"""Everything that is drawn from the plant's seed, each from a generator of its own.

Drawing one thing more must not change what the others get, or every trajectory changes with it.
"""

from enum import IntEnum

import numpy as np


class Draw(IntEnum):
    """What is drawn. The numbers are part of every result: never renumber, only append."""

    MASS = 0
    LEVER = 1
    SENSOR_OFFSET = 2
    SENSOR_NOISE = 3


def generator(seed: int, draw: Draw, index: int = 0) -> np.random.Generator:
    """The generator of one kind of draw, of the `index`-th thing that draws it."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(draw), index)))
