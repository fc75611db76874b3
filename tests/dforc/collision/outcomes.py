"""Numbers of a few postures, to be compared with and without a compiler."""

import json
import sys

import numpy as np

from dforc.collision.kernel_body import clearance
from dforc.collision.obstacles import world_of
from tests.dforc.collision.bodies import Room, make_body, random_obstacles, random_postures

Numbers = list[list[float]]


def numbers() -> Numbers:
    """Of each posture: clearance, then the rows of its proximities."""
    room, world = Room(make_body(), rows=40), world_of(random_obstacles(6, seed=12))
    found: Numbers = []
    for q in random_postures(3, seed=13):
        least = clearance(
            q,
            room.body.arrays,
            world,
            room.mask,
            room.frames,
            room.segments,
            0.02,
            0.03,
            -np.inf,
        )
        found.append([least])
        for key, (far, gradient, drift) in sorted(room.near(q, world, 0.3, 0.2).items()):
            found.append([*map(float, key), far, drift, *gradient.tolist()])
    return found


def print_numbers() -> None:
    """One line."""
    sys.stdout.write(json.dumps(numbers()))
