"""Contacts from the skin: which link is pressed, where on it, and by how many taxels.

A link that is pressed is one contact, however many of its boards feel it. A board counts as long as
it is heard; TIMEOUT_S after its last word it counts no more. What its taxels' places are is robot
data: a point for each triangle, or one for the whole board.

The kind follows iCub's rule: the moment of a small contact is taken as zero when the limb has other
contacts. A contact that is alone keeps its moment: then no torque depends on the point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dforc.arrays import Matrix, Vector, constant
from dforc.contacts.shapes import Point
from dforc.errors import DforcError, NotFiniteError, ShapeError

TAXELS = 12  # of a triangle
TRIANGLES = 16  # of a board
TIMEOUT_S = 0.2
FEW_TAXELS = 10
PRESSED = 10  # counts below the level without load, of 255; a taxel at rest moves by a few


class UnknownBoardError(DforcError, ValueError):
    """A skin board was heard whose place on the robot is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SkinPatch:
    """Where one skin board is: its link and the middle of its taxels, or of each triangle's."""

    board: str
    limb: str  # contacts of one limb share a force/torque sensor
    link: str
    point_m: Point
    triangles_m: tuple[Point, ...] = ()  # 16, or none where only `point_m` is known


@dataclass(frozen=True, slots=True, kw_only=True)
class SkinContact:
    """One pressed link."""

    limb: str
    link: str
    point_m: Point  # in the link's frame, weighted with the pressure
    pressure: float  # counts of all pressed taxels together
    taxels: int
    kind: Literal["wrench", "force"]


class SkinContacts:
    """What the boards felt last."""

    def __init__(self, patches: Sequence[SkinPatch]) -> None:
        """Keep the places.

        Raises:
            ShapeError: a board has triangles, but not 16.
            NotFiniteError: a place is NaN or infinity.
        """
        self._patches = {patch.board: patch for patch in patches}
        self._places = {patch.board: _places(patch) for patch in patches}
        self._pressure: dict[str, Vector] = {}  # (16,) counts per triangle
        self._pressed: dict[str, int] = {}
        self._heard_ns: dict[str, int] = {}

    def hear(self, board: str, taxels: bytes, errors: bytes, no_load: int, arrival_ns: int) -> None:
        """Take a board's sample; triangles with an error feel nothing.

        Args:
            board: a name among the patches.
            taxels: 192 levels, lower under pressure.
            errors: 16, 0 where a triangle was read.
            no_load: level of a taxel at rest.
            arrival_ns: when it came.

        Raises:
            UnknownBoardError: no patch has this name.
            ShapeError: not 192 taxels and 16 errors.
        """
        if board not in self._patches:
            known = ", ".join(self._patches)
            raise UnknownBoardError(f"no place is known for skin board {board!r}; known: {known}")
        if len(taxels) != TRIANGLES * TAXELS or len(errors) != TRIANGLES:
            raise ShapeError(f"skin of {board}: {len(taxels)} taxels, {len(errors)} errors")
        load = no_load - np.frombuffer(taxels, dtype=np.uint8).astype(np.int64)
        load = np.where(load >= PRESSED, load, 0).reshape(TRIANGLES, TAXELS)
        load[np.frombuffer(errors, dtype=np.uint8) != 0] = 0
        self._pressure[board] = load.sum(axis=1).astype(np.float64)
        self._pressed[board] = int(np.count_nonzero(load))
        self._heard_ns[board] = arrival_ns

    def contacts(self, now_ns: int) -> tuple[SkinContact, ...]:
        """The pressed links, in the order of the patches."""
        boards: dict[tuple[str, str], list[str]] = {}
        for name, patch in self._patches.items():
            age_s = (now_ns - self._heard_ns.get(name, now_ns)) * 1e-9
            if self._pressed.get(name, 0) > 0 and age_s <= TIMEOUT_S:
                boards.setdefault((patch.limb, patch.link), []).append(name)
        limbs = [limb for limb, _ in boards]
        return tuple(
            self._contact(limb, link, names, limbs.count(limb) == 1)
            for (limb, link), names in boards.items()
        )

    def _contact(self, limb: str, link: str, names: list[str], alone: bool) -> SkinContact:
        taxels = sum(self._pressed[name] for name in names)
        weights = np.concatenate([self._pressure[name] for name in names])
        places = np.vstack([self._places[name] for name in names])
        x, y, z = (weights @ places / weights.sum()).tolist()
        return SkinContact(
            limb=limb,
            link=link,
            point_m=(x, y, z),
            pressure=float(weights.sum()),
            taxels=taxels,
            kind="wrench" if alone or taxels >= FEW_TAXELS else "force",
        )


def _places(patch: SkinPatch) -> Matrix:
    triangles = patch.triangles_m or (patch.point_m,) * TRIANGLES
    if len(triangles) != TRIANGLES:
        raise ShapeError(f"skin board {patch.board}: {len(triangles)} triangles, not {TRIANGLES}")
    if not np.isfinite(triangles).all():
        raise NotFiniteError(f"skin board {patch.board}: a place is not finite")
    return constant(np.array(triangles, dtype=np.float64))
