"""Rotations: vector (axis times angle, rad), matrix, unit quaternion (w, x, y, z).

`rotation_vector` goes through the quaternion, so it stays exact near zero and near half a turn.
"""

import math

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector
from dforc.errors import NotFiniteError

SMALL_RAD = 1e-8  # below it, sin(x)/x and its kin are at their limits to rounding


def matrix(rotation_rad: ArrayLike) -> Matrix:
    """Rotation matrix (3, 3) of a rotation vector (3,): Rodrigues' formula.

    Raises:
        NotFiniteError: NaN or infinity in the vector, or a length beyond any number.
    """
    x, y, z = (float(c) for c in rotation_rad)
    angle = math.sqrt(x * x + y * y + z * z)
    if not math.isfinite(angle):
        raise NotFiniteError(f"rotation vector is not finite: {(x, y, z)}")
    if angle < SMALL_RAD:
        s, c = 1.0, 0.5
    else:
        s = math.sin(angle) / angle
        half = math.sin(0.5 * angle) / angle
        c = 2.0 * half * half  # (1 - cos) / angle^2 without cancellation
    return np.array(
        [
            [1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)],
        ]
    )


def quaternion(R: Matrix) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a rotation matrix, w >= 0 (Shepperd's choice of divisor)."""
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    trace = a + e + i
    if trace >= max(a, e, i):
        q = (1.0 + trace, h - f, c - g, d - b)
    elif a >= e and a >= i:
        q = (h - f, 1.0 + a - e - i, b + d, c + g)
    elif e >= i:
        q = (c - g, b + d, 1.0 - a + e - i, f + h)
    else:
        q = (d - b, c + g, f + h, 1.0 - a - e + i)
    w, x, y, z = q
    scale = math.copysign(1.0 / math.sqrt(w * w + x * x + y * y + z * z), w)
    return w * scale, x * scale, y * scale, z * scale


def matrix_from_quaternion(q: ArrayLike) -> Matrix:
    """Rotation matrix (3, 3) of a quaternion (w, x, y, z) of any length but zero."""
    w, x, y, z = (float(c) for c in q)
    n = 2.0 / (w * w + x * x + y * y + z * z)
    return np.array(
        [
            [1.0 - n * (y * y + z * z), n * (x * y - w * z), n * (x * z + w * y)],
            [n * (x * y + w * z), 1.0 - n * (x * x + z * z), n * (y * z - w * x)],
            [n * (x * z - w * y), n * (y * z + w * x), 1.0 - n * (x * x + y * y)],
        ]
    )


def rotation_vector(R: Matrix) -> Vector:
    """Rotation vector (3,) of a rotation matrix, at most half a turn long."""
    w, x, y, z = quaternion(R)
    sine = math.sqrt(x * x + y * y + z * z)
    factor = 2.0 if sine < SMALL_RAD else 2.0 * math.atan2(sine, w) / sine
    return np.array([factor * x, factor * y, factor * z])


def rotation_error(R_from: Matrix, R_to: Matrix) -> Vector:
    """Rotation vector (3,), in the base frame, that turns R_from into R_to."""
    return rotation_vector(R_to @ R_from.T)


def angle_between(R_a: Matrix, R_b: Matrix) -> float:
    """Angle [rad] of the rotation from one orientation to the other."""
    w, x, y, z = quaternion(R_b @ R_a.T)
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), w)
