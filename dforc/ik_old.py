"""Inverse kinematics as optimisation: eq. 1 of DForC, eq. 11 of the force control paper.

    q* = argmin |alpha_d - K_alpha(q)|^2 + beta (q_rest - q)' W (q_rest - q)
    subject to |x_d - K_x(q)|^2 <= eps,  q_L <= q <= q_U,  row_L <= A q <= row_U

solved by IPOPT with exact first and second derivatives. |alpha_d - K_alpha(q)| is the angle of
R_d R(q)'. One problem is built once; target, rest posture, weights, limits, blocked joints and the
joint step of one tick are arguments of each solve. Where no posture reaches the position, a second,
always feasible problem (cost + 1e4 |x_d - K_x(q)|^2 under the same limits) gives the nearest one.

Positions in m and rotations as 3x3 matrices in the base frame; joint vectors (n,) in the order of
the model.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import LimitsError
from dforc.ik_request import IkRequest, RequestCheck
from dforc.kinematics import ChainKinematics
from dforc.limits import JointLimits
from dforc.path_following import OptimalPoint, PathFollower
from dforc.reaching import Reached, ReachingSolver
from dforc.rotation import angle_between
from dforc.symbolic.buffered import BufferedFunction
from dforc.symbolic.ipopt import IpoptSolver
from dforc.symbolic.kinematics import symbolic_chain
from dforc.symbolic.reaching import nearest_problem, optimality_function, reaching_problem

NEAREST_WEIGHT = 1e4  # 1/m^2: ends within 0.1 mm of the smallest distance (measured, ik reference)
UNCHANGED = 1e-9  # m, rad: a request that differs by less gets the last answer again
SAME_PATH = 0.1  # m, matrix elements: a target that moved less is followed, else searched for
MEMORY_RAD = 1e-6  # a start this close to the last answer continues it
ROUNDING = 1e-3  # share of the position tolerance


class IkStatus(StrEnum):
    """What an answer is worth."""

    CONVERGED = "converged"
    INFEASIBLE = "infeasible"  # the position is out of reach: q is the nearest posture found
    OUT_OF_TIME = "out_of_time"  # the iteration cap was met: q is safe, but not the answer


@dataclass(frozen=True, slots=True, kw_only=True)
class IkSettings:
    """Constants of the problem."""

    beta: float = 0.01  # rad^2 of orientation error that one rad^2 of W-weighted posture is worth
    position_tolerance_m: float = 1e-4  # sqrt(eps) of eq. 11
    iteration_cap: int = 60  # of one IPOPT run; a solve makes two runs at most. The deadline


@dataclass(frozen=True, slots=True, eq=False)
class IkResult:
    """One answer. `q_rad` is finite and keeps limits, rows and step whatever the status."""

    q_rad: Vector  # (n,), read-only
    status: IkStatus
    position_error_m: float  # by the model's own kinematics, not the optimiser's
    orientation_error_rad: float
    iterations: int  # IPOPT iterations and Newton steps
    step_limited: bool  # the joint step of this tick stood in the way: ask again from here


@dataclass(frozen=True, slots=True, eq=False)
class _Memory:
    """The last request and its answer."""

    request: IkRequest
    result: IkResult
    point: OptimalPoint | None


class InverseKinematics:
    """The solver. It remembers its last answer, to continue from it, and nothing else."""

    def __init__(
        self,
        model: ChainKinematics,
        limits: JointLimits,
        rest_rad: ArrayLike,
        rest_weights: ArrayLike,
        settings: IkSettings | None = None,
    ) -> None:
        """Build the problem once (about 0.1 s).

        Args:
            model: gives the chain, and checks every answer.
            limits: joint ranges and rows; `set_limits` changes their values, not the matrix A.
            rest_rad: rest posture (n,).
            rest_weights: diagonal of W (n,), 0 = free.
            settings: beta, eps, iteration cap.
        """
        self._settings = settings or IkSettings()
        self._model = model
        self._memory: _Memory | None = None
        tolerance_m = self._settings.position_tolerance_m
        cap = self._settings.iteration_cap
        chain = symbolic_chain(model.chain_description(), model.n)
        evaluation = BufferedFunction(optimality_function(chain))
        self._exact = ReachingSolver(
            PathFollower(evaluation, tolerance_m, None),
            IpoptSolver("reaching", reaching_problem(chain, limits.rows), cap),
            tolerance_m,
            None,
        )
        self._nearest = ReachingSolver(
            PathFollower(evaluation, tolerance_m, NEAREST_WEIGHT),
            IpoptSolver("nearest", nearest_problem(chain, limits.rows, NEAREST_WEIGHT), cap),
            tolerance_m,
            NEAREST_WEIGHT,
        )
        self._limits = limits
        self.set_rest(rest_rad, rest_weights)

    def set_rest(self, rest_rad: ArrayLike, rest_weights: ArrayLike) -> None:
        """Change the rest posture (n,) and the diagonal of W (n,) from the next solve on."""
        n = self._model.n
        rest, weights = finite_vector("rest", rest_rad, n), finite_vector("W", rest_weights, n)
        if weights.min() < 0.0:
            raise LimitsError(f"rest weights must not be negative: {weights.tolist()}")
        self._posture = constant(np.concatenate([rest, self._settings.beta * weights]))
        self._check = RequestCheck(self._limits, self._posture)
        self.reset()

    def set_limits(self, limits: JointLimits) -> None:
        """Change joint ranges and row bounds from the next solve on; A must be the same."""
        if limits.n != self._model.n or not np.array_equal(limits.C, self._limits.C):
            raise LimitsError("the rows' matrix and the joints are fixed when the solver is built")
        self._limits = limits
        self._check = RequestCheck(limits, self._posture)
        self.reset()

    def reset(self) -> None:
        """Forget the last answer: the next solve starts from q_start alone."""
        self._memory = None

    def solve(
        self,
        position_m: ArrayLike,
        rotation: Matrix,
        q_start_rad: ArrayLike,
        step_limit_rad: float | ArrayLike = math.inf,
        blocked: Sequence[bool] | None = None,
    ) -> IkResult:
        """Posture for a pose of the hand.

        An unchanged request, or the last answer handed in as the start for an unchanged target,
        gets the last answer again, without a search. A start that is the last answer continues it;
        any other start begins afresh.

        Args:
            position_m: x_d (3,).
            rotation: R_d (3, 3).
            q_start_rad: where the search starts and the joint step is counted from (n,): the
                previous answer while tracking, the present posture at first. It is brought inside
                the limits if it is outside.
            step_limit_rad: largest change of each joint against q_start (scalar or (n,)).
            blocked: joints held at q_start (n,); None = all free.

        Raises:
            NotFiniteError: NaN or infinity in the arguments; the solver's memory is unchanged.
            ShapeError: R_d is no rotation, or a vector has another length.
        """
        request = self._check.request(position_m, rotation, q_start_rad, step_limit_rad, blocked)
        if self._memory is not None and self._is_answered(request, self._memory):
            return self._memory.result
        reached, status = self._search(request)
        result = self._verified(request, reached, status)
        self._memory = _Memory(request, result, reached.point)
        return result

    def _search(self, request: IkRequest) -> tuple[Reached, IkStatus]:
        p, constraints = request.parameters, request.constraints
        start = self._continued(request)
        if start is not None:
            memory = self._memory
            lost = memory is not None and memory.result.status is IkStatus.INFEASIBLE
            followed = None if lost else self._exact.follow(start, p, constraints)
            if followed is not None:
                return followed, IkStatus.CONVERGED
            # Within a bounded step IPOPT would find no other posture than this nearest one.
            if lost or request.step_bounded:
                return self._search_nearest(request, request.q_start, start)
        reached = self._exact.search(request.q_start, p, constraints)
        if reached.point is not None:
            return reached, IkStatus.CONVERGED
        q = reached.q if np.isfinite(reached.q).all() else request.q_start
        nearest, status = self._search_nearest(request, q, None)
        total = reached.iterations + nearest.iterations
        return Reached(nearest.q, nearest.point, total), status

    def _continued(self, request: IkRequest) -> OptimalPoint | None:
        """The last optimal point, if this request goes on from there."""
        memory = self._memory
        if memory is None or np.abs(request.q_start - memory.result.q_rad).max() > MEMORY_RAD:
            return None
        return memory.point if request.target_moved(memory.request) <= SAME_PATH else None

    def _search_nearest(
        self, request: IkRequest, q: Vector, start: OptimalPoint | None
    ) -> tuple[Reached, IkStatus]:
        """The nearest posture; where that turns out to reach, the answer of eq. 11 from there."""
        p, constraints = request.parameters, request.constraints
        nearest = self._nearest.follow(start, p, constraints)
        nearest = nearest or self._nearest.search(q, p, constraints)
        if nearest.point is None:
            return nearest, IkStatus.OUT_OF_TIME
        distance_m = self._distance(nearest.q, request)
        if distance_m > 2.0 * self._settings.position_tolerance_m:
            return nearest, IkStatus.INFEASIBLE
        x = self._model.tip_pose(nearest.q)[1] - request.position_m
        point = OptimalPoint(nearest.q, 2.0 * NEAREST_WEIGHT * x, nearest.point.held, 0)
        exact = self._exact.follow(point, p, constraints)
        if exact is None and start is not None:  # one IPOPT run is left
            exact = self._exact.search(nearest.q, p, constraints)
        if exact is None or exact.point is None:
            return nearest, IkStatus.INFEASIBLE
        total = nearest.iterations + exact.iterations
        return Reached(exact.q, exact.point, total), IkStatus.CONVERGED

    def _verified(self, request: IkRequest, reached: Reached, status: IkStatus) -> IkResult:
        """The answer as the caller may use it: finite, inside everything, with its true errors."""
        n = self._model.n
        lower, upper = request.constraints.lower[:n], request.constraints.upper[:n]
        q = np.clip(reached.q, lower, upper)
        if not np.isfinite(q).all() or self._limits.violation(q) > UNCHANGED:
            q, status = request.q_start.copy(), IkStatus.OUT_OF_TIME
        R, p = self._model.tip_pose(q)
        error_m = float(np.linalg.norm(p - request.position_m))
        if status is IkStatus.OUT_OF_TIME:  # half-converged: only if it is better than staying
            if error_m > self._distance(request.q_start, request):
                q = request.q_start.copy()
                R, p = self._model.tip_pose(q)
                error_m = float(np.linalg.norm(p - request.position_m))
        else:
            reaches = error_m <= self._settings.position_tolerance_m * (1.0 + ROUNDING)
            status = IkStatus.CONVERGED if reaches else IkStatus.INFEASIBLE
        confined = request.confining(q, self._limits)
        limited = bool((confined & (upper - lower > UNCHANGED)).any())
        angle_rad = angle_between(R, request.rotation)
        return IkResult(constant(q), status, error_m, angle_rad, reached.iterations, limited)

    def _is_answered(self, request: IkRequest, memory: _Memory) -> bool:
        before, result = memory.request, memory.result
        if result.status is IkStatus.OUT_OF_TIME or request.target_moved(before) > UNCHANGED:
            return False
        unmoved = np.abs(request.q_start - before.q_start).max() <= UNCHANGED
        arrived = np.abs(request.q_start - result.q_rad).max() <= UNCHANGED
        if arrived and not before.confining(result.q_rad, self._limits).any():
            return True
        return bool(unmoved) and request.same_range(before)

    def _distance(self, q: Vector, request: IkRequest) -> float:
        return float(np.linalg.norm(self._model.tip_pose(q)[1] - request.position_m))
