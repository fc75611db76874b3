"""Eq. 11 by the interior-point solvers that come with CasADi: IPOPT, as in the papers, and fatrop.

Slower than dforc.ik.sqp (ms instead of tens of us), and independent of it: a reference, and a
choice where no compiler is wanted. The program (dforc.symbolic.program) is built once per geometry,
0.05 s; every request is then numbers. Each search first has a slack in the conditions, so that it
ends whether the pose is in reach or not; where it ends close to the pose, one to three short
searches more take the slack away.
"""

import math
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from dforc.arrays import Vector
from dforc.errors import DforcError
from dforc.ik.problem import (
    POSITION_WEIGHT,
    ExtraConstraints,
    IkProblem,
    Priority,
    Tip,
    TipTarget,
)
from dforc.ik.solver import RawAnswer, SearchBounds
from dforc.kinematics import ChainKinematics
from dforc.robot_model import ChainElement
from dforc.symbolic.nonlinear import Ending, Method, NonlinearSolver, Prepared, Region, Start
from dforc.symbolic.program import (
    Structure,
    SymbolicConstraints,
    TipParameters,
    reaching_program,
)

# Of the slack, 1/m^2 and 1/rad^2: a position ends within 0.1 mm of the smallest distance.
SOFT = {Priority.POSITION: 1e4, Priority.ORIENTATION: 1e3}
INSIDE_SHARE = 0.95  # of the tolerance: what the slack is left with in most searches
CLOSE = 0.02  # m, rad of slack that may still go away
ROUNDS = 3  # of taking it away
HALVED = 0.5  # what a round must do to the error to be worth another
ENDLESS_RAD = 1e3  # stands for a bound that is not there
ROOM_RAD = 1e-7  # that a row leaves around the start
CAPS = (100, 50, 25, 12)  # iterations of one run: a solver is built for each
KEPT = 8  # programs
MODELS = 32  # whose geometry is kept


class NotSymbolicError(DforcError, TypeError):
    """Extra constraints that cannot be written out: these solvers need their expression."""


@dataclass(frozen=True, slots=True, eq=False)
class _Chain:
    """Geometry of a model, and the model, so that its identity is not given to another."""

    model: ChainKinematics
    elements: tuple[ChainElement, ...]
    key: bytes


@dataclass(frozen=True, slots=True, eq=False)
class _Built:
    """A program and its solvers so far, and what they were built for."""

    structure: Structure
    prepared: Prepared
    solvers: dict[tuple[int, Start], NonlinearSolver] = field(default_factory=dict)


class InteriorSolver:
    """One of the two methods. It keeps the programs it built, and no answers."""

    def __init__(self, method: Method) -> None:
        self._method = method
        self._kept: OrderedDict[tuple[object, ...], _Built] = OrderedDict()
        self._chain_of: dict[int, _Chain] = {}

    def solve(
        self,
        problem: IkProblem,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        bounds: SearchBounds,
        proximal: float,
        budget: int,
    ) -> RawAnswer:
        """As dforc.ik.solver.Solver says.

        Raises:
            NotSymbolicError: the problem's extra constraints have no `symbolic`.
        """
        built, n = self._build(problem), problem.n
        region = _region(problem, len(targets), q_start, bounds)
        tips = [_tip(problem, *pair) for pair in zip(problem.tips, targets, strict=True)]
        rows = problem.limits.rows[built.structure.row_pattern]
        soft = SOFT[problem.priority]
        shared = np.concatenate([*_posture(problem, q_start, proximal), [soft], rows])
        start = Start.ANYWHERE if proximal == 0.0 else Start.NEAR
        best = Ending(np.concatenate([q_start, np.zeros(6 * len(tips))]), False, 0)
        used, error = 0, math.inf
        for _ in range(1 + ROUNDS):
            solver = self._solver(built, budget - used, start)
            if solver is None:  # what is left of the budget is no search
                break
            parameters = np.concatenate([*(tip.values() for tip in tips), shared])
            ending = solver.run(best.z, parameters, region)
            used += ending.iterations
            if not (ending.solved and np.isfinite(ending.z).all()):
                break
            best = ending
            before, error = error, _error(tips, best.z[n:])
            slack = best.z[n:].reshape(-1, 6)[:, 3:]
            if error <= 1.0 or error > HALVED * before or np.abs(slack).max() > CLOSE:
                break
            tips = [
                replace(tip, pull=tip.pull + 2.0 * soft * left)
                for tip, left in zip(tips, slack, strict=True)
            ]
            start = Start.AT_AN_ANSWER
        q = np.clip(best.z[:n], bounds.lower[:n], bounds.upper[:n])
        return RawAnswer(q, used, best.solved)

    def _solver(self, built: _Built, budget: int, start: Start) -> NonlinearSolver | None:
        """The one with the largest cap that the budget allows."""
        cap = next((cap for cap in CAPS if cap <= budget), None)
        if cap is None:
            return None
        solver = built.solvers.get((cap, start))
        if solver is None:
            solver = NonlinearSolver(built.prepared, cap, start)
            built.solvers[cap, start] = solver
        return solver

    def _build(self, problem: IkProblem) -> _Built:
        chains = [self._chain(tip.model) for tip in problem.tips]
        pattern = problem.limits.rows != 0.0
        extra = _symbolic(problem.extra)
        key = (problem.n, *(c.key for c in chains), pattern.tobytes(), id(extra))
        built = self._kept.get(key)
        if built is None:
            elements = tuple(c.elements for c in chains)
            structure = Structure(problem.n, elements, pattern, extra)
            prepared = Prepared(reaching_program(structure), self._method)
            built = self._kept[key] = _Built(structure, prepared)
            if len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(key)
        return built

    def _chain(self, model: ChainKinematics) -> _Chain:
        found = self._chain_of.get(id(model))
        if found is None:
            elements = tuple(model.chain_description())
            parts = [part for e in elements for part in (e.R, e.p, e.axis, np.array([e.joint]))]
            key = b"".join(np.asarray(part, dtype=np.float64).tobytes() for part in parts)
            if len(self._chain_of) >= MODELS:
                self._chain_of.clear()
            found = self._chain_of[id(model)] = _Chain(model, elements, key)
        return found


