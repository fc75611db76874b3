"""The robot's body as capsules on a tree of joints, for distances from obstacles and from itself.

All joints that are not in the body's vector stay at zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.obstacles import Triple
from dforc.errors import DforcError
from dforc.ik.kernel_chain import Indices, rotation_onto
from dforc.robot_model import ChainElement, tree_description


class BodyError(DforcError, ValueError):
    """A capsule, pair or order of joints that makes no body."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyCapsule:
    """All points within a radius of a segment, in the frame of a link of the URDF."""

    name: str
    link: str
    start_m: Triple
    end_m: Triple
    radius_m: float

    def __post_init__(self) -> None:
        """Refuse what is no capsule.

        Raises:
            BodyError: with the capsule's name and the value.
        """
        numbers = (*self.start_m, *self.end_m)
        if len(numbers) != 6 or not np.isfinite(numbers).all():
            raise BodyError(f"capsule {self.name!r}: from {self.start_m} to {self.end_m}")
        if not 0.0 < self.radius_m < np.inf:
            raise BodyError(f"capsule {self.name!r}: radius_m is {self.radius_m}")


class BodyArrays(NamedTuple):
    """The body, as the compiled functions want it: every joint's axis is the z of its frame."""

    parents: Indices  # (N,) joint before each, -1 the base; always smaller than the joint's own
    turns: Matrix  # (N, 9) rotation of each joint's frame in the one before, by rows
    places: Matrix  # (N, 3) and its origin
    carriers: Indices  # (c,) joint that carries each capsule, -1 the base
    starts: Matrix  # (c, 3) in the carrier's frame
    ends: Matrix  # (c, 3)
    radii: Vector  # (c,)
    pairs: NDArray[np.int64]  # (p, 2) capsules that may touch each other
    tip_carriers: Indices  # (t,)
    tip_turns: Matrix  # (t, 9)
    tip_places: Matrix  # (t, 3)
    halves: Vector  # (c,) half the length of each axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Body:
    """Names and arrays of one robot's body."""

    joints: tuple[str, ...]  # (N,)
    capsules: tuple[str, ...]  # (c,)
    tips: tuple[str, ...]  # (t,) frames
    arrays: BodyArrays

    @classmethod
    def make(
        cls,
        urdf_path: str,
        joints: Sequence[str],
        capsules: Sequence[BodyCapsule],
        tips: Sequence[str],
        always_near: Sequence[tuple[str, str]] = (),
    ) -> "Body":
        """Read the tree from a URDF.

        Args:
            urdf_path: the model.
            joints: that move, each behind the one that carries it.
            capsules: each on a link.
            tips: frames, for example of the hands.
            always_near: names of two capsules that touch by construction, or at most postures:
                left out of `pairs`, as are those that no joint moves against each other.

        Raises:
            BodyError: names that are not there, twice there, or in the wrong order.
        """
        names = [one.name for one in capsules]
        if len(set(names)) < len(names):
            raise BodyError(f"two capsules of one name among {', '.join(names)}")
        unknown = {name for pair in always_near for name in pair} - set(names)
        if unknown:
            raise BodyError(f"no capsule {min(unknown)!r}; known: {', '.join(names)}")
        frames = [one.link for one in capsules]
        tree, held = tree_description(urdf_path, joints, [*frames, *tips])
        for joint, element in enumerate(tree):
            if element.parent >= joint:
                raise BodyError(f"joint {joints[joint]!r} stands before {joints[element.parent]!r}")
        align = [rotation_onto(element.axis) for element in tree]
        placed = [_aligned(one, align, own) for one, own in zip(tree, align, strict=True)]
        carried = [_aligned(one, align, np.eye(3)) for one in held]
        on_links, on_tips = carried[: len(names)], carried[len(names) :]
        ends = [
            [R @ np.array(point) + p for point in (one.start_m, one.end_m)]
            for one, (R, p) in zip(capsules, on_links, strict=True)
        ]
        carriers = np.array([one.parent for one in held[: len(names)]], dtype=np.int64)
        near = {frozenset(pair) for pair in always_near}
        pairs = [
            (i, j)
            for i in range(len(names))
            for j in range(i + 1, len(names))
            if carriers[i] != carriers[j] and frozenset((names[i], names[j])) not in near
        ]
        arrays = BodyArrays(
            parents=np.array([one.parent for one in tree], dtype=np.int64),
            turns=np.array([R for R, _ in placed], dtype=np.float64).reshape(-1, 9),
            places=np.array([p for _, p in placed], dtype=np.float64).reshape(-1, 3),
            carriers=carriers,
            starts=np.array([a for a, _ in ends], dtype=np.float64).reshape(-1, 3),
            ends=np.array([b for _, b in ends], dtype=np.float64).reshape(-1, 3),
            radii=np.array([one.radius_m for one in capsules], dtype=np.float64),
            pairs=np.array(pairs, dtype=np.int64).reshape(-1, 2),
            tip_carriers=np.array([one.parent for one in held[len(names) :]], dtype=np.int64),
            tip_turns=np.array([R for R, _ in on_tips], dtype=np.float64).reshape(-1, 9),
            tip_places=np.array([p for _, p in on_tips], dtype=np.float64).reshape(-1, 3),
            halves=np.array([0.5 * np.linalg.norm(b - a) for a, b in ends], dtype=np.float64),
        )
        return cls(joints=tuple(joints), capsules=tuple(names), tips=tuple(tips), arrays=arrays)

    def columns(self, joints: Sequence[str]) -> Indices:
        """Where some joints stand in the body's vector.

        Raises:
            BodyError: one is not there.
        """
        unknown = [name for name in joints if name not in self.joints]
        if unknown:
            raise BodyError(f"no joint {unknown[0]!r}; known: {', '.join(self.joints)}")
        return np.array([self.joints.index(name) for name in joints], dtype=np.int64)

    def moved_by(self, joints: Sequence[str]) -> NDArray[np.bool_]:
        """Which capsules (c,) some joints move: the mask of what can be kept from obstacles."""
        moving = np.zeros(len(self.joints) + 1, dtype=np.bool_)  # the last for the base, -1
        moving[self.columns(joints)] = True
        for joint, parent in enumerate(self.arrays.parents):
            moving[joint] |= moving[parent]
        mask: NDArray[np.bool_] = moving[self.arrays.carriers]
        return mask

    def keeping(self, mask: NDArray[np.bool_]) -> "Body":
        """The same body, of whose pairs only those with a capsule in `mask` (c,) are left."""
        pairs = self.arrays.pairs
        kept = pairs[mask[pairs].any(axis=1)]
        return replace(self, arrays=self.arrays._replace(pairs=np.ascontiguousarray(kept)))


def _aligned(one: ChainElement, align: Sequence[Matrix], own: Matrix) -> tuple[Matrix, Vector]:
    """Pose in the parent's frame as kept here, of a frame turned by `own`."""
    turned = np.eye(3) if one.parent < 0 else align[one.parent]
    return turned.T @ one.R @ own, turned.T @ one.p
