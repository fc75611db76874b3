"""Inverse kinematics: a posture for a pose, checked before it is handed out.

A solver proposes; whether an answer is one is decided here, with the model's own kinematics. What
comes back is finite, keeps limits, rows and step, and is one of three: the answer, the nearest
posture to a pose that is out of reach, or, out of time, the posture where the search began.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from dforc.arrays import ArrayLike, Vector, constant, finite_vector
from dforc.compiled import HAS_COMPILER
from dforc.errors import NotFiniteError, ShapeError
from dforc.ik.problem import POSITION_WEIGHT, IkProblem, Priority, TipTarget
from dforc.ik.solver import RawAnswer, SearchBounds, Solver
from dforc.ik.sqp import Sqp
from dforc.ik.starts import starts_of
from dforc.rotation import angle_between

SEARCH_BUDGET = 400  # iterations of one search: 2 ms
MOST_IN_ONE = 100  # of these from one start, while others are left; 1 search in 300 takes more
TRACK_BUDGET = 150
TRACK_STEP_RAD = math.radians(4.0)  # of a joint, per tick of 10 ms
# Where a tick's search does not come to an end, one in this part of the room does; with all of it
# the next tick would begin at the same posture and stop at the same place, for ever.
TRACK_TRIES, LESS_ROOM, FIRST_SHARE = 3, 0.25, 0.67
PROXIMAL = 0.01  # rad^2 of cost per rad^2 of joint motion in a tick: no jump to another posture
ROW_MARGIN_RAD = 1e-7  # rows are kept this far inside, so that rounding never crosses one
KEPT = 1e-6  # by which an answer may miss rows and extra constraints, and not more
ROUNDING = 1e-3  # share of a tolerance
AT_BOUND_RAD = 1e-9
FAR_RAD = 0.5  # from the rest posture, on average: what costs more is worth other starts


class IkStatus(StrEnum):
    """What an answer is worth."""

    CONVERGED = "converged"
    INFEASIBLE = "infeasible"  # out of reach: q is the nearest posture found
    OUT_OF_TIME = "out_of_time"  # the budget is used up: q is where the search began


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IkResult:
    """One answer. `q_rad` is finite and keeps limits, rows and step whatever the status."""

    q_rad: Vector  # (n,), read-only
    status: IkStatus
    position_error_m: float  # of the worst tip; 0 where no position was asked for
    orientation_error_rad: float
    tip_errors: tuple[tuple[float, float] | None, ...]  # m and rad of each tip; None: not asked for
    objective: float  # of eq. 11: what was not a condition, and the posture's cost
    iterations: int
    step_limited: bool  # the joint step of this search stood in the way: ask again from here
    reason: str  # why it is no more than it is; empty for an answer that lacks nothing


class InverseKinematics:
    """One problem at a time, and a solver for it. It remembers no answers."""

    def __init__(self, problem: IkProblem, solver: Solver | None = None) -> None:
        """Take the problem, and the solver that is to be used (the fastest by default)."""
        self._solver: Solver = solver or fastest_solver()
        self.change(problem)

    @property
    def problem(self) -> IkProblem:
        """What is being solved."""
        return self._problem

    def change(self, problem: IkProblem) -> None:
        """Solve another problem from the next answer on."""
        self._problem = problem
        limits = problem.limits
        margin = np.minimum(ROW_MARGIN_RAD, 0.25 * (limits.upper - limits.lower))
        margin[: limits.n] = 0.0
        self._lower = constant(limits.lower + margin)
        self._upper = constant(limits.upper - margin)
        self._is_free = bool(problem.free.all())

    def solve(
        self,
        targets: Sequence[TipTarget | None],
        q_start_rad: ArrayLike,
        *,
        step_limit_rad: float | ArrayLike = math.inf,
        budget: int = SEARCH_BUDGET,
        starts: int = 3,
    ) -> IkResult:
        """Search for a posture.

        Args:
            targets: one per tip, None for a tip that is not asked for.
            q_start_rad: where the search begins and blocked joints stay (n,). It is brought inside
                the limits if it is outside.
            step_limit_rad: largest change of each joint against it (scalar or (n,)).
            budget: iterations at most.
            starts: postures to begin from, at most. The others are tried where the first answer
                costs much or is none, and the best one counts.

        Raises:
            NotFiniteError, ShapeError: what is no pose or no posture.
        """
        asked, q_start, bounds = self._request(targets, q_start_rad, step_limit_rad)
        best, used = None, 0
        for tried, begin in enumerate(starts_of(self._problem, q_start, bounds)):
            if tried == max(1, starts) or (best is not None and used >= budget):
                break
            left = budget - used
            allowed = left if tried == starts - 1 else min(left, max(MOST_IN_ONE, left // 2))
            raw = self._solver.solve(self._problem, asked, begin, bounds, 0.0, allowed)
            used += raw.iterations
            found = self._checked(asked, q_start, bounds, raw)
            best = found if best is None else _better(best, found, self._problem)
            if self._is_good(best):
                break
        assert best is not None  # the first start is always there
        return best if best.iterations == used else replace(best, iterations=used)

    def track(
        self,
        targets: Sequence[TipTarget | None],
        q_before_rad: ArrayLike,
        *,
        step_limit_rad: float | ArrayLike = TRACK_STEP_RAD,
        budget: int = TRACK_BUDGET,
        proximal: float = PROXIMAL,
    ) -> IkResult:
        """The next posture of a stream: near the one before, whatever the target does.

        Args and errors as of `solve`; `q_before_rad` is the answer before. Every answer draws
        nearer to the best posture: for a pose that stands still the answers converge to it.
        """
        asked, q_before, bounds = self._request(targets, q_before_rad, step_limit_rad)
        used = 0
        for left_tries in reversed(range(TRACK_TRIES)):
            left = budget - used
            allowed = math.ceil(FIRST_SHARE * left) if left_tries else left
            raw = self._solver.solve(self._problem, asked, q_before, bounds, proximal, allowed)
            used += raw.iterations
            raw = RawAnswer(raw.q, used, raw.solved)
            found = self._checked(asked, q_before, bounds, raw)
            if found.status is not IkStatus.OUT_OF_TIME or used >= budget:
                break
            bounds = self._nearer(bounds, q_before)
        return found

    def _nearer(self, bounds: SearchBounds, q: Vector) -> SearchBounds:
        """Bounds with less room for the joints around a posture."""
        n, lower, upper = self._problem.n, bounds.lower.copy(), bounds.upper.copy()
        lower[:n] = q - LESS_ROOM * (q - lower[:n])
        upper[:n] = q + LESS_ROOM * (upper[:n] - q)
        return SearchBounds(lower, upper)

    def _request(
        self,
        targets: Sequence[TipTarget | None],
        q_start_rad: ArrayLike,
        step_limit_rad: float | ArrayLike,
    ) -> tuple[list[TipTarget | None], Vector, SearchBounds]:
        problem = self._problem
        n = problem.n
        if len(targets) != len(problem.tips):
            raise ShapeError(f"{len(targets)} targets for {len(problem.tips)} tips")
        asked = [
            None if t is None else TipTarget.checked(t.position_m, t.rotation) for t in targets
        ]
        q_start = finite_vector("start posture", q_start_rad, n)
        step: float | Vector
        if isinstance(step_limit_rad, float):
            step = step_limit_rad
            wrong = not step >= 0.0  # also catches NaN
        else:
            step = np.asarray(step_limit_rad, dtype=np.float64)
            if step.shape not in ((), (n,)):
                raise ShapeError(f"joint steps have shape {step.shape}, expected ({n},)")
            wrong = not (step >= 0.0).all()
        if wrong:
            raise NotFiniteError(f"joint step must be >= 0, not {step_limit_rad}")
        if problem.limits.violation(q_start) > 0.0:
            q_start = problem.limits.project(q_start)
        if not self._is_free:
            step = np.where(problem.free, step, 0.0)
        lower, upper = self._lower.copy(), self._upper.copy()
        np.maximum(lower[:n], q_start - step, out=lower[:n])
        np.minimum(upper[:n], q_start + step, out=upper[:n])
        return asked, q_start, SearchBounds(lower, upper)

    def _checked(
        self,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        bounds: SearchBounds,
        raw: RawAnswer,
    ) -> IkResult:
        """The answer as the caller may use it, with its true errors."""
        q, why = self._kept(bounds, raw)
        solved = not why
        if not solved:
            q = q_start.copy()
        errors, position_m, angle_rad, objective = self._errors(targets, q)
        limited = self._is_confined(q, bounds)
        status = IkStatus.CONVERGED if solved else IkStatus.OUT_OF_TIME
        if solved:
            why = self._shortfall(position_m, angle_rad)
            if why:
                status = IkStatus.INFEASIBLE
                why += " within this step" if limited else ""
        return IkResult(
            q_rad=constant(q),
            status=status,
            position_error_m=position_m,
            orientation_error_rad=angle_rad,
            tip_errors=errors,
            objective=objective,
            iterations=raw.iterations,
            step_limited=limited,
            reason=why,
        )

    def _kept(self, bounds: SearchBounds, raw: RawAnswer) -> tuple[Vector, str]:
        """The solver's answer inside the bounds, and why it is none (empty if it is one)."""
        problem, n = self._problem, self._problem.n
        if not raw.solved:
            return raw.q, f"no answer within {raw.iterations} iterations"
        if not math.isfinite(raw.q.dot(raw.q)):
            return raw.q, "the solver's answer is not finite"
        q: Vector = np.minimum(np.maximum(raw.q, bounds.lower[:n]), bounds.upper[:n])
        outside = problem.limits.violation(q)
        if problem.extra is not None:
            outside = max(outside, -float(problem.extra.evaluate(q)[0].min(initial=np.inf)))
        if outside > KEPT:
            return q, f"the solver's answer is {outside:.1e} outside a limit"
        return q, ""

    def _shortfall(self, position_m: float, angle_rad: float) -> str:
        """By how much the condition is missed, in words; empty if it is kept."""
        problem = self._problem
        if problem.priority is Priority.POSITION:
            if position_m > problem.position_tolerance_m * (1.0 + ROUNDING):
                return f"nearest position is {position_m:.2g} m away"
        elif angle_rad > problem.orientation_tolerance_rad * (1.0 + ROUNDING):
            return f"nearest orientation is {math.degrees(angle_rad):.2g} deg away"
        return ""

    def _errors(
        self, targets: Sequence[TipTarget | None], q: Vector
    ) -> tuple[tuple[tuple[float, float] | None, ...], float, float, float]:
        """Of each tip, the worst position, the worst orientation; and the objective."""
        problem = self._problem
        errors: list[tuple[float, float] | None] = []
        worst_m, worst_rad = 0.0, 0.0
        away = q - problem.rest_rad
        objective = problem.beta * float((problem.rest_weights * away) @ away)
        for tip, target in zip(problem.tips, targets, strict=True):
            if target is None:
                errors.append(None)
                continue
            R, p = tip.pose(q)
            off_m = off_rad = 0.0
            if target.position_m is not None:
                x = p - target.position_m
                off_m = math.sqrt(float(x @ x))
            if target.rotation is not None:
                off_rad = angle_between(R, target.rotation)
            first = problem.priority is Priority.POSITION
            objective += off_rad * off_rad if first else POSITION_WEIGHT * off_m * off_m
            errors.append((off_m, off_rad))
            worst_m, worst_rad = max(worst_m, off_m), max(worst_rad, off_rad)
        return tuple(errors), worst_m, worst_rad, objective

    def _is_confined(self, q: Vector, bounds: SearchBounds) -> bool:
        """Whether a free joint ended where this search's step ends, inside its own limits."""
        limits, n = self._problem.limits, self._problem.n
        below = q - bounds.lower[:n] < AT_BOUND_RAD
        above = bounds.upper[:n] - q < AT_BOUND_RAD
        if not (below.any() or above.any()):
            return False
        below &= bounds.lower[:n] > limits.lower_rad + AT_BOUND_RAD
        above &= bounds.upper[:n] < limits.upper_rad - AT_BOUND_RAD
        return bool(((below | above) & self._problem.free).any())

    def _is_good(self, result: IkResult) -> bool:
        """Whether other starts are not worth their time."""
        if result.status is not IkStatus.CONVERGED:
            return False
        problem = self._problem
        weights = float(problem.rest_weights @ problem.free)
        return result.objective < problem.beta * weights * FAR_RAD * FAR_RAD


def fastest_solver() -> Solver:
    """The compiled search; without a compiler, where it takes 10 ms a tick, CasADi's fatrop."""
    if HAS_COMPILER:
        return Sqp()
    from dforc.ik.interior import FatropSolver  # CasADi takes 0.2 s to load, and is not needed else

    return FatropSolver()


def _better(a: IkResult, b: IkResult, problem: IkProblem) -> IkResult:
    """The one that is more of an answer."""
    order = (IkStatus.CONVERGED, IkStatus.INFEASIBLE, IkStatus.OUT_OF_TIME)
    if a.status is not b.status:
        return min(a, b, key=lambda one: order.index(one.status))
    if a.status is IkStatus.INFEASIBLE:
        first = problem.priority is Priority.POSITION

        def missed(one: IkResult) -> float:
            return one.position_error_m if first else one.orientation_error_rad

        if abs(missed(a) - missed(b)) > AT_BOUND_RAD:
            return min(a, b, key=missed)
    return min(a, b, key=lambda one: one.objective)
