"""One reaching problem: its last optimal point is followed or, where that ends, IPOPT searches."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.path_following import Constraints, Held, OptimalPoint, PathFollower
from dforc.symbolic.ipopt import Bounds, IpoptAnswer, IpoptSolver

ACTIVE_MULTIPLIER = 1e-6  # IPOPT leaves about 1e-9 / slack on limits that are not active


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """Where the search ended. `point` is None unless the optimality conditions hold there."""

    q: Vector
    point: OptimalPoint | None
    iterations: int


class ReachingSolver:
    """Eq. 11 (`weight` None; its condition is IPOPT's constraint 0), or the nearest point."""

    def __init__(
        self,
        follower: PathFollower,
        ipopt: IpoptSolver,
        tolerance_m: float,
        weight: float | None,
    ) -> None:
        self._follower = follower
        self._ipopt = ipopt
        self._has_sphere = weight is None
        self._sphere_lower = np.full(1, -np.inf)
        self._sphere_upper = np.full(1, tolerance_m * tolerance_m)

    def follow(
        self, start: OptimalPoint | None, parameters: Vector, constraints: Constraints
    ) -> Reached | None:
        """From an optimal point of nearly the same problem; None where following is given up."""
        if start is None:
            return None
        point = self._follower.follow(start, parameters, constraints)
        return None if point is None else Reached(point.q, point, point.evaluations)

    def search(self, q_start: Vector, parameters: Vector, constraints: Constraints) -> Reached:
        """By IPOPT, from any posture, then polished by a last Newton step or two."""
        n = len(q_start)
        g_lower, g_upper = constraints.lower[n:], constraints.upper[n:]
        if self._has_sphere:
            g_lower = np.concatenate([self._sphere_lower, g_lower])
            g_upper = np.concatenate([self._sphere_upper, g_upper])
        bounds = Bounds(constraints.lower[:n], constraints.upper[:n], g_lower, g_upper)
        answer = self._ipopt.solve(q_start, parameters, bounds)
        if not answer.solved or not np.isfinite(answer.q).all():
            return Reached(answer.q, None, answer.iterations)
        point = self._optimal_point(answer, parameters)
        polished = self._follower.follow(point, parameters, constraints)
        if polished is None:
            return Reached(answer.q, point, answer.iterations)
        return Reached(polished.q, polished, answer.iterations + polished.evaluations)

    def _optimal_point(self, answer: IpoptAnswer, parameters: Vector) -> OptimalPoint:
        rows = answer.row_multipliers
        y = np.zeros(3)
        if self._has_sphere:
            y = 2.0 * rows[0] * self._follower.residual(answer.q, parameters)
            rows = rows[1:]
        multipliers = np.concatenate([answer.bound_multipliers, rows])
        held: Held = {
            int(i): float(np.sign(multipliers[i]))
            for i in np.flatnonzero(np.abs(multipliers) > ACTIVE_MULTIPLIER)
        }
        return OptimalPoint(answer.q, y, held, answer.iterations)
