"""What the pursuit of a goal looks at in one step."""

from typing import NamedTuple

from dforc.arrays import Vector
from dforc.collision.obstacles import World
from dforc.virtual_arm.goals import TipGoal

Goals = tuple[TipGoal | None, ...]


class Situation(NamedTuple):
    """Of one step."""

    goals: Goals
    q: Vector  # (n,)
    world: World
    others_q: Vector  # (N,)
    left_m: float  # between the arm and the margins around it, at least
