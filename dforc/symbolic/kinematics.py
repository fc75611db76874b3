"""Kinematics of a serial chain as CasADi expressions, from the placements and axes of the model.

The pip wheel of pinocchio has no CasADi scalars, so the few products are written out here. SX, not
MX: the expressions are small and evaluated often (MX was measured several times slower).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from dforc.arrays import Matrix
from dforc.ik.kernel_chain import rotation_onto
from dforc.robot_model import ChainElement


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicChain:
    """Pose of the tip and geometry of the joints as functions of q, base frame."""

    q: ca.SX  # (n, 1)
    rotation: ca.SX  # (3, 3) of the tip
    position: ca.SX  # (3, 1) of the tip, m
    axes: ca.SX  # (3, n): z_i, unit axis of joint i; zero where a joint is not in the chain
    linear: ca.SX  # (3, n): z_i x (p - o_i), linear rows of the geometric Jacobian
    order: tuple[int, ...]  # joint indices from the base to the tip


def symbolic_chain(
    chain: Sequence[ChainElement], n: int, q: ca.SX | None = None, offset_m: ca.SX | None = None
) -> SymbolicChain:
    """Expressions for `RobotModel.chain_description()` of a model with n joints.

    Args:
        chain: from the base to the tip.
        n: joints of the model.
        q: the joints' angles (n, 1) where they are shared with another chain.
        offset_m: of another point to be placed, in the tip frame (3, 1).
    """
    q = ca.SX.sym("q", n) if q is None else q
    R, p = ca.SX.eye(3), ca.SX.zeros(3, 1)
    frames: list[tuple[int, ca.SX, ca.SX]] = []  # joint, axis, origin
    turned = np.eye(3)  # of the frame kept here against the model's: puts each axis on z
    for element in chain:
        p = p + R @ _constant(turned.T @ element.p)
        if element.joint < 0:
            R = R @ _constant(turned.T @ element.R)
            p = p if offset_m is None else p + R @ offset_m
            break
        align = rotation_onto(element.axis)
        R = R @ _constant(turned.T @ element.R @ align)
        frames.append((element.joint, R[:, 2], p))
        R = _turn_about_z(R, q[element.joint])
        turned = align
    axes, linear = ca.SX.zeros(3, n), ca.SX.zeros(3, n)
    for joint, axis, origin in frames:
        axes[:, joint] = axis
        linear[:, joint] = ca.cross(axis, p - origin)
    return SymbolicChain(q, R, p, axes, linear, tuple(joint for joint, _, _ in frames))


def _turn_about_z(R: ca.SX, angle: ca.SX) -> ca.SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.horzcat(R[:, 0] * c + R[:, 1] * s, R[:, 1] * c - R[:, 0] * s, R[:, 2])


def _constant(values: Matrix) -> ca.DM:
    """Zeros and ones exact where rounding left 1e-17 beside them: they leave the expression."""
    rounded = np.round(values)
    return ca.DM(np.where(np.abs(values - rounded) < 1e-15, rounded, values))
