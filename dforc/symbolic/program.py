"""Inverse kinematics (eq. 11) as one nonlinear program in CasADi that serves every request.

For any number of tips over the same joints, over z = (q, then u and s of each tip):

    minimise    sum over tips (a |x|^2 + b |e|^2) + sum_i w_i (c_i - q_i)^2
                + sum over tips (y . s + soft |s|^2)
    subject to  c x + d v = r u + s,  |u|^2 <= 1     per tip
                A q, q and h(q) between bounds

x is a tip's error of position [m], e its error of orientation [rad], v nearly the same as e
(dforc.symbolic.terms). With s = 0 this is eq. 11: |x| <= r, written so that the condition's
gradient does not vanish where it is met, as that of |x|^2 does. s gives the program an answer
wherever the target is: the nearest posture where it is out of reach, and next to nothing elsewhere;
y takes that rest away (method of multipliers). Everything a request may change is a parameter;
weights of zero switch a part off.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.robot_model import ChainElement
from dforc.symbolic.kinematics import symbolic_chain
from dforc.symbolic.terms import orientation_error, position_error

TIP = 23  # parameters of one tip
CONDITION = 4  # constraints of one tip: three equations and |u|^2


@runtime_checkable
class SymbolicConstraints(Protocol):
    """Inequalities h(q) >= 0 that can also be written out; the expression is asked for once."""

    size: int  # m

    def symbolic(self, q: ca.SX) -> ca.SX:
        """The values h (m, 1) at q (n, 1)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TipParameters:
    """What one tip is asked for."""

    position_m: Vector  # x_d (3,), of the frame to be placed
    rotation: Matrix  # R_d (3, 3), of the model's own tip
    offset_m: Vector  # (3,), of the frame to be placed, in the model's tip frame
    cost_position: float  # a
    cost_orientation: float  # b
    condition_position: float  # c
    condition_orientation: float  # d
    radius: float  # r, > 0
    pull: Vector  # y (3,)

    def values(self) -> Vector:
        """As the program takes them (TIP,)."""
        weights = (
            self.cost_position,
            self.cost_orientation,
            self.condition_position,
            self.condition_orientation,
            self.radius,
        )
        parts = (self.position_m, self.rotation.T.ravel(), self.offset_m, weights, self.pull)
        return np.concatenate(parts)


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """What a program is built for."""

    n: int  # joints
    chains: tuple[tuple[ChainElement, ...], ...]  # per tip
    row_pattern: NDArray[np.bool_]  # (m, n): where A is not zero
    extra: SymbolicConstraints | None


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """The program with its first and second derivatives, as expressions of z and p.

    g: CONDITION per tip, then A q, then h(q). p: TIP per tip, then c (n), w (n), soft, and A's
    entries in the order of the pattern.
    """

    z: ca.SX
    p: ca.SX
    f: ca.SX
    gradient: ca.SX
    g: ca.SX
    jacobian: ca.SX
    factor: ca.SX  # multiplier of f
    multipliers: ca.SX  # of g
    hessian: ca.SX  # of factor f + multipliers . g


@dataclass(frozen=True, slots=True, eq=False)
class _TipPart:
    """What one tip adds: to the cost and its gradient, conditions, and curvature by q."""

    cost: ca.SX
    gradient: ca.SX  # (n, 1)
    error: ca.SX  # (3, 1), that its condition is about
    jacobian: ca.SX  # of it (3, n)
    hessian: ca.SX  # (n, n)


def reaching_program(structure: Structure) -> Program:
    """Write it out."""
    n, k = structure.n, len(structure.chains)
    q, auxiliary = ca.SX.sym("q", n), ca.SX.sym("us", 6 * k)
    p = ca.SX.sym("p", TIP * k + 2 * n + 1 + int(structure.row_pattern.sum()))
    shared = p[TIP * k :]
    centre, weights, soft = shared[:n], shared[n : 2 * n], shared[2 * n]
    A = _rows(structure.row_pattern, shared[2 * n + 1 :])
    h = ca.SX(0, 1) if structure.extra is None else structure.extra.symbolic(q)
    factor = ca.SX.sym("lam_f")
    multipliers = ca.SX.sym("lam_g", CONDITION * k + A.shape[0] + h.numel())
    away = q - centre
    f, gradient = ca.dot(weights, away * away), 2 * weights * away
    hessian = 2 * factor * ca.diag(weights)
    hessian += ca.hessian(ca.dot(multipliers[CONDITION * k + A.shape[0] :], h), q)[0]
    g, jacobian, by_auxiliary, diagonal = [], [], [], []
    for tip, chain in enumerate(structure.chains):
        block, us = p[TIP * tip : TIP * (tip + 1)], auxiliary[6 * tip : 6 * (tip + 1)]
        u, s, radius, pull = us[:3], us[3:], block[19], block[20:]
        y = multipliers[CONDITION * tip : CONDITION * (tip + 1)]
        part = _tip(chain, q, block, factor, y[:3])
        f += part.cost + ca.dot(pull, s) + soft * ca.sumsqr(s)
        gradient += part.gradient
        hessian += part.hessian
        g += [part.error - radius * u - s, ca.sumsqr(u)]
        jacobian += _condition_jacobian(part.jacobian, u, radius, tip, k)
        by_auxiliary += [ca.SX.zeros(3), pull + 2 * soft * s]
        diagonal += [2 * y[3]] * 3 + [2 * soft * factor] * 3
    without = 6 * k
    linear = ca.horzcat(A, ca.SX(A.shape[0], without))
    bent = ca.horzcat(ca.jacobian(h, q), ca.SX(h.numel(), without))
    return Program(
        z=ca.vertcat(q, auxiliary),
        p=p,
        f=f,
        gradient=ca.vertcat(gradient, *by_auxiliary),
        g=ca.vertcat(*g, A @ q, h),
        jacobian=ca.vertcat(*jacobian, linear, bent),
        factor=factor,
        multipliers=multipliers,
        hessian=ca.diagcat(hessian, ca.diag(ca.vertcat(*diagonal))),
    )


def _tip(
    chain: tuple[ChainElement, ...], q: ca.SX, block: ca.SX, factor: ca.SX, y: ca.SX
) -> _TipPart:
    a, b, c, d = ca.vertsplit(block[15:19])
    s = symbolic_chain(chain, q.numel(), q, offset_m=block[12:15])
    x = position_error(s, block[:3], factor * a, c * y)
    e = orientation_error(s, ca.reshape(block[3:12], 3, 3), factor * b, d * y)
    return _TipPart(
        cost=a * x.squared + b * e.squared,
        gradient=a * x.gradient + b * e.gradient,
        error=c * x.vector + d * e.vector,
        jacobian=c * x.jacobian + d * e.jacobian,
        hessian=x.hessian + e.hessian,
    )


def _condition_jacobian(error: ca.SX, u: ca.SX, radius: ca.SX, tip: int, k: int) -> list[ca.SX]:
    """Rows of a tip's three equations and of its |u|^2, by z."""
    before, after = ca.SX(3, 6 * tip), ca.SX(3, 6 * (k - tip - 1))
    equations = ca.horzcat(error, before, -radius * ca.SX.eye(3), -ca.SX.eye(3), after)
    ball = ca.horzcat(ca.SX(1, error.shape[1]), before[0, :], 2 * u.T, ca.SX(1, 3), after[0, :])
    return [equations, ball]


def _rows(pattern: NDArray[np.bool_], entries: ca.SX) -> ca.SX:
    A = ca.SX(*pattern.shape)
    for entry, (row, joint) in enumerate(np.argwhere(pattern).tolist()):
        A[row, joint] = entries[entry]
    return A
