"""Meshes of a robot's links from icub-models, in the axes of the links; what a finger reaches.

A point of a mesh can be touched when nothing of the same mesh lies in front of it: visual meshes
hold motors and the inner sides of covers, too.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from dforc.arrays import Matrix, Vector

FAR_M = 1e-4  # a ray starts that far in front of its own triangle


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles of one link."""

    corners_m: Matrix  # (triangles, 3, 3)

    @property
    def normals(self) -> Matrix:
        """Unit normals (triangles, 3), of either sense; zero where a triangle has no area."""
        cross = np.cross(*self._edges())
        length = np.linalg.norm(cross, axis=1)
        normals: Matrix = cross / np.maximum(length, 1e-15)[:, None]
        return normals

    @property
    def areas(self) -> Vector:
        """Square metres of each triangle."""
        areas: Vector = 0.5 * np.linalg.norm(np.cross(*self._edges()), axis=1)
        return areas

    def moved(self, R: Matrix, p: Vector) -> "Mesh":
        """The mesh in another frame."""
        return Mesh(self.corners_m @ R.T + p)

    def is_hit(self, origin: Vector, direction: Vector) -> bool:
        """Whether a ray meets the mesh beyond FAR_M."""
        edge1, edge2 = self._edges()
        across = np.cross(direction, edge2)
        det = (edge1 * across).sum(axis=1)
        usable = np.abs(det) > 1e-15
        scale = 1.0 / np.where(usable, det, 1.0)
        to_origin = origin - self.corners_m[:, 0]
        u = (to_origin * across).sum(axis=1) * scale
        other = np.cross(to_origin, edge1)
        v = (other @ direction) * scale
        s = (edge2 * other).sum(axis=1) * scale
        return bool((usable & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (s > FAR_M)).any())

    def random_points(self, count: int, generator: np.random.Generator) -> tuple[Matrix, Matrix]:
        """Points (count, 3) spread evenly over the area, and the normals of their triangles."""
        areas = self.areas
        which = generator.choice(len(areas), size=count, p=areas / areas.sum())
        u, v = generator.random(count), generator.random(count)
        over = u + v > 1.0
        u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
        edge1, edge2 = self._edges()
        points = self.corners_m[which, 0] + u[:, None] * edge1[which] + v[:, None] * edge2[which]
        return points, self.normals[which]

    def touchable_points(self, count: int, generator: np.random.Generator) -> tuple[Matrix, Matrix]:
        """Points on the outer surface and their outward normals (count, 3)."""
        points: list[Vector] = []
        normals: list[Vector] = []
        while len(points) < count:
            for point, normal in zip(*self.random_points(count, generator), strict=True):
                free = [n for n in (normal, -normal) if not self.is_hit(point, n)]
                if len(free) == 1:  # both sides of a loose sheet are free: it has no outside
                    points.append(point)
                    normals.append(free[0])
        return np.array(points[:count]), np.array(normals[:count])

    def _edges(self) -> tuple[Matrix, Matrix]:
        corner = self.corners_m[:, 0]
        return self.corners_m[:, 1] - corner, self.corners_m[:, 2] - corner


def load_meshes(urdf: Path) -> dict[str, Mesh]:
    """Visual meshes by link name, for a model file inside icub-models."""
    model = pin.buildModelFromUrdf(str(urdf))
    folder = str(urdf.parents[3])  # share/, where package://iCub is a folder
    shapes = pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.VISUAL, None, [folder])
    meshes = {}
    for shape in shapes.geometryObjects:
        frame = model.frames[shape.parentFrame]
        place = frame.placement.inverse() * shape.placement
        vertices = np.array(shape.geometry.vertices()) @ place.rotation.T + place.translation
        count = shape.geometry.num_tris
        corners = np.array([_three(shape.geometry.tri_indices(i)) for i in range(count)])
        meshes[str(frame.name)] = Mesh(vertices[corners])
    return meshes


def _three(triangle: "pin.StdVec_Index") -> list[int]:
    return [int(triangle[0]), int(triangle[1]), int(triangle[2])]
