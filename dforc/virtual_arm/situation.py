"""What the pursuit of a goal looks at in one step, and when goals count as others."""

from typing import NamedTuple

import numpy as np

from dforc.arrays import Vector
from dforc.collision.obstacles import World
from dforc.rotation import angle_between
from dforc.virtual_arm.goals import TipGoal

Goals = tuple[TipGoal | None, ...]


class Situation(NamedTuple):
    """Of one step."""

    goals: Goals
    q: Vector  # (n,)
    world: World
    others_q: Vector  # (N,)


def is_beyond(before: Goals, now: Goals, far_m: float, far_rad: float) -> bool:
    """Whether goals differ by more than that, or in kind."""
    for a, b in zip(before, now, strict=True):
        if a is None or b is None:
            if a is not b:
                return True
            continue
        if float(np.linalg.norm(a.position_m - b.position_m)) > far_m:
            return True
        if a.rotation is None or b.rotation is None:
            if a.rotation is not b.rotation:
                return True
        elif angle_between(a.rotation, b.rotation) > far_rad:
            return True
    return False