class IpoptSolver(InteriorSolver):
    """IPOPT, with exact derivatives that are written out: the papers' solver."""

    def __init__(self) -> None:
        super().__init__(Method.IPOPT)


class FatropSolver(InteriorSolver):
    """fatrop, which does the same with less book-keeping: about half the time."""

    def __init__(self) -> None:
        super().__init__(Method.FATROP)


def _symbolic(extra: ExtraConstraints | None) -> SymbolicConstraints | None:
    if extra is None or isinstance(extra, SymbolicConstraints):
        return extra
    raise NotSymbolicError(f"{type(extra).__name__} has no `symbolic`: use dforc.ik.sqp with it")


def _tip(problem: IkProblem, tip: Tip, target: TipTarget | None) -> TipParameters:
    """What is asked of one tip. The tip frame's turn is put into the target's."""
    position = None if target is None else target.position_m
    rotation = None if target is None else target.rotation
    first = problem.priority is Priority.POSITION
    radius = problem.position_tolerance_m
    if not first:
        radius = 2.0 * math.sin(0.5 * min(problem.orientation_tolerance_rad, math.pi))
    met = (position if first else rotation) is not None
    has_position, has_rotation = float(position is not None), float(rotation is not None)
    return TipParameters(
        position_m=np.zeros(3) if position is None else position,
        rotation=np.eye(3) if rotation is None else rotation @ tip.offset_rotation.T,
        offset_m=tip.offset_m,
        cost_position=0.0 if first else POSITION_WEIGHT * has_position,
        cost_orientation=has_rotation if first else 0.0,
        condition_position=has_position if first else 0.0,
        condition_orientation=0.0 if first else has_rotation,
        radius=INSIDE_SHARE * radius if met else 1.0,
        pull=np.zeros(3),
    )


def _posture(problem: IkProblem, q_start: Vector, proximal: float) -> tuple[Vector, Vector]:
    """Centre and weights of the posture's cost, of rest and start in one."""
    rest = problem.beta * problem.rest_weights
    weights = rest + proximal
    centre = np.divide(
        rest * problem.rest_rad + proximal * q_start,
        weights,
        out=np.zeros(problem.n),
        where=weights > 0.0,
    )
    return centre, weights


def _region(problem: IkProblem, k: int, q_start: Vector, bounds: SearchBounds) -> Region:
    """The bounds, without what would leave these methods no room inside them.

    A row of blocked joints alone says nothing, and no row may shut out the start by rounding.
    """
    n, rows = problem.n, problem.limits.rows
    extra = 0 if problem.extra is None else problem.extra.size
    lower = np.maximum(bounds.lower, -ENDLESS_RAD)
    upper = np.minimum(bounds.upper, ENDLESS_RAD)
    idle = ~(rows[:, lower[:n] < upper[:n]] != 0.0).any(axis=1)
    values, room = rows @ q_start, np.where(idle, 1.0, ROOM_RAD)
    row_lower = np.minimum(lower[n:], values - room)
    row_upper = np.maximum(upper[n:], values + room)
    free = np.full(6 * k, np.inf)
    return Region(
        lower=np.concatenate([lower[:n], -free]),
        upper=np.concatenate([upper[:n], free]),
        g_lower=np.concatenate([[0.0, 0.0, 0.0, -np.inf] * k, row_lower, np.zeros(extra)]),
        g_upper=np.concatenate([[0.0, 0.0, 0.0, 1.0] * k, row_upper, np.full(extra, np.inf)]),
    )


def _error(tips: Sequence[TipParameters], auxiliary: Vector) -> float:
    """The worst tip's error in what is a condition, in units of its tolerance."""
    worst = 0.0
    for tip, us in zip(tips, auxiliary.reshape(-1, 6), strict=True):
        if tip.condition_position or tip.condition_orientation:
            error = float(np.linalg.norm(tip.radius * us[:3] + us[3:]))
            worst = max(worst, error * INSIDE_SHARE / tip.radius)
    return worst
