"""Sequential quadratic programming on eq. 11 with exact Hessians: the fastest solver, the default.

The search itself is in kernel_search.py; with constraints that are plugged in, in plugged.py.
"""

from collections.abc import Sequence

import numpy as np

from dforc.arrays import Vector
from dforc.ik.kernel_chain import ChainArrays, Indices, chain_arrays
from dforc.ik.kernel_cost import CONDITION, COST, IGNORED, Chains, Geometry, Goal, Multipliers
from dforc.ik.kernel_search import STOPPED, search
from dforc.ik.kernel_step import Limits, Room
from dforc.ik.plugged import PluggedSearch
from dforc.ik.problem import POSITION_WEIGHT, IkProblem, Priority, Tip, TipTarget
from dforc.ik.solver import RawAnswer, SearchBounds

BLOCKED_RAD = 1e-12  # a joint with less room than this does not move
INSIDE_SHARE = 0.999  # of the tolerance: for rounding
# Of position (1/m^2) and orientation on the way to the nearest posture. Plugged-in constraints
# press against it with a stiffness of their own, which must be the larger one.
NEAREST_WEIGHTS = (1e5, 1e3)
SOFTER_WEIGHTS = (2e3, 1e2)


class Sqp:
    """The solver. It keeps tables and room for the last problem, and no answers."""

    def __init__(self) -> None:
        self._problem: IkProblem | None = None
        self._chain_of: dict[int, tuple[Tip, ChainArrays]] = {}
        self._chains: Chains
        self._goal: Goal
        self._multipliers: Multipliers
        self._geometry: Geometry
        self._all: Indices
        self._rooms: dict[tuple[int, int], Room] = {}

    def solve(
        self,
        problem: IkProblem,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        bounds: SearchBounds,
        proximal: float,
        budget: int,
    ) -> RawAnswer:
        """As dforc.ik.solver.Solver says."""
        self._prepare(problem)
        goal = self._goal
        goal.start[:] = q_start
        goal.proximal[0] = proximal
        self._aim(problem, targets)
        limits = self._limits(problem, bounds)
        f = len(limits.free)
        room = self._room(f, f + len(limits.C) - problem.n, problem.n)
        q = q_start.copy()
        tables = (self._multipliers, self._geometry, room)
        if problem.extra is not None:
            plugged = PluggedSearch(self._chains, goal, limits, *tables, problem.extra)
            solved, iterations = plugged.run(q, budget)
            return RawAnswer(q, iterations, solved)
        ended, iterations = search(q, self._chains, goal, limits, *tables, budget, proximal == 0.0)
        return RawAnswer(q, iterations, ended != STOPPED)

    def _limits(self, problem: IkProblem, bounds: SearchBounds) -> Limits:
        n = problem.n
        can_move = bounds.upper[:n] - bounds.lower[:n] > BLOCKED_RAD
        free = slots = self._all
        if not can_move.all():
            free = np.flatnonzero(can_move)
            slots = np.full(n, -1, dtype=np.int64)
            slots[free] = np.arange(len(free))
        return Limits(problem.limits.C, bounds.lower, bounds.upper, free, slots)

    def _prepare(self, problem: IkProblem) -> None:
        """Tables of a problem, when it is another one."""
        if problem is self._problem:
            return
        chains = [self._chain(i, tip) for i, tip in enumerate(problem.tips)]
        tips, n = len(chains), problem.n
        longest = max(len(chain.joints) for chain in chains)
        joints = np.zeros((tips, longest), dtype=np.int64)
        turns, places = np.zeros((tips, longest + 1, 9)), np.zeros((tips, longest + 1, 3))
        for i, chain in enumerate(chains):
            k = len(chain.joints)
            joints[i, :k] = chain.joints
            turns[i, : k + 1], places[i, : k + 1] = chain.turns, chain.places
        counts = np.array([len(chain.joints) for chain in chains])
        self._chains = Chains(counts, joints, turns, places)
        radii = (problem.position_tolerance_m, problem.orientation_tolerance_rad)
        self._goal = Goal(
            positions=np.zeros((tips, 3)),
            rotations=np.zeros((tips, 9)),
            roles=np.zeros((tips, 2), dtype=np.int64),
            weights=np.ones(2),
            radii=INSIDE_SHARE * np.array(radii),
            nearest=np.array(NEAREST_WEIGHTS if problem.extra is None else SOFTER_WEIGHTS),
            rest=problem.rest_rad.copy(),
            stiffness=problem.beta * problem.rest_weights,
            start=np.zeros(n),
            proximal=np.zeros(1),
        )
        self._multipliers = Multipliers(np.zeros((tips, 2, 3)), np.ones(2), np.zeros(2))
        self._geometry = Geometry(
            axes=np.zeros((longest + 1, 3)),
            origins=np.zeros((longest + 4, 3)),
            levers=np.zeros((longest, 3)),
            residuals=np.zeros((tips, 2, 3)),
            pull=np.zeros((3, 3)),
        )
        self._rooms.clear()
        self._all = np.arange(n)
        self._problem = problem

    def _chain(self, place: int, tip: Tip) -> ChainArrays:
        known = self._chain_of.get(place)
        if known is None or known[0] is not tip:
            chain = list(tip.model.chain_description())
            last = chain[-1]
            R, p = last.R @ tip.offset_rotation, last.p + last.R @ tip.offset_m
            chain[-1] = last._replace(R=R, p=p)
            known = self._chain_of[place] = (tip, chain_arrays(chain))
        return known[1]

    def _aim(self, problem: IkProblem, targets: Sequence[TipTarget | None]) -> None:
        goal = self._goal
        first = problem.priority is Priority.POSITION
        goal.weights[0], goal.weights[1] = POSITION_WEIGHT, 1.0
        for t, target in enumerate(targets):
            goal.roles[t] = IGNORED
            if target is None:
                continue
            if target.position_m is not None:
                goal.positions[t] = target.position_m
                goal.roles[t, 0] = CONDITION if first else COST
            if target.rotation is not None:
                goal.rotations[t] = target.rotation.ravel()
                goal.roles[t, 1] = COST if first else CONDITION

    def _room(self, f: int, rows: int, n: int) -> Room:
        room = self._rooms.get((f, rows))
        if room is None:
            room = self._rooms[f, rows] = Room(
                g=np.zeros(f),
                H=np.zeros((f, f)),
                B=np.zeros((f, f)),
                L=np.zeros((f, f)),
                J=np.zeros((f, f)),
                R=np.zeros((f, f)),
                active=np.zeros((3, f)),
                held=np.zeros(1, dtype=np.int64),
                work=np.zeros((3, f)),
                dq=np.zeros(f),
                q=np.zeros(n),
                middle=np.zeros(n),
                C=np.zeros((rows, f)),
                lower=np.zeros(rows),
                upper=np.zeros(rows),
            )
        return room
