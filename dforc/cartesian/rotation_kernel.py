"""Errors of poses, for numba."""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled

SMALL = 1e-8
BEYOND_RAD = 2.0  # a rotation this large may be seen from its other side one period later

Rotations = NDArray[np.float64]  # (k, 3, 3)


@compiled
def turn_between(A: Matrix, B: Matrix, before: Vector, turn: Vector) -> None:
    """Rotation vector (3,) that turns B into A, base frame; near half a turn as `before`.

    Through the unit quaternion of A B', so that it stays exact near zero and near half a turn.
    """
    M = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            M[i, j] = A[i, 0] * B[j, 0] + A[i, 1] * B[j, 1] + A[i, 2] * B[j, 2]
    a, e, i9 = M[0, 0], M[1, 1], M[2, 2]
    x, y, z = M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]
    trace = a + e + i9
    if trace >= max(a, e, i9):
        w = 1.0 + trace
    elif a >= e and a >= i9:
        w, x, y, z = x, 1.0 + a - e - i9, M[0, 1] + M[1, 0], M[0, 2] + M[2, 0]
    elif e >= i9:
        w, x, y, z = y, M[0, 1] + M[1, 0], 1.0 - a + e - i9, M[1, 2] + M[2, 1]
    else:
        w, x, y, z = z, M[0, 2] + M[2, 0], M[1, 2] + M[2, 1], 1.0 - a - e + i9
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if w < 0.0:
        size = -size
    w, x, y, z = w / size, x / size, y / size, z / size
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(sine, w)
    factor = 2.0 if sine < SMALL else angle / sine
    if angle > BEYOND_RAD and x * before[0] + y * before[1] + z * before[2] < 0.0:
        factor = (angle - 2.0 * math.pi) / sine
    turn[0], turn[1], turn[2] = factor * x, factor * y, factor * z


@compiled
def pose_errors(
    position: Matrix,
    rotation: Rotations,
    to_position: Matrix,
    to_rotation: Rotations,
    before: Matrix,
    error: Matrix,
) -> None:
    """How far poses are from others: error (k, 6), linear [m], then the rotation vector [rad]."""
    for k in range(len(position)):
        for i in range(3):
            error[k, i] = position[k, i] - to_position[k, i]
        turn_between(rotation[k], to_rotation[k], before[k, 3:], error[k, 3:])


@compiled
def pose_misses(
    measured: Matrix,
    measured_rotation: Rotations,
    plan: Matrix,
    target: Matrix,
    target_rotation: Rotations,
    misses: Matrix,
) -> None:
    """Of each tip (k, 3): m and rad from the measured pose to the target's, m to the plan's."""
    turn, nowhere = np.empty(3), np.zeros(3)
    for k in range(len(measured)):
        away, beside, turned = 0.0, 0.0, 0.0
        turn_between(measured_rotation[k], target_rotation[k], nowhere, turn)
        for i in range(3):
            away += (measured[k, i] - target[k, i]) ** 2
            beside += (measured[k, i] - plan[k, i]) ** 2
            turned += turn[i] * turn[i]
        misses[k, 0], misses[k, 1] = math.sqrt(away), math.sqrt(turned)
        misses[k, 2] = math.sqrt(beside)
