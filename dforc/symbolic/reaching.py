"""The reaching problem (eq. 11) as CasADi functions with written-out first and second derivatives.

Cost f = |e|^2 + sum_i w_i (q_rest_i - q_i)^2, with e the rotation vector of R(q) R_d' in the base
frame. Its derivatives come from the geometry of the chain, not from differentiation of the code:

    de    = Jl^-1(e) J_w dq                                        (left Jacobian of SO(3))
    H(|e|^2)_ij = 2 z_i' S z_j + e . (z_j x z_i),  S = k I + b e e',  j at or below i in the chain
    H(|x|^2)_ij = 2 l_i . l_j + 2 x . (z_j x l_i),  x = p(q) - x_d

with l_i = z_i x (p - o_i), k = (|e|/2) cot(|e|/2), b = (1 - k) / |e|^2. Differentiating the code
gave a Hessian five times as long. Every function has the parameter vector
p = [x_d (3), R_d column by column (9), q_rest (n), w (n)], w = beta diag(W).
"""

from dataclasses import dataclass

import casadi as ca

from dforc.arrays import Matrix
from dforc.symbolic.kinematics import SymbolicChain

SMALL = 1e-7  # rad; below it the series of k and b are exact to rounding


@dataclass(frozen=True, slots=True, eq=False)
class Terms:
    """A scalar with its gradient (n, 1) and Hessian (n, n)."""

    value: ca.SX
    gradient: ca.SX
    hessian: ca.SX


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What nlpsol takes: the problem itself, and its derivatives as options."""

    nlp: dict[str, ca.SX]
    options: dict[str, ca.Function]


def parameters(n: int) -> ca.SX:
    """The parameter vector (12 + 2n)."""
    return ca.SX.sym("p", 12 + 2 * n)


def orientation_cost(s: SymbolicChain, R_desired: ca.SX) -> Terms:
    """|e|^2 [rad^2]."""
    M = s.rotation @ R_desired.T
    sine_axis = 0.5 * ca.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1])
    cosine = 0.5 * (ca.trace(M) - 1)
    sine = ca.sqrt(ca.sumsqr(sine_axis))
    angle = ca.atan2(sine, cosine)
    small = sine < SMALL
    ratio = ca.if_else(ca.logic_and(small, cosine > 0), 1, angle / ca.fmax(sine, SMALL))
    e = ratio * sine_axis
    k = 0.5 * ratio * (1 + cosine)
    b = ca.if_else(angle < 1e-3, 1 / 12, (1 - k) / ca.fmax(angle * angle, 1e-6))
    gradient = 2 * s.axes.T @ e
    turned = 2 * (k * s.axes + b * e @ (e.T @ s.axes))  # 2 S z_j
    hessian = ca.SX.zeros(s.q.numel(), s.q.numel())
    for upper, i in enumerate(s.order):
        for j in s.order[: upper + 1]:
            entry = ca.dot(s.axes[:, i], turned[:, j])
            if i != j:
                entry += ca.dot(e, ca.cross(s.axes[:, j], s.axes[:, i]))
            hessian[i, j] = hessian[j, i] = entry
    return Terms(angle * angle, gradient, hessian)


def squared_distance(s: SymbolicChain, x_desired: ca.SX) -> Terms:
    """|p(q) - x_d|^2 [m^2]."""
    x = s.position - x_desired
    hessian = 2 * s.linear.T @ s.linear + _bend(s, 2 * x)
    return Terms(ca.sumsqr(x), 2 * s.linear.T @ x, hessian)


def rest_cost(q: ca.SX, rest: ca.SX, weights: ca.SX) -> Terms:
    """Sum of w_i (q_rest_i - q_i)^2."""
    away = q - rest
    return Terms(ca.dot(weights, away * away), 2 * weights * away, 2 * ca.diag(weights))


def reaching_problem(s: SymbolicChain, A: Matrix) -> Problem:
    """Eq. 11: minimise f subject to |x|^2 <= g_0 and A q between bounds."""
    p, cost, distance = _terms(s)
    rows = ca.DM(A)
    g = ca.vertcat(distance.value, rows @ s.q)
    jacobian = ca.vertcat(distance.gradient.T, rows)
    multiplier = ca.SX.sym("lam_g", g.numel())
    factor = ca.SX.sym("lam_f")
    hessian = factor * cost.hessian + multiplier[0] * distance.hessian
    return _problem(s.q, p, cost, g, jacobian, ca.triu(hessian), factor, multiplier)


def nearest_problem(s: SymbolicChain, A: Matrix, weight: float) -> Problem:
    """Minimise f + weight |x|^2 with A q between bounds: has an answer wherever the target is."""
    p, cost, distance = _terms(s)
    whole = Terms(
        cost.value + weight * distance.value,
        cost.gradient + weight * distance.gradient,
        cost.hessian + weight * distance.hessian,
    )
    rows = ca.DM(A)
    multiplier = ca.SX.sym("lam_g", rows.shape[0])
    factor = ca.SX.sym("lam_f")
    hessian = ca.triu(factor * whole.hessian)
    return _problem(s.q, p, whole, rows @ s.q, ca.SX(rows), hessian, factor, multiplier)


def optimality_function(s: SymbolicChain) -> ca.Function:
    """What Newton's method on the optimality conditions needs, in one evaluation.

    (q, p, y) -> gradient of f (n), Hessian of f + y . x (n, n), x (3), its Jacobian (3, n).
    """
    p, cost, _ = _terms(s)
    y = ca.SX.sym("y", 3)
    hessian = cost.hessian + _bend(s, y)
    x = s.position - p[:3]
    return ca.Function(
        "optimality",
        [s.q, p, y],
        [cost.gradient, ca.densify(hessian), x, ca.densify(s.linear)],
        ["q", "p", "y"],
        ["gradient", "hessian", "x", "jacobian"],
    )


def _bend(s: SymbolicChain, y: ca.SX) -> ca.SX:
    """Second derivative of y . p(q): y . (z_j x l_i) for j at or below i in the chain."""
    bend = ca.SX.zeros(s.q.numel(), s.q.numel())
    lever = [ca.cross(y, s.axes[:, j]) for j in range(s.q.numel())]
    for upper, i in enumerate(s.order):
        for j in s.order[: upper + 1]:
            bend[i, j] = bend[j, i] = ca.dot(lever[j], s.linear[:, i])
    return bend


def _terms(s: SymbolicChain) -> tuple[ca.SX, Terms, Terms]:
    n = s.q.numel()
    p = parameters(n)
    posture = rest_cost(s.q, p[12 : 12 + n], p[12 + n :])
    orientation = orientation_cost(s, ca.reshape(p[3:12], 3, 3))
    cost = Terms(
        orientation.value + posture.value,
        orientation.gradient + posture.gradient,
        orientation.hessian + posture.hessian,
    )
    return p, cost, squared_distance(s, p[:3])


def _problem(
    q: ca.SX,
    p: ca.SX,
    cost: Terms,
    g: ca.SX,
    jacobian: ca.SX,
    hessian: ca.SX,
    factor: ca.SX,
    multiplier: ca.SX,
) -> Problem:
    options = {
        "grad_f": ca.Function(
            "grad_f", [q, p], [cost.value, cost.gradient], ["x", "p"], ["f", "grad_f_x"]
        ),
        "jac_g": ca.Function("jac_g", [q, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        "hess_lag": ca.Function(
            "hess_lag",
            [q, p, factor, multiplier],
            [hessian],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        ),
    }
    return Problem({"x": q, "p": p, "f": cost.value, "g": g}, options)
