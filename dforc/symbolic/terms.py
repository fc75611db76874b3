"""Errors of a hand's pose as CasADi expressions with written-out derivatives.

These come from the geometry of the chain, not from differentiation of the code, which gave a
Hessian five times as long. With e the rotation vector of R(q) R_d' in the base frame, Q its unit
quaternion (Q_0 the scalar part), v = 2 (Q_1, Q_2, Q_3), x = p(q) - x_d, l_i = z_i x (p - o_i), and
j at or below i in the chain:

    de    = Jl^-1(e) J_w dq                                        (left Jacobian of SO(3))
    H(|e|^2)_ij = 2 z_i' S z_j + e . c,  S = k I + b e e',  c = z_j x z_i
    H(|x|^2)_ij = 2 l_i . l_j + 2 x . (z_j x l_i),  H(y . x)_ij = y . (z_j x l_i)
    dv_i        = Q_0 z_i + z_i x v / 2
    H(y . v)_ij = c . (Q_0 y / 2 + v x y / 4) - (z_i . z_j) (y . v) / 4

where k = (|e|/2) cot(|e|/2) and b = (1 - k) / |e|^2. |v| = 2 sin(|e|/2) grows with |e| up to half
a turn and, unlike e, is smooth on the way: it stands for the orientation in conditions.
"""

from dataclasses import dataclass

import casadi as ca

from dforc.symbolic.kinematics import SymbolicChain

SMALL = 1e-7  # rad; below it the series of k and b are exact to rounding
HALF_TURN = 1e-6  # smallest Q_0: half a turn, where v has no direction


@dataclass(frozen=True, slots=True, eq=False)
class PoseError:
    """The position's or the orientation's, both as a cost and as a vector."""

    squared: ca.SX  # |x|^2 or |e|^2
    gradient: ca.SX  # of it (n, 1)
    vector: ca.SX  # x or v (3, 1)
    jacobian: ca.SX  # of it (3, n)
    hessian: ca.SX  # of weight times squared, plus y . vector (n, n)


def position_error(s: SymbolicChain, x_desired: ca.SX, weight: ca.SX, y: ca.SX) -> PoseError:
    """In m, with its Hessian for a weight and y (3, 1)."""
    x, n = s.position - x_desired, s.q.numel()
    force = 2 * weight * x + y
    lever = [ca.cross(force, s.axes[:, j]) for j in range(n)]
    hessian = 2 * weight * s.linear.T @ s.linear
    for upper, i in enumerate(s.order):
        for j in s.order[: upper + 1]:
            entry = hessian[i, j] + ca.dot(lever[j], s.linear[:, i])
            hessian[i, j] = hessian[j, i] = entry
    return PoseError(ca.sumsqr(x), 2 * s.linear.T @ x, x, s.linear, hessian)


def orientation_error(s: SymbolicChain, R_desired: ca.SX, weight: ca.SX, y: ca.SX) -> PoseError:
    """In rad, with its Hessian for a weight and y (3, 1)."""
    M, n = s.rotation @ R_desired.T, s.q.numel()
    sine_axis = 0.5 * ca.vertcat(M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1])
    cosine = 0.5 * (ca.trace(M) - 1)
    sine = ca.sqrt(ca.sumsqr(sine_axis))
    angle = ca.atan2(sine, cosine)
    small = sine < SMALL
    ratio = ca.if_else(ca.logic_and(small, cosine > 0), 1, angle / ca.fmax(sine, SMALL))
    e = ratio * sine_axis
    k = 0.5 * ratio * (1 + cosine)
    b = ca.if_else(angle < 1e-3, 1 / 12, (1 - k) / ca.fmax(angle * angle, 1e-6))
    scalar = ca.fmax(ca.sqrt(ca.fmax(0.5 * (1 + cosine), 0)), HALF_TURN)
    v = sine_axis / scalar
    about = weight * e + 0.5 * scalar * y + 0.25 * ca.cross(v, y)
    along = 2 * weight * k - 0.25 * ca.dot(y, v)
    turned = along * s.axes + 2 * weight * b * e @ (e.T @ s.axes)
    jacobian, hessian = ca.SX.zeros(3, n), ca.SX.zeros(n, n)
    for upper, i in enumerate(s.order):
        z = s.axes[:, i]
        jacobian[:, i] = scalar * z + 0.5 * ca.cross(z, v)
        lever = ca.cross(z, about)
        for j in s.order[: upper + 1]:
            entry = ca.dot(z, turned[:, j])
            if i != j:
                entry += ca.dot(s.axes[:, j], lever)
            hessian[i, j] = hessian[j, i] = entry
    return PoseError(angle * angle, 2 * s.axes.T @ e, v, jacobian, hessian)
