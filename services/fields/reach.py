"""The ball that a hand cannot leave, whatever its joints do: a goal outside needs no search."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.ik.problem import Tip


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """At most: limits of joints and the robot's own body are not looked at."""

    centre_m: Vector  # (3,) base frame
    radius_m: float

    @classmethod
    def of(cls, tip: Tip) -> "Reach":
        """About the first joint, by all links in one line: joints only turn."""
        first, *links = tip.model.chain_description()
        last = (links or [first])[-1]
        lengths = [float(np.linalg.norm(link.p)) for link in links[:-1]]
        lengths.append(float(np.linalg.norm(last.p + last.R @ tip.offset_m)))
        return cls(first.p, sum(lengths))

    def beyond_m(self, position_m: Sequence[float] | Vector) -> float:
        """How far a place is outside; negative inside."""
        return math.dist(position_m, self.centre_m) - self.radius_m
