"""Forward kinematics of a serial chain, for numba: pose of the tip, and geometry of its joints.

A chain is turned so that every joint axis is the z axis of its own frame; `chain_arrays` does that
once, and then one joint costs a product of two rotations and a turn of two columns.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.robot_model import ChainElement

Indices = NDArray[np.int64]


class ChainArrays(NamedTuple):
    """One chain from the base to its tip."""

    joints: Indices  # (k,) into the joint vector, base first
    turns: Matrix  # (k + 1, 9) rotation of each joint's frame in the one before, by rows; the tip
    places: Matrix  # (k + 1, 3) and its origin


def chain_arrays(chain: Sequence[ChainElement]) -> ChainArrays:
    """The chain of a model, as the compiled functions want it."""
    joints, turns, places = [], [], []
    turned = np.eye(3)  # of the frame kept here against the model's
    for element in chain:
        align = np.eye(3) if element.joint < 0 else rotation_onto(element.axis)
        turns.append((turned.T @ element.R @ align).ravel())
        places.append(turned.T @ element.p)
        turned = align
        if element.joint >= 0:
            joints.append(element.joint)
    return ChainArrays(np.array(joints, dtype=np.int64), np.array(turns), np.array(places))


def rotation_onto(axis: Vector) -> Matrix:
    """A rotation (3, 3) whose third column is the unit vector `axis`."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


@compiled
def place_chain(
    q: Vector, joints: Indices, turns: Matrix, places: Matrix, axes: Matrix, origins: Matrix
) -> None:
    """Axis and origin of every joint, (k + 1, 3) each; behind the joints' the tip's position.

    The tip's rotation comes behind its position: three more rows of `origins` (k + 4, 3).
    """
    k = len(joints)
    a, b, c = 1.0, 0.0, 0.0
    d, e, f = 0.0, 1.0, 0.0
    g, h, i = 0.0, 0.0, 1.0
    x, y, z = 0.0, 0.0, 0.0
    for j in range(k + 1):
        t, p = turns[j], places[j]
        x += a * p[0] + b * p[1] + c * p[2]
        y += d * p[0] + e * p[1] + f * p[2]
        z += g * p[0] + h * p[1] + i * p[2]
        a, b, c = (
            a * t[0] + b * t[3] + c * t[6],
            a * t[1] + b * t[4] + c * t[7],
            a * t[2] + b * t[5] + c * t[8],
        )
        d, e, f = (
            d * t[0] + e * t[3] + f * t[6],
            d * t[1] + e * t[4] + f * t[7],
            d * t[2] + e * t[5] + f * t[8],
        )
        g, h, i = (
            g * t[0] + h * t[3] + i * t[6],
            g * t[1] + h * t[4] + i * t[7],
            g * t[2] + h * t[5] + i * t[8],
        )
        origins[j, 0], origins[j, 1], origins[j, 2] = x, y, z
        if j < k:
            axes[j, 0], axes[j, 1], axes[j, 2] = c, f, i
            angle = q[joints[j]]
            cosine, sine = math.cos(angle), math.sin(angle)
            a, b = a * cosine + b * sine, b * cosine - a * sine
            d, e = d * cosine + e * sine, e * cosine - d * sine
            g, h = g * cosine + h * sine, h * cosine - g * sine
    origins[k + 1, 0], origins[k + 1, 1], origins[k + 1, 2] = a, b, c
    origins[k + 2, 0], origins[k + 2, 1], origins[k + 2, 2] = d, e, f
    origins[k + 3, 0], origins[k + 3, 1], origins[k + 3, 2] = g, h, i
