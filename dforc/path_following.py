"""Newton's method on the optimality conditions of the reaching problem, to follow a moving target.

IPOPT spends about 0.2 ms per iteration on its own book-keeping, most of it to find out which
limits are active. While a target moves a few millimetres per tick these rarely change, and a few
Newton steps on the Karush-Kuhn-Tucker conditions of the same problem from the previous answer
reach IPOPT's tolerance:

    grad f + J' y + N' nu = 0,   x(q) = r,   N q = b,   nu of the right sign, all other limits kept

where eq. 11's condition |x|^2 <= eps is active, so its multiplier lambda gives y = 2 lambda x and
the residual r = sqrt(eps) y / |y|. The nearest-point problem has no such condition; there y = 2
weight x(q) is part of the gradient. A step that leaves the neighbourhood, or an answer that is no
minimum, is given up (None): the caller then asks IPOPT.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.symbolic.buffered import BufferedFunction

NEWTON_STEPS = 6
LIMIT_CHANGES = 8  # changes of the active set in one Newton step
LARGEST_STEP_RAD = 0.2  # per Newton step and joint; a 5 mm tick needs about 0.02
SETTLED_RAD = 1e-5  # the error left after a step is its square: 1e-10
OUTSIDE = 1e-9  # rad a limit may be overstepped before it is held
WRONG_SIGN = 1e-9  # of a multiplier before its limit is released
INSIDE_SHARE = 0.999  # r ends this far inside the sphere of eq. 11, for rounding
CURVATURE = 1e3  # makes the held directions stiff in the second-order check

Held = dict[int, float]  # constraint index -> +1 at its upper bound, -1 at its lower bound


@dataclass(frozen=True, slots=True, eq=False)
class OptimalPoint:
    """A posture that meets the optimality conditions, and what holds it there."""

    q: Vector  # (n,)
    y: Vector  # (3,) multiplier of the position residual
    held: Held
    evaluations: int


@dataclass(frozen=True, slots=True, eq=False)
class Constraints:
    """lower <= C q <= upper, the joints' ranges first."""

    C: Matrix  # (n + m, n)
    lower: Vector
    upper: Vector

    def fixed(self) -> frozenset[int]:
        """Constraints without choice, such as blocked joints: held whatever their multiplier."""
        return frozenset(np.flatnonzero(self.upper - self.lower <= OUTSIDE).tolist())


class PathFollower:
    """Optimality conditions of one chain. `weight` None: eq. 11; else: the nearest point."""

    def __init__(
        self, evaluation: BufferedFunction, tolerance_m: float, weight: float | None
    ) -> None:
        self._evaluation = evaluation
        self._radius_m = INSIDE_SHARE * tolerance_m
        self._weight = weight
        self._gradient = evaluation.outputs["gradient"]
        self._hessian = evaluation.matrix("hessian")
        self._x = evaluation.outputs["x"]
        self._J = evaluation.matrix("jacobian")

    def follow(
        self, start: OptimalPoint, parameters: Vector, constraints: Constraints
    ) -> OptimalPoint | None:
        """The optimal point of the problem as it is now, near the one it had before."""
        n = len(start.q)
        q: Vector = np.clip(start.q, constraints.lower[:n], constraints.upper[:n])
        y, fixed = start.y, constraints.fixed()
        held = {**start.held, **dict.fromkeys(fixed, 1.0)}
        self._evaluation.inputs["p"][:] = parameters
        for evaluations in range(1, NEWTON_STEPS + 1):
            H, rhs, E = self._linearise(q, y)
            step = _constrained_step(H, rhs, E, q, constraints, held, fixed)
            if step is None:
                return None
            dq, y_new, held = step
            length = float(np.abs(dq).max())
            if not length < LARGEST_STEP_RAD:  # also catches NaN
                return None
            q = q + dq
            y = y_new if self._weight is None else y
            if length < SETTLED_RAD:
                if not _is_minimum(H, E, constraints.C[list(held)]):
                    return None
                return OptimalPoint(q, y, held, evaluations)
        return None

    def residual(self, q: Vector, parameters: Vector) -> Vector:
        """x(q) - x_d (3,) [m]."""
        self._evaluation.inputs["p"][:] = parameters
        self._evaluation.inputs["q"][:] = q
        self._evaluation.run()
        return self._x.copy()

    def _linearise(self, q: Vector, y: Vector) -> tuple[Matrix, Vector, Matrix]:
        """Hessian of the Lagrangian, right-hand side and equality rows of the Newton system."""
        given = self._evaluation.inputs
        given["q"][:] = q
        if self._weight is None:
            given["y"][:] = y
            self._evaluation.run()
            length = float(np.sqrt(y @ y))
            r = y * (self._radius_m / length) if length > 0.0 else y
            return self._hessian, np.concatenate([-self._gradient, r - self._x]), self._J
        return self._linearise_nearest()

    def _linearise_nearest(self) -> tuple[Matrix, Vector, Matrix]:
        assert self._weight is not None
        given = self._evaluation.inputs
        self._evaluation.run()
        given["y"][:] = 2.0 * self._weight * self._x  # y . x bends as the weighted distance does
        self._evaluation.run()
        J = self._J
        H = self._hessian + (2.0 * self._weight) * (J.T @ J)
        gradient = self._gradient + (2.0 * self._weight) * (J.T @ self._x)
        return H, -gradient, np.zeros((0, len(gradient)))


