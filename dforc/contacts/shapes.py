"""Where a robot's links are in space: each link as one capsule or several.

A capsule is all points within a radius of a segment, given in the axes of its link. Posed, the
capsules are flat arrays in one frame, ready to be cut by a line. They fit the meshes as closely as
they can; those of `dforc.collision` enclose them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector, constant
from dforc.errors import DforcError, NotFiniteError

Point = tuple[float, float, float]


class ShapeTableError(DforcError, ValueError):
    """Shapes that no link can have, or a link that has none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkCapsule:
    """One capsule of a link, in the link's frame."""

    link: str
    start_m: Point
    end_m: Point
    radius_m: float


@dataclass(frozen=True, slots=True, eq=False)
class PosedShapes:
    """Capsules of several links in one common frame."""

    links: tuple[str, ...]
    link_at: NDArray[np.intp]  # (m,), index into links
    start_m: Matrix  # (m, 3)
    end_m: Matrix  # (m, 3)
    radius_m: Vector  # (m,)


class LinkShapes:
    """The capsules of some links; `links` is the order of the poses that `posed` takes."""

    def __init__(self, capsules: Sequence[LinkCapsule]) -> None:
        """Keep the capsules.

        Raises:
            ShapeTableError: there is none, or a radius is not positive.
            NotFiniteError: a number is NaN or infinity.
        """
        if not capsules:
            raise ShapeTableError("no capsule was given")
        self.capsules = tuple(capsules)
        self.links = tuple(dict.fromkeys(capsule.link for capsule in capsules))
        self._link_at = np.array([self.links.index(capsule.link) for capsule in capsules])
        self._start = constant(np.array([capsule.start_m for capsule in capsules], dtype=float))
        self._end = constant(np.array([capsule.end_m for capsule in capsules], dtype=float))
        self._radius = constant([capsule.radius_m for capsule in capsules])
        if not np.isfinite(np.hstack([self._start, self._end, self._radius[:, None]])).all():
            raise NotFiniteError("a capsule is not finite")
        flat = [capsule.link for capsule in capsules if not capsule.radius_m > 0.0]
        if flat:
            raise ShapeTableError(f"the radius of a capsule of {flat[0]} is not positive")

    def only(self, links: Iterable[str]) -> "LinkShapes":
        """The capsules of these links alone, in the order of this object.

        Links without a shape (massless frames, motors inside their neighbour) are passed over.

        Raises:
            ShapeTableError: none of them has a capsule.
        """
        wanted = set(links)
        return LinkShapes([capsule for capsule in self.capsules if capsule.link in wanted])

    def posed(self, rotations: Matrix, positions_m: Matrix) -> PosedShapes:
        """The capsules in the frame of the poses.

        Args:
            rotations: of the links, (k, 3, 3), columns are the link's axes in the common frame.
            positions_m: of the links' origins, (k, 3).
        """
        R = rotations[self._link_at]
        p = positions_m[self._link_at]
        return PosedShapes(
            links=self.links,
            link_at=self._link_at,
            start_m=np.einsum("kij,kj->ki", R, self._start) + p,
            end_m=np.einsum("kij,kj->ki", R, self._end) + p,
            radius_m=self._radius,
        )

    def posed_by(self, frame_pose: Callable[[str], tuple[Matrix, Vector]]) -> PosedShapes:
        """The capsules in the frame in which `frame_pose` gives rotation and position of a link."""
        poses = [frame_pose(link) for link in self.links]
        return self.posed(np.array([R for R, _ in poses]), np.array([p for _, p in poses]))


def capsules_between_joints(
    children_m: Mapping[str, Sequence[Point]], radius_m: float
) -> tuple[LinkCapsule, ...]:
    """Shapes for a robot without a table: from a link's origin to that of each child joint.

    Args:
        children_m: for each link the origins of its child joints in its frame; a link without
            children is a ball about its origin.
        radius_m: the one radius of all, an assumption.
    """
    origin = (0.0, 0.0, 0.0)
    return tuple(
        LinkCapsule(link=link, start_m=origin, end_m=end, radius_m=radius_m)
        for link, ends in children_m.items()
        for end in dict.fromkeys(ends or (origin,))
    )
