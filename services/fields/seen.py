"""An object of the world at one instant, and what the numerics take it for."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dforc import rotation
from dforc.collision.obstacles import IDENTITY, STILL, Obstacle, Rows, Shape, Triple, mesh_bounds
from dforc.field.force import Ellipsoid
from services.messages import WorldObject

SIGMAS = 3.0  # of an object's position that are kept free around it
# An arm is where its virtual one was 0.16 s ago: 0.56 T of the controller, and the way there. So an
# object that moves is taken to fill all that it will have passed through by then.
AHEAD_S = 0.08
# What is moved by hand may come faster or turn by then: 1.5 m/s2 of change, seen some time late.
SURGE_M = 0.02
SURGE_FROM_M_S = 0.1
WIDEST_M = 0.10  # but no more than this: a hand in doubt must not be locked in
SHAPES = {shape.name.lower(): shape for shape in Shape}
MESH = "mesh"
SHAPE_NAMES = (*SHAPES, MESH)
# Semi-axes of the smallest ellipsoid of the same axes around a box, and around a cylinder.
BOX_SCALE = math.sqrt(3.0)
CYLINDER_SCALE = (math.sqrt(1.5), math.sqrt(1.5), math.sqrt(3.0))


class Sighting(NamedTuple):
    """A place and its motion."""

    position_m: Triple
    velocity_m_s: Triple
    sigma_m: float  # of the place

    def after(self, time_s: float) -> "Sighting":
        """The same, moved on."""
        x, y, z = (p + time_s * v for p, v in zip(self.position_m, self.velocity_m_s, strict=True))
        return self._replace(position_m=(x, y, z))

    def given_up(self, time_s: float) -> "Sighting":
        """What is not seen any more, and may since have gone on as fast to any side.

        The room that is kept for it stays, and grows; its doubt is a third of that.
        """
        centre_m, margin_m = room(self)
        grown_m = min(WIDEST_M, margin_m + time_s * math.hypot(*self.velocity_m_s))
        return Sighting(centre_m, STILL, grown_m / SIGMAS)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenObject:
    """Where an object is taken to be now."""

    name: str
    source: str
    solid: Obstacle  # at this place, at this speed, without margin
    role: str
    on: bool
    sigma_m: float = 0.0
    avoided: Sighting | None = None  # where nothing may come, if that is somewhere else
    age_s: float = 0.0
    lost: str = ""  # why its place is no longer known

    @property
    def place_m(self) -> Triple:
        """Its centre."""
        return self.solid.position_m

    @property
    def velocity_m_s(self) -> Triple:
        """Of its centre."""
        return self.solid.velocity_m_s


def solid_of(item: WorldObject) -> Obstacle:
    """The solid that an object is, where it says that it is, at rest.

    Raises:
        ObstacleError, NotFiniteError: it is none.
    """
    turned = _rows(item.rotation_rad)
    if item.shape == MESH:
        vertices = np.array(item.vertices_m, dtype=np.float64)
        return mesh_bounds(item.name, vertices, item.position_m, turned)
    a, b, c = (*item.size_m, 0.0, 0.0, 0.0)[:3]
    return Obstacle(
        name=item.name,
        shape=SHAPES[item.shape],
        size_m=(a, b, c),
        position_m=item.position_m,
        rotation=turned,
    )


def as_obstacle(seen: SeenObject) -> Obstacle:
    """With the margin that its uncertainty asks for, and where it will be."""
    solid = seen.solid
    kept = seen.avoided or Sighting(seen.place_m, seen.velocity_m_s, seen.sigma_m)
    if kept.sigma_m == 0.0 and not any(kept.velocity_m_s):
        return solid
    centre_m, margin_m = room(kept)
    return Obstacle(
        name=seen.name,
        shape=solid.shape,
        size_m=solid.size_m,
        position_m=centre_m,
        rotation=solid.rotation,
        velocity_m_s=kept.velocity_m_s,
        margin_m=margin_m,
    )


def room(kept: Sighting) -> tuple[Triple, float]:
    """Where the solid is taken to be in the middle of its way, and the margin that holds the way.

    Where the margin would be too wide the way is cut: the solid where it is now is always inside.
    """
    speed_m_s = math.hypot(*kept.velocity_m_s)
    surge_m = SURGE_M * min(1.0, speed_m_s / SURGE_FROM_M_S)
    margin_m = min(WIDEST_M, SIGMAS * kept.sigma_m + AHEAD_S * speed_m_s + surge_m)
    ahead_s = AHEAD_S if AHEAD_S * speed_m_s <= margin_m else margin_m / speed_m_s
    return kept.after(ahead_s).position_m, margin_m


def as_ellipsoid(seen: SeenObject) -> Ellipsoid:
    """As the paper's field has it: the ellipsoid around the solid, without regard to noise."""
    solid = seen.solid
    return Ellipsoid(
        centre_m=solid.position_m, semi_axes_m=semi_axes_m(solid), rotation=solid.rotation
    )


def semi_axes_m(solid: Obstacle) -> Triple:
    """Of the ellipsoid along the solid's axes that holds it."""
    a, b, c = solid.size_m
    if solid.shape is Shape.SPHERE:
        return a, a, a
    if solid.shape is Shape.BOX:
        return BOX_SCALE * a, BOX_SCALE * b, BOX_SCALE * c
    if solid.shape is Shape.CYLINDER:
        x, y, z = CYLINDER_SCALE
        return x * a, y * a, z * b
    return a, b, c


def _rows(rotation_rad: Triple) -> Rows:
    if not any(rotation_rad):
        return IDENTITY
    a, b, c = rotation.matrix(rotation_rad).tolist()
    return (a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])
