"""What the compiled and the plain path have in common."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from dforc.arrays import Matrix, Vector
from dforc.estimation.plan import Plan

# q, dq, ddq (n,), wrenches (m, 6), results -> status
Run = Callable[[Vector, Vector, Vector, Matrix, Vector], int]

DONE, NOT_FINITE, WRONG_SHAPE = 0, 1, 2


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """A plan that is ready to run."""

    plan: Plan
    run: Run
    size: int  # of the vector of results
    moving: bool  # needs the motion of a source
    motion: Vector  # (9,), of the kinematic source, read by `run`: omega, domega, acceleration


class Path(Protocol):
    """Runs plans on one model."""

    def prepare(self, plan: Plan) -> Prepared:
        """Work out what does not change from tick to tick."""
        ...

    def place(self, q_rad: Vector, out: Vector) -> None:
        """Poses of all bodies, flat."""
        ...
