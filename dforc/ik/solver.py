"""What every solver of the problem offers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from dforc.arrays import Vector
from dforc.ik.problem import IkProblem, TipTarget


@dataclass(frozen=True, slots=True, eq=False)
class SearchBounds:
    """lower <= C q <= upper of one search (C of the problem's limits): the joints first.

    Already cut down to the step of this search and to where blocked joints are; rows a hair inside.
    """

    lower: Vector  # (n + m,)
    upper: Vector


@dataclass(frozen=True, slots=True, eq=False)
class RawAnswer:
    """Where a search ended, not yet checked."""

    q: Vector  # (n,)
    iterations: int
    solved: bool  # the optimality conditions hold: of the problem, or of the nearest posture


class Solver(Protocol):
    """One way to solve the problem. It may keep what it built, but no answers."""

    def solve(
        self,
        problem: IkProblem,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        bounds: SearchBounds,
        proximal: float,
        budget: int,
    ) -> RawAnswer:
        """From one posture to one answer.

        Args:
            problem: what is asked for.
            targets: one per tip; None for a tip that is not asked for.
            q_start: posture inside the bounds (n,).
            bounds: what the answer keeps.
            proximal: cost of |q - q_start|^2, which keeps the answers of a stream together; 0 for
                a search.
            budget: iterations at most.
        """
        ...
