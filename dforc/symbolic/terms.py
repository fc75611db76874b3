"""Errors of a hand's pose and the rest posture as CasADi expressions with their derivatives.

The derivatives come from the geometry of the chain, not from differentiation of the code, which
gave a Hessian five times as long. With e the rotation vector of R(q) R_d' in the base frame, Q its
unit quaternion (Q_0 the scalar part), v = 2 (Q_1, Q_2, Q_3), x = p(q) - x_d, l_i = z_i x (p - o_i),
and j at or below i in the chain:

    de    = Jl^-1(e) J_w dq                                        (left Jacobian of SO(3))
    H(|e|^2)_ij = 2 z_i' S z_j + e . (z_j x z_i),  S = k I + b e e'
    H(|x|^2)_ij = 2 l_i . l_j + 2 x . (z_j x l_i),  H(y . x)_ij = y . (z_j x l_i)
    dv_i        = Q_0 z_i + z_i x v / 2
    H(y . v)_ij = y . (Q_0 c - (z_i . z_j) v / 2 + c x v / 2) / 2,  c = z_j x z_i

where k = (|e|/2) cot(|e|/2) and b = (1 - k) / |e|^2. |v| = 2 sin(|e|/2) grows with |e| up to half
a turn and, unlike e, is smooth on the way: it stands for the orientation in conditions.
"""

from dataclasses import dataclass

import casadi as ca

from dforc.symbolic.kinematics import SymbolicChain

SMALL = 1e-7  # rad; below it the series of k and b are exact to rounding
HALF_TURN = 1e-6  # smallest Q_0: half a turn, where v has no direction


@dataclass(frozen=True, slots=True, eq=False)
class Terms:
    """A scalar with its gradient (n, 1) and Hessian (n, n)."""

    value: ca.SX
    gradient: ca.SX
    hessian: ca.SX

    def __add__(self, other: "Terms") -> "Terms":
        return Terms(
            self.value + other.value,
            self.gradient + other.gradient,
            self.hessian + other.hessian,
        )

    def times(self, factor: ca.SX) -> "Terms":
        """The same, weighted."""
        return Terms(factor * self.value, factor * self.gradient, factor * self.hessian)


@dataclass(frozen=True, slots=True, eq=False)
class Errors:
    """A vector error (3, 1), its Jacobian (3, n), and the Hessian of y . error (n, n)."""

    value: ca.SX
    jacobian: ca.SX
    bend: ca.SX

    def times(self, factor: ca.SX) -> "Errors":
        """The same, weighted."""
        return Errors(factor * self.value, factor * self.jacobian, factor * self.bend)

    def __add__(self, other: "Errors") -> "Errors":
        return Errors(
            self.value + other.value, self.jacobian + other.jacobian, self.bend + other.bend
        )


def orientation_cost(s: SymbolicChain, R_desired: ca.SX) -> Terms:
    """|e|^2 [rad^2]."""
    sine_axis, cosine = _sine_axis(s, R_desired)
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
    """|x|^2 [m^2]."""
    x = s.position - x_desired
    error = position_error(s, x_desired, 2 * x)
    return Terms(ca.sumsqr(x), 2 * s.linear.T @ x, 2 * s.linear.T @ s.linear + error.bend)


def rest_cost(q: ca.SX, rest: ca.SX, weights: ca.SX) -> Terms:
    """Sum of w_i (q_rest_i - q_i)^2."""
    away = q - rest
    return Terms(ca.dot(weights, away * away), 2 * weights * away, 2 * ca.diag(weights))


def position_error(s: SymbolicChain, x_desired: ca.SX, y: ca.SX) -> Errors:
    """Of position: x [m]."""
    bend = ca.SX.zeros(s.q.numel(), s.q.numel())
    lever = [ca.cross(y, s.axes[:, j]) for j in range(s.q.numel())]
    for upper, i in enumerate(s.order):
        for j in s.order[: upper + 1]:
            bend[i, j] = bend[j, i] = ca.dot(lever[j], s.linear[:, i])
    return Errors(s.position - x_desired, s.linear, bend)


def orientation_error(s: SymbolicChain, R_desired: ca.SX, y: ca.SX) -> Errors:
    """Of orientation: v [rad, nearly]."""
    sine_axis, cosine = _sine_axis(s, R_desired)
    scalar = ca.fmax(ca.sqrt(ca.fmax(0.5 * (1 + cosine), 0)), HALF_TURN)
    v = sine_axis / scalar
    jacobian = ca.SX.zeros(3, s.q.numel())
    bend = ca.SX.zeros(s.q.numel(), s.q.numel())
    turned = 0.25 * ca.cross(v, y) + 0.5 * scalar * y  # y . (Q_0 c + c x v / 2) / 2 = c . turned
    along = 0.25 * ca.dot(y, v)
    for upper, i in enumerate(s.order):
        z = s.axes[:, i]
        jacobian[:, i] = scalar * z + 0.5 * ca.cross(z, v)
        for j in s.order[: upper + 1]:
            entry = -along * ca.dot(z, s.axes[:, j])
            if i != j:
                entry += ca.dot(ca.cross(s.axes[:, j], z), turned)
            bend[i, j] = bend[j, i] = entry
    return Errors(v, jacobian, bend)


def _sine_axis(s: SymbolicChain, R_desired: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Axis times sine, and cosine, of the turn R(q) R_d'."""
    M = s.rotation @ R_desired.T
    axis = 0.5 * ca.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1])
    return axis, 0.5 * (ca.trace(M) - 1)
