"""What the robot must not touch: spheres, ellipsoids, boxes and cylinders in the base frame."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.errors import DforcError

Triple = tuple[float, float, float]
Rows = tuple[Triple, Triple, Triple]

IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
STILL: Triple = (0.0, 0.0, 0.0)
ROTATION_ERROR = 1e-6  # largest entry of R R' - I of what still is a rotation
THINNEST_M = 1e-4  # half of the bounding box of a flat mesh


class Shape(IntEnum):
    """What an obstacle can be."""

    SPHERE = 0
    ELLIPSOID = 1
    BOX = 2
    CYLINDER = 3


SIZES = {Shape.SPHERE: 1, Shape.ELLIPSOID: 3, Shape.BOX: 3, Shape.CYLINDER: 2}  # how many count


class ObstacleError(DforcError, ValueError):
    """An obstacle that cannot be: no size, no rotation, or numbers that are not finite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """One solid.

    `size_m` of a sphere: radius, 0, 0; of an ellipsoid: semi-axes; of a box: half its edges; of a
    cylinder: radius and half its length along its own z, 0. The columns of `rotation` are the
    solid's axes in the base frame. `margin_m` makes it larger all around.
    """

    name: str
    shape: Shape
    size_m: Triple
    position_m: Triple
    rotation: Rows = IDENTITY
    velocity_m_s: Triple = STILL
    margin_m: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot be.

        Raises:
            ObstacleError: with the obstacle's name and the value.
        """
        for field in ("size_m", "position_m", "velocity_m_s"):
            values = getattr(self, field)
            if len(values) != 3 or not np.isfinite(values).all():
                raise ObstacleError(f"obstacle {self.name!r}: {field} is {values}, not 3 numbers")
        used = SIZES[self.shape]
        if min(self.size_m[:used]) <= 0.0 or any(self.size_m[used:]):
            raise ObstacleError(
                f"obstacle {self.name!r}: size_m of a {self.shape.name.lower()} is {self.size_m}; "
                f"the first {used} must be positive, the others zero"
            )
        R = np.array(self.rotation, dtype=np.float64)
        if R.shape != (3, 3) or not np.abs(R @ R.T - np.eye(3)).max() <= ROTATION_ERROR:
            raise ObstacleError(f"obstacle {self.name!r}: {self.rotation} is no rotation")
        if np.linalg.det(R) < 0.0:
            raise ObstacleError(f"obstacle {self.name!r}: {self.rotation} is a mirror")
        if not 0.0 <= self.margin_m < np.inf:
            raise ObstacleError(f"obstacle {self.name!r}: margin_m is {self.margin_m}")


class World(NamedTuple):
    """All obstacles, as the compiled functions want them."""

    kinds: NDArray[np.int64]  # (m,)
    sizes: Matrix  # (m, 3)
    rotations: Matrix  # (m, 9) by rows
    centres: Matrix  # (m, 3)
    velocities: Matrix  # (m, 3)
    margins: Vector  # (m,)
    reaches: Vector  # (m,) radius of the ball around the centre that holds the solid, no margin


def world_of(obstacles: Sequence[Obstacle]) -> World:
    """The arrays of some obstacles, in their order; of none, too."""
    return World(
        kinds=np.array([one.shape for one in obstacles], dtype=np.int64),
        sizes=_table([one.size_m for one in obstacles], 3),
        rotations=_table([[x for row in one.rotation for x in row] for one in obstacles], 9),
        centres=_table([one.position_m for one in obstacles], 3),
        velocities=_table([one.velocity_m_s for one in obstacles], 3),
        margins=np.array([one.margin_m for one in obstacles], dtype=np.float64),
        reaches=np.array([_reach_m(one) for one in obstacles], dtype=np.float64),
    )


def sphere(name: str, position_m: Triple, radius_m: float) -> Obstacle:
    """A ball."""
    return Obstacle(
        name=name, shape=Shape.SPHERE, size_m=(radius_m, 0.0, 0.0), position_m=position_m
    )


def ellipsoid(
    name: str, position_m: Triple, semi_axes_m: Triple, rotation: Rows = IDENTITY
) -> Obstacle:
    """An ellipsoid with these semi-axes along its own axes."""
    return Obstacle(
        name=name,
        shape=Shape.ELLIPSOID,
        size_m=semi_axes_m,
        position_m=position_m,
        rotation=rotation,
    )


def box(name: str, position_m: Triple, half_edges_m: Triple, rotation: Rows = IDENTITY) -> Obstacle:
    """A box around its centre."""
    return Obstacle(
        name=name, shape=Shape.BOX, size_m=half_edges_m, position_m=position_m, rotation=rotation
    )


def cylinder(
    name: str,
    position_m: Triple,
    radius_m: float,
    half_length_m: float,
    rotation: Rows = IDENTITY,
) -> Obstacle:
    """A cylinder around its own z axis, with flat ends."""
    return Obstacle(
        name=name,
        shape=Shape.CYLINDER,
        size_m=(radius_m, half_length_m, 0.0),
        position_m=position_m,
        rotation=rotation,
    )


def mesh_bounds(
    name: str, vertices_m: Matrix, position_m: Triple = STILL, rotation: Rows = IDENTITY
) -> Obstacle:
    """The box along a mesh's own axes that holds its vertices (k, 3); the pose is the mesh's.

    Raises:
        ObstacleError: no vertices, or not finite.
    """
    points = np.asarray(vertices_m, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ObstacleError(f"obstacle {name!r}: vertices of shape {points.shape}, not (k, 3)")
    low, high = points.min(axis=0), points.max(axis=0)
    half = np.maximum(0.5 * (high - low), THINNEST_M)
    centre = np.array(position_m) + np.array(rotation) @ (0.5 * (low + high))
    return box(name, _triple(centre), _triple(half), rotation)


def _triple(values: Vector) -> Triple:
    x, y, z = values.tolist()
    return x, y, z


def _table(rows: Sequence[Sequence[float]], width: int) -> Matrix:
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)


def _reach_m(obstacle: Obstacle) -> float:
    if obstacle.shape in (Shape.BOX, Shape.CYLINDER):
        return float(np.linalg.norm(obstacle.size_m))
    return max(obstacle.size_m)