def _constrained_step(
    H: Matrix,
    rhs: Vector,
    E: Matrix,
    q: Vector,
    constraints: Constraints,
    held: Held,
    fixed: frozenset[int],
) -> tuple[Vector, Vector, Held] | None:
    """Newton step dq, multipliers of E, limits held at its end; None if these do not settle."""
    C, lower, upper = constraints.C, constraints.lower, constraints.upper
    n, e = len(q), len(E)
    held = dict(held)
    for _ in range(LIMIT_CHANGES):
        rows = list(held)
        size = n + e + len(rows)
        if e + len(rows) > n:
            return None
        K = np.zeros((size, size))
        K[:n, :n] = H
        K[:n, n : n + e] = E.T
        K[n : n + e, :n] = E
        right = np.empty(size)
        right[: n + e] = rhs
        if rows:
            N = C[rows]
            K[:n, n + e :] = N.T
            K[n + e :, :n] = N
            bound = [upper[i] if held[i] > 0.0 else lower[i] for i in rows]
            right[n + e :] = bound - N @ q
        try:
            solution = np.asarray(np.linalg.solve(K, right), dtype=np.float64)
        except np.linalg.LinAlgError:
            return None
        changed = _release(held, fixed, solution[n + e :]) or _hold(
            held, C @ (q + solution[:n]), lower, upper
        )
        if not changed:
            return solution[:n], solution[n : n + e], held
    return None


def _release(held: Held, fixed: frozenset[int], multipliers: Vector) -> bool:
    """Let go of the limit that pulls hardest instead of pushing."""
    worst, chosen = -WRONG_SIGN, None
    for row, multiplier in zip(held, multipliers.tolist(), strict=True):
        if held[row] * multiplier < worst and row not in fixed:
            worst, chosen = held[row] * multiplier, row
    if chosen is None:
        return False
    del held[chosen]
    return True


def _hold(held: Held, values: Vector, lower: Vector, upper: Vector) -> bool:
    """Hold the limit that is overstepped most."""
    below, above = lower - values, values - upper
    i, j = int(below.argmax()), int(above.argmax())
    if max(below[i], above[j]) <= OUTSIDE:
        return False
    row, side = (i, -1.0) if below[i] > above[j] else (j, 1.0)
    if row in held:
        return False
    held[row] = side
    return True


def _is_minimum(H: Matrix, E: Matrix, N: Matrix) -> bool:
    """The Hessian is positive definite along what equality and held limits leave free."""
    try:
        np.linalg.cholesky(H + CURVATURE * (E.T @ E + N.T @ N))
    except np.linalg.LinAlgError:
        return False
    return True
