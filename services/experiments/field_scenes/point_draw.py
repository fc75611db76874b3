"""Scenes of balls for a bare point: at random near its straight line, and hard ones."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.collision.obstacles import Obstacle, sphere

Array = NDArray[np.float64]

DISTANCE_M = (0.25, 0.45)  # from start to goal
RADIUS_M = (0.02, 0.06)
SPREAD_M = 0.04  # sigma of the centres about the line
CLEAR_M = 0.03  # of start and goal
PERTURBED_M = 0.003  # sigma of every place in the hard scenes
HARD_DISTANCE_M = 0.4


@dataclass(frozen=True, eq=False)
class PointScene:
    """Where a point starts, where it is to go, and what is in between."""

    start_m: Array
    goal_m: Array
    balls: tuple[tuple[Array, float], ...]  # centre and radius

    def obstacles(self) -> list[Obstacle]:
        """The balls as dforc.collision has them."""
        return [sphere(f"ball {i}", tuple(c.tolist()), r) for i, (c, r) in enumerate(self.balls)]


def random_scene(rng: np.random.Generator, count: int) -> PointScene:
    """So many balls near the line; they may overlap."""
    start, along = np.zeros(3), direction(rng)
    goal = start + rng.uniform(*DISTANCE_M) * along
    balls: list[tuple[Array, float]] = []
    while len(balls) < count:
        centre = start + rng.uniform() * (goal - start) + rng.normal(0.0, SPREAD_M, 3)
        radius = rng.uniform(*RADIUS_M)
        nearest = min(np.linalg.norm(centre - start), np.linalg.norm(centre - goal))
        if nearest - radius >= CLEAR_M:
            balls.append((centre, radius))
    return PointScene(start, goal, tuple(balls))


def direction(rng: np.random.Generator) -> Array:
    """A unit vector, every direction as likely."""
    vector: Array = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def hard_scene(rng: np.random.Generator, family: str) -> PointScene:
    """One of a family: its balls about the line's middle, every place a little off, turned."""
    balls = [(c + rng.normal(0.0, PERTURBED_M, 3), r) for c, r in FAMILIES[family](rng)]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    ends = np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]) * HARD_DISTANCE_M
    ends = (ends + rng.normal(0.0, PERTURBED_M, (2, 3))) @ turn.T
    return PointScene(ends[0], ends[1], tuple((turn @ c, r) for c, r in balls))


Balls = list[tuple[Array, float]]


def _head_on(rng: np.random.Generator) -> Balls:
    """One ball exactly in the way."""
    return [(np.zeros(3), rng.uniform(0.03, 0.06))]


def _cusp(rng: np.random.Generator) -> Balls:
    """Two that touch on the line."""
    radius = rng.uniform(0.03, 0.06)
    return [(np.array([0.0, side * radius, 0.0]), radius) for side in (-1.0, 1.0)]


def _wall(rng: np.random.Generator) -> Balls:
    """Five by five across the line, no gap wide enough for a margin of 1 cm."""
    radius = rng.uniform(0.025, 0.03)
    places = 0.055 * np.arange(-2, 3)
    return [(np.array([0.0, y, z]), radius) for y in places for z in places]


def _ring(rng: np.random.Generator) -> Balls:
    """Twelve around the line: the way is through the middle."""
    radius = rng.uniform(0.02, 0.03)
    wide = rng.uniform(0.06, 0.08)
    angles = np.arange(12) * np.pi / 6.0
    return [(np.array([0.0, wide * np.cos(a), wide * np.sin(a)]), radius) for a in angles]


def _cup(rng: np.random.Generator) -> Balls:
    """Half a shell around the line, open towards the start."""
    radius, wide = 0.025, rng.uniform(0.08, 0.1)
    balls = [(np.array([wide, 0.0, 0.0]), radius)]
    for k, count in ((1, 6), (2, 11), (3, 15)):
        tilt = k * np.pi / 6.0
        for a in 2.0 * np.pi * np.arange(count) / count:
            across = wide * np.sin(tilt)
            centre = np.array([wide * np.cos(tilt), across * np.cos(a), across * np.sin(a)])
            balls.append((centre, radius))
    return [(c - np.array([0.5 * wide, 0.0, 0.0]), r) for c, r in balls]


FAMILIES: dict[str, Callable[[np.random.Generator], Balls]] = {
    "head-on": _head_on,
    "cusp": _cusp,
    "wall": _wall,
    "ring": _ring,
    "cup": _cup,
}
