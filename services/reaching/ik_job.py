"""One request to the IK service: checked at once, then solved pose by pose."""

import math

import numpy as np

from dforc.arrays import Vector, finite_vector
from dforc.errors import DforcError
from dforc.ik.inverse_kinematics import SEARCH_BUDGET, IkResult, IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem
from services.core.errors import ConfigError
from services.messages import Floats
from services.reaching.ik_limb import DEFAULT_SOLVER, ITERATIONS_PER_MS, IkLimb
from services.reaching.ik_statistics import SearchCount
from services.reaching.ik_targets import Targets, pose_targets
from services.reaching.messages import IkAnswer, IkReply, IkRequest

MOST_POSES = 5000
FARTHEST_RAD = 100.0  # no joint turns so far
CALL_MS = 0.2  # of one search beside its iterations
TURNED_RAD = math.radians(2.0)  # less than this off counts as the orientation that was asked for
PLACED_M = 1e-3


class IkJob:
    """The poses of one request, solved one after the other."""

    def __init__(
        self,
        limb: IkLimb,
        request: IkRequest,
        measured: Vector | None,
        counts: SearchCount,
        begun_ns: int = 0,
    ) -> None:
        """Check everything.

        Raises:
            ConfigError: no such request can be answered; the text says what is wrong with it.
        """
        self.begun_ns = begun_ns
        self._limb = limb
        self._request = request
        self._counts = counts
        setup = limb.setup if request.setup is None else request.setup
        self._problem = limb.problem if request.setup is None else limb.problem_of(setup)
        self._solver = limb.solver(setup.solver, "requests")
        self._inverse = InverseKinematics(self._problem, self._solver)
        self._rate = ITERATIONS_PER_MS[setup.solver or DEFAULT_SOLVER]
        self._budget = _budget(request.deadline_ms, self._rate, setup.iterations or SEARCH_BUDGET)
        self._targets = _targets(request, limb.tips)
        self._start = _start(request.start_rad, self._problem, measured)
        self._from = self._start
        self._answers: list[IkAnswer] = []

    @property
    def waiting(self) -> int:
        """Poses that are still to be solved."""
        return len(self._targets) - len(self._answers)

    def advance(self) -> float:
        """Solve the next pose; what that took, in ms by its iterations.

        Raises:
            DforcError: numbers beyond all reckoning, which no check has found.
        """
        targets = self._targets[len(self._answers)]
        begin = self._from if self._request.warm else self._start
        result = self._inverse.solve(targets, begin, budget=self._budget)
        self._counts.note(result, self._budget)
        reason, more = self._reason(targets, begin, result)
        if result.status is not IkStatus.OUT_OF_TIME:
            self._from = result.q_rad
        self._answers.append(
            IkAnswer(
                q_rad=tuple(result.q_rad.tolist()),
                status=str(result.status),
                position_error_m=result.position_error_m,
                orientation_error_rad=result.orientation_error_rad,
                distance_rad=float(np.abs(result.q_rad - begin).max()),
                iterations=result.iterations,
                reason=reason,
                tip_errors=result.tip_errors,
                limited=result.step_limited,
            )
        )
        return CALL_MS + (result.iterations + more) / self._rate

    def reply(self, now_ns: int) -> IkReply:
        """The answers so far; the reply is ok where there is one for each pose."""
        solved, asked = len(self._answers), len(self._targets)
        return IkReply(
            ok=solved == asked,
            reason="" if solved == asked else f"time for {solved} of {asked} poses only",
            joints=self._limb.joints,
            answers=tuple(self._answers),
            start_rad=tuple(self._start.tolist()),
            taken_ms=(now_ns - self.begun_ns) * 1e-6,
            statistics=self._counts.report(),
        )

    def _reason(self, targets: Targets, begin: Vector, result: IkResult) -> tuple[str, int]:
        """Why a pose is not reached and what would help; and the iterations to find that out."""
        if is_reached(result):
            return result.reason, 0
        reason = result.reason
        if not reason:
            reason = f"orientation is {math.degrees(result.orientation_error_rad):.1f} deg off"
        blocked = [name for name, is_free in self._named() if not is_free]
        if not blocked or not self._request.suggest:
            return reason, 0
        freed = self._problem.changed(free=np.ones(self._problem.n, dtype=np.bool_))
        other = InverseKinematics(freed, self._solver).solve(targets, begin, budget=self._budget)
        if not is_reached(other):
            return f"{reason}; not reachable with all joints either", other.iterations
        helpers = "the waist" if self._limb.waist >= set(blocked) else ", ".join(blocked)
        return f"{reason}; reachable with {helpers}", other.iterations

    def _named(self) -> list[tuple[str, bool]]:
        return list(zip(self._limb.joints, self._problem.free.tolist(), strict=True))


def is_reached(result: IkResult) -> bool:
    """Whether the whole pose is, not only what was the condition."""
    return (
        result.status is IkStatus.CONVERGED
        and result.position_error_m <= PLACED_M
        and result.orientation_error_rad <= TURNED_RAD
    )


def _budget(deadline_ms: float, rate: float, most: int) -> int:
    """Iterations of one search."""
    if deadline_ms == 0.0:
        return most
    if not 0.0 < deadline_ms < math.inf:
        raise ConfigError(f"a deadline of {deadline_ms} ms")
    return max(1, min(most, int(deadline_ms * rate)))


def _targets(request: IkRequest, tips: int) -> list[Targets]:
    if not 0 < len(request.poses) <= MOST_POSES:
        raise ConfigError(f"{len(request.poses)} poses; between 1 and {MOST_POSES} are answered")
    targets = []
    for i, pose in enumerate(request.poses):
        try:
            targets.append(pose_targets(pose, tips))
        except ConfigError as error:
            raise ConfigError(f"pose {i}: {error}") from error
    return targets


def _start(start_rad: Floats, problem: IkProblem, measured: Vector | None) -> Vector:
    """The posture inside all limits that the first search begins at."""
    given = start_rad or measured
    if given is None:
        raise ConfigError("the measured posture is not known; give one to start from")
    try:
        start = finite_vector("start", given, problem.n)
        if np.abs(start).max() > FARTHEST_RAD:
            raise ConfigError(f"start: a joint at more than {FARTHEST_RAD:g} rad")
        return problem.limits.project(start) if problem.limits.violation(start) > 0.0 else start
    except DforcError as error:
        raise ConfigError(str(error)) from error
