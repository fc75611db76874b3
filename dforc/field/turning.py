"""How a hand turns while a force field moves its point: at a bounded rate, the way its arm can.

The paper leaves orientation to the inverse kinematics. Which of the two ways round a hand has to
turn for half a turn or so is a matter of the joints' limits: an arm that is sent the shorter way
can end at a limit with the orientation missed by more than a right angle. So for a large turn a
posture that has the hands at their goals is looked for, and they turn as they would on the straight
way to it in joint space.
"""

import math
from collections.abc import Sequence

import numpy as np

from dforc.arrays import Matrix, Vector, constant, finite_vector
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.poses import is_beyond
from dforc.rotation import angle_between, matrix, rotation_error

TURN_RAD_S = 1.5
LARGE_RAD = math.radians(100.0)  # the shorter way is hardly ever wrong below
WITHIN_RAD = math.radians(1.0)  # of the goals' orientations, for a posture to lead
AHEAD_RAD = math.radians(20.0)  # of the hand, that the posture goes
SHARES = 200  # steps of the way in joint space
OTHER_M, OTHER_RAD = 0.10, math.radians(45.0)  # a goal that has moved more is another one

Goals = Sequence[TipTarget | None]  # one per hand, each with a position


class Turning:
    """Of all hands of a limb."""

    def __init__(self, problem: IkProblem, rate_rad_s: float = TURN_RAD_S) -> None:
        """The limb is at its rest posture."""
        self._inverse = InverseKinematics(problem)
        self._rate_rad_s = rate_rad_s
        self.begin(problem.limits.project(problem.rest_rad))

    def begin(self, q_rad: Vector) -> None:
        """The limb is at a posture (n,); there are no goals.

        Raises:
            NotFiniteError, ShapeError: it is none.
        """
        q = finite_vector("posture", q_rad, self._inverse.problem.n)
        self._from: Vector = q
        self._to: Vector | None = None
        self._share = 0
        self._goals: tuple[TipTarget | None, ...] = ()

    def step(
        self,
        turned: Sequence[Matrix],
        places_m: Sequence[Vector],
        goals: Goals,
        dt_s: float,
    ) -> list[Matrix]:
        """The hands' orientations (3, 3) one period later, base frame.

        Args:
            turned: what they are.
            places_m: where the hands' points are, each (3,).
            goals: where the hands are to go; None, or without an orientation: it stays.
            dt_s: period.
        """
        if is_beyond(self._goals, goals, OTHER_M, OTHER_RAD):
            self._take(turned, places_m, goals)
        towards = self._led(turned, goals)
        return [
            R if goal is None else _turned(R, goal, self._rate_rad_s * dt_s)
            for R, goal in zip(turned, towards, strict=True)
        ]

    def _take(self, turned: Sequence[Matrix], places_m: Sequence[Vector], goals: Goals) -> None:
        """Other goals: look for a posture if one of the turns is large."""
        have_moved = bool(self._goals)
        self._from, self._to, self._share = self._posture(), None, 0
        self._goals = tuple(goals)
        largest = max(
            (
                angle_between(R, goal.rotation)
                for R, goal in zip(turned, goals, strict=True)
                if goal is not None and goal.rotation is not None
            ),
            default=0.0,
        )
        if largest < LARGE_RAD:
            return
        if have_moved:  # the posture that leads has to begin where the hands are
            here = [TipTarget(p, R) for p, R in zip(places_m, turned, strict=True)]
            self._from = self._inverse.solve(here, self._from, starts=1).q_rad
        found = self._inverse.solve(list(goals), self._from)
        if found.status is IkStatus.CONVERGED and found.orientation_error_rad <= WITHIN_RAD:
            self._to = found.q_rad

    def _posture(self) -> Vector:
        if self._to is None:
            return self._from
        return constant(self._from + self._share / SHARES * (self._to - self._from))

    def _led(self, turned: Sequence[Matrix], goals: Goals) -> list[Matrix | None]:
        """Where the hands turn to now."""
        ends = [None if goal is None else goal.rotation for goal in goals]
        if self._to is None:
            return ends
        tips = self._inverse.problem.tips
        while self._share < SHARES:
            now = [tip.pose(self._posture())[0] for tip in tips]
            if any(
                end is not None and angle_between(R, lead) > AHEAD_RAD
                for R, lead, end in zip(turned, now, ends, strict=True)
            ):
                return [None if end is None else lead for lead, end in zip(now, ends, strict=True)]
            self._share += 1
        return ends


def _turned(turned: Matrix, goal: Matrix, most_rad: float) -> Matrix:
    """An orientation turned to another on the shortest way, by at most `most_rad`."""
    left = rotation_error(turned, goal)
    angle_rad = float(np.linalg.norm(left))
    if angle_rad <= most_rad:
        return goal
    return matrix(left * (most_rad / angle_rad)) @ turned
