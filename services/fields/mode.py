"""What a mode of the field is: it moves the hands' virtual points, one period at a time.

A mode owns what it keeps from one period to the next, and nothing else: no clock, no streams. It
begins where it is told, and a change of its gains never moves a point.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.collision.obstacles import World, world_of
from services.fields.limbs import FieldLimb
from services.fields.seen import SeenObject

PERIOD_S = 0.01  # the papers' sample time


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class HandGoal:
    """Where one hand is to go, base frame."""

    position_m: Vector  # (3,)
    rotation: Matrix | None = None  # (3, 3); None: it may turn as it likes
    velocity_m_s: Vector = field(default_factory=lambda: np.zeros(3))  # of the goal


Goals = Sequence[HandGoal | None]  # one per hand of the limb; None: that one is free


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class HandPoint:
    """The virtual point of one hand, base frame."""

    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)
    velocity_m_s: Vector = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Start:
    """Where a mode begins: a posture of the limb and the points of its hands, which belong to it.

    A mode of postures moves from the posture on, one of points from the points on.
    """

    q_rad: Vector  # (n,)
    dq_rad_s: Vector  # (n,)
    hands: tuple[HandPoint, ...]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Surroundings:
    """What is around the limb in one period."""

    obstacles: tuple[SeenObject, ...] = ()  # those that are on, without what is followed
    targets: tuple[SeenObject, ...] = ()  # objects that may attract
    world: World = field(default_factory=lambda: world_of(()))  # of the obstacles, in their order
    body_rad: Vector = field(default_factory=lambda: np.zeros(0))  # (N,) measured, whole body
    body_rad_s: Vector = field(default_factory=lambda: np.zeros(0))  # (N,)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Motion:
    """What one period has brought."""

    hands: tuple[HandPoint, ...]
    state: str  # idle | reaching | planning | waiting | unreachable | arrived
    reason: str = ""  # with what would help
    q_rad: Vector | None = None  # posture whose hands the points are; None: the mode keeps none
    dq_rad_s: Vector | None = None
    clearance_m: float = float("inf")  # of the hand, or of the whole arm where there is a posture
    nearest: tuple[str, str] = ("", "")
    iterations: int = 0
    nodes: int = 0
    held: bool = False  # the last safe velocity was held


class FieldMode(Protocol):
    """One law of motion of one limb."""

    name: str
    budget: int  # iterations of one period at most; 0 = none are needed
    preview_steps: int  # periods of a roll-out that one period of the service has time for

    def use(self, gains: Mapping[str, float]) -> None:
        """Take other gains, all of the mode's, from the next period on."""

    def begin(self, start: Start) -> None:
        """Start there.

        Raises:
            DforcError: the start is none.
        """

    def new_goal(self) -> None:
        """The next goals are new ones: what was found of those before is no verdict on them."""

    def step(self, goals: Goals | None, around: Surroundings, lag_m: float) -> Motion:
        """One period; without goals the points come to rest, and are still kept out of the way.

        Raises:
            DforcError: something that was given is none; nothing has moved.
        """

    def forces(self, goals: Goals | None, around: Surroundings) -> dict[str, float]:
        """Force of every field by name [N], where the mode works with forces."""


class ModeOf(Protocol):
    """Makes a mode for a limb."""

    def __call__(self, limb: FieldLimb, gains: Mapping[str, float]) -> FieldMode:
        """A mode that has not begun.

        Raises:
            ServiceError: the mode does not move such a limb.
        """
