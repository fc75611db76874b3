"""What the virtual arm is asked for, and what it says."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.ik.problem import checked_rotation


@dataclass(frozen=True, slots=True, eq=False)
class TipGoal:
    """Where a hand is to be, base frame; a rotation of None does not matter."""

    position_m: Vector  # (3,)
    rotation: Matrix | None = None  # (3, 3)
    velocity_m_s: Vector = field(default_factory=lambda: constant(np.zeros(3)))  # of the goal

    @classmethod
    def checked(
        cls,
        position_m: ArrayLike,
        rotation: Matrix | None = None,
        velocity_m_s: ArrayLike = (0.0, 0.0, 0.0),
    ) -> "TipGoal":
        """A copy.

        Raises:
            NotFiniteError: NaN or infinity.
            ShapeError: another shape, or no rotation matrix.
        """
        return cls(
            finite_vector("goal", position_m, 3),
            None if rotation is None else checked_rotation(rotation),
            finite_vector("velocity of the goal", velocity_m_s, 3),
        )

    @property
    def is_finite(self) -> bool:
        """Whether all of it are numbers."""
        values = (self.position_m, self.velocity_m_s, self.rotation)
        return all(one is None or bool(np.isfinite(one).all()) for one in values)


class ArmState(StrEnum):
    """What the virtual arm is doing."""

    IDLE = "idle"  # no goal: it stands, and gives way
    REACHING = "reaching"
    PLANNING = "planning"  # it stands, and looks for a way round
    WAITING = "waiting"  # a way there is not open now: it is looked for again and again
    UNREACHABLE = "unreachable"  # no posture has the hand there without contact
    ARRIVED = "arrived"


@dataclass(frozen=True, slots=True, eq=False)
class TipMotion:
    """One hand of the virtual arm, base frame."""

    rotation: Matrix  # (3, 3)
    position_m: Vector  # (3,)
    velocity_m_s: Vector  # (3,)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArmOutput:
    """One step."""

    q_rad: Vector  # (n,), read-only
    dq_rad_s: Vector  # (n,), read-only
    tips: tuple[TipMotion, ...]
    state: ArmState
    reason: str  # why the goal is not gone to, or not all of it is had; empty else
    clearance_m: float  # to the nearest surface that is looked at; infinity if none is near
    nearest: tuple[str, str]  # what is near what; empty texts if nothing is
    nearest_obstacle: int  # index into the world, -1 for a part of the body or nothing
    margin_m: float  # that is kept from obstacles now
    position_error_m: float  # of the worst hand
    orientation_error_rad: float
    way_to_go_rad: float  # along a planned path; 0 without one
    iterations: int  # of goal search and planner in this step
    nodes: int  # of the planner's trees
    held: bool  # the program had no answer: the last safe speed, braked, was kept
    yielding: bool  # surfaces come nearer than can be helped at these speeds
