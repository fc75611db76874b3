"""Follows a stream of virtual points: one posture for each, near the one before.

A point that carries a posture is answered by it where it checks out; else by a search that rests
there.
"""

import math

import numpy as np

from dforc.arrays import Vector
from dforc.errors import DforcError
from dforc.ik.inverse_kinematics import (
    PROXIMAL,
    TRACK_BUDGET,
    TRACK_STEP_RAD,
    IkResult,
    InverseKinematics,
)
from services.core.errors import ConfigError
from services.messages import IkSolution, VirtualPoint
from services.reaching.given_posture import answer_given, posture_of
from services.reaching.ik_limb import DEFAULT_SOLVER, IkLimb
from services.reaching.ik_statistics import SearchCount
from services.reaching.ik_targets import Targets, point_targets

FORGET_AFTER_NS = 500_000_000  # without points, the next one starts from the measured posture again
PERIOD_NS = 10_000_000  # of the points
MOST_PERIODS = 10.0
DRIFTED_RAD = math.radians(1.0)  # of a blocked joint that something else has moved


class Follower:
    """Of one limb at a time."""

    def __init__(self, limb: IkLimb) -> None:
        self.limb = limb
        self.counts = SearchCount()
        self.status = ""  # of the newest answer
        self.reason = ""
        self._solver = limb.setup.solver
        self._inverse = InverseKinematics(limb.problem, limb.solver(self._solver, "stream"))
        self._answer: Vector | None = None
        self._answered_ns = 0

    @property
    def solver(self) -> str:
        """Name of the solver that answers."""
        return self._solver or DEFAULT_SOLVER

    def is_following(self, now_ns: int) -> bool:
        """Whether points have come in the last moments."""
        return self._answer is not None and now_ns - self._answered_ns <= FORGET_AFTER_NS

    def use(self, limb: IkLimb) -> None:
        """Follow with another limb, from where it is."""
        if limb is not self.limb:
            self.limb = limb
            self._answer = None

    def answer(
        self, now_ns: int, point: VirtualPoint, measured: Vector | None
    ) -> IkSolution | None:
        """A posture for a point; None while the limb's own is not known.

        Raises:
            ConfigError: the point is none.
        """
        periods = self._periods(now_ns)
        if not self.is_following(now_ns):
            self._answer = measured
        before = self._answer
        if before is None:
            return None
        limb = self.limb
        self._take_setup(limb)
        budget = limb.setup.iterations or TRACK_BUDGET
        if measured is not None and not limb.problem.free.all():
            drifted = ~limb.problem.free & (np.abs(measured - before) > DRIFTED_RAD)
            before = np.where(drifted, measured, before)
        targets = point_targets(point, limb.tips)
        given = posture_of(point, limb.problem.n)
        result = None
        if given is not None:
            limit_rad = periods * TRACK_STEP_RAD
            result = answer_given(limb.problem, targets, given, before, limit_rad)
        if result is None:
            result = self._searched(targets, before, given, periods, budget)
        self._answer = result.q_rad
        self._answered_ns = now_ns
        self.counts.note(result, budget)
        self.status, self.reason = str(result.status), result.reason
        return IkSolution(
            stamp_ns=now_ns,
            sequence=point.sequence,
            q_rad=tuple(result.q_rad.tolist()),
            status=self.status,
            position_error_m=result.position_error_m,
            orientation_error_rad=result.orientation_error_rad,
            iterations=result.iterations,
            limb=limb.name,
            reason=result.reason,
            tip_errors=result.tip_errors,
            limited=result.step_limited,
            missed=self.counts.missed,
        )

    def _searched(
        self, targets: Targets, before: Vector, rest: Vector | None, periods: float, budget: int
    ) -> IkResult:
        """The nearest posture, resting at `rest` if one is given.

        Raises:
            ConfigError: the targets are none.
        """
        problem = self.limb.problem
        try:
            if rest is not None:
                self._inverse.change(problem.changed(rest_rad=rest))
            return self._inverse.track(
                targets,
                before,
                step_limit_rad=periods * TRACK_STEP_RAD,
                budget=budget,
                proximal=PROXIMAL / periods,
            )
        except DforcError as error:
            raise ConfigError(str(error)) from error
        finally:
            self._inverse.change(problem)

    def _periods(self, now_ns: int) -> float:
        """Since the answer before: what a posture may move in one period it may in each of them.

        A process that is kept waiting would else fall behind the point for good, and hand and
        point part: what lies between them is no longer avoided.
        """
        if not self.is_following(now_ns):
            return 1.0
        return min(max(1.0, (now_ns - self._answered_ns) / PERIOD_NS), MOST_PERIODS)

    def _take_setup(self, limb: IkLimb) -> None:
        """Solve the problem of the set-up in use, with its solver."""
        if limb.problem is not self._inverse.problem or limb.setup.solver != self._solver:
            self._solver = limb.setup.solver
            self._inverse = InverseKinematics(limb.problem, limb.solver(self._solver, "stream"))
