"""Sequential quadratic programming on eq. 11 with exact Hessians: the fastest solver, the default.

The search itself is in kernel_search.py. Extra constraints enter by linear rows around the present
posture, again and again until the posture stands.
"""

from collections.abc import Sequence

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.ik.kernel_chain import ChainArrays, chain_arrays
from dforc.ik.kernel_cost import COST, CONDITION, IGNORED, Chains, Geometry, Goal, Multipliers
from dforc.ik.kernel_search import STOPPED, Limits, Room, search
from dforc.ik.problem import POSITION_WEIGHT, ExtraConstraints, IkProblem, Priority, Tip, TipTarget
from dforc.ik.solver import RawAnswer, SearchBounds
from dforc.quadratic import NoSolutionError, minimise

BLOCKED_RAD = 1e-12  # a joint with less room than this does not move
INSIDE_SHARE = 0.999  # of the tolerance: for rounding
ROUNDS = 30  # of linearised extra constraints
EXTRA_STEP_RAD = 0.3  # of a joint, per round
EXTRA_ALLOWED = 0.1  # by which a round may miss them, per square of its step
SHORTER, LONGER = 0.3, 2.0  # next step, after one that missed and after one that did not
EXTRA_KEPT = 1e-6
STANDS_RAD = 1e-5


class Sqp:
    """The solver. It keeps tables and room for the last problem, and no answers."""

    def __init__(self) -> None:
        self._problem: IkProblem | None = None
        self._chain_of: dict[int, tuple[Tip, ChainArrays]] = {}
        self._chains: Chains
        self._goal: Goal
        self._multipliers: Multipliers
        self._geometry: Geometry
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
        if problem.extra is None:
            return self._search(problem, targets, q_start, problem.limits.C, bounds, budget)
        return self._around(problem, targets, q_start, bounds, budget, problem.extra)

    def _search(
        self,
        problem: IkProblem,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        C: Matrix,
        bounds: SearchBounds,
        budget: int,
    ) -> RawAnswer:
        self._aim(problem, targets)
        n = problem.n
        free = np.flatnonzero(bounds.upper[:n] - bounds.lower[:n] > BLOCKED_RAD)
        slots = np.full(n, -1, dtype=np.int64)
        slots[free] = np.arange(len(free))
        q = q_start.copy()
        limits = Limits(C, bounds.lower, bounds.upper, free, slots)
        room = self._room(len(free), len(free) + len(C) - n, n)
        ended, iterations = search(
            q,
            self._chains,
            self._goal,
            limits,
            self._multipliers,
            self._geometry,
            room,
            budget,
            self._goal.proximal[0] == 0.0,
        )
        return RawAnswer(q, iterations, ended != STOPPED)

    def _around(
        self,
        problem: IkProblem,
        targets: Sequence[TipTarget | None],
        q_start: Vector,
        bounds: SearchBounds,
        budget: int,
        extra: ExtraConstraints,
    ) -> RawAnswer:
        """Rounds of searches, each within the extra constraints as they are around its start."""
        n, used, step = problem.n, 0, EXTRA_STEP_RAD
        q, (h, J) = q_start, extra.evaluate(q_start)
        before = np.zeros(n)
        for _ in range(ROUNDS):
            sizes = np.maximum(np.linalg.norm(J, axis=1), 1e-9)
            rows = J / sizes[:, None]
            C = np.vstack([problem.limits.C, rows])
            lower = np.concatenate([bounds.lower, rows @ q - h / sizes])
            upper = np.concatenate([bounds.upper, np.full(len(h), np.inf)])
            lower[:n] = np.maximum(lower[:n], q - step)
            upper[:n] = np.minimum(upper[:n], q + step)
            try:
                begin = q if (h >= 0.0).all() else minimise(np.eye(n), -q, C, lower, upper)
            except NoSolutionError:
                break
            begin = np.minimum(np.maximum(begin, lower[:n]), upper[:n])
            inside = SearchBounds(lower, upper)
            answer = self._search(problem, targets, begin, C, inside, budget - used)
            used += answer.iterations
            if not answer.solved:
                break
            there = extra.evaluate(answer.q)
            moved = float(np.abs(answer.q - q).max())
            if moved < STANDS_RAD:
                kept = bool((there[0] >= -EXTRA_KEPT).all())
                return RawAnswer(answer.q, used, kept)
            allowed = max(0.5 * _missed(h), EXTRA_ALLOWED * moved * moved)
            if _missed(there[0]) > allowed:  # the rows were too far from the truth
                step = SHORTER * moved
            else:
                change = answer.q - q
                back = float(change @ before) < 0.0  # two answers may take turns
                step = 0.5 * moved if back else min(EXTRA_STEP_RAD, LONGER * step)
                q, (h, J), before = answer.q, there, change
            if used >= budget:
                break
        return RawAnswer(q_start, used, solved=False)

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
                C=np.zeros((rows, f)),
                lower=np.zeros(rows),
                upper=np.zeros(rows),
            )
        return room


def _missed(h: Vector) -> float:
    return max(0.0, -float(h.min(initial=np.inf)))
