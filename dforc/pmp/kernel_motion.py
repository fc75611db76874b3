"""One period of PMP's virtual arm, compiled (Table I, eqs. 6 to 10)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.cartesian.rotation_kernel import turn_between
from dforc.compiled import compiled
from dforc.field.kernel_force import Scene, add_repulsion
from dforc.ik.kernel_chain import ChainArrays, place_chain
from dforc.pmp.fields import limit_field, time_base

NOT_TURNED, RAW, LOGARITHM = 0, 1, 2
SMALL_RAD = 1e-12

Rotations = NDArray[np.float64]  # (k, 3, 3)


class ArmConstants(NamedTuple):
    """What stays the same from step to step."""

    lower_rad: Vector  # (n,)
    upper_rad: Vector
    limit_gain_nm: Vector  # (n,)
    admittance_rad_nms: Vector  # (n,)
    stiffness_n_m: float
    angular_stiffness_nm_rad: float
    has_time_base: bool
    duration_s: float
    epsilon: float
    clamped: bool
    integrates: bool  # variant A


class Pull(NamedTuple):
    """Where the hand is drawn to; `turned` is one of the three numbers above."""

    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)
    turned: int


@compiled
def place_tip(q: Vector, chain: ChainArrays, x: Vector, R: Matrix) -> None:
    """Position (3,) and rotation (3, 3) of the tip."""
    k = len(chain.joints)
    axes, origins = np.empty((k + 1, 3)), np.empty((k + 4, 3))
    place_chain(q, chain.joints, chain.turns, chain.places, axes, origins)
    x[:] = origins[k]
    R[:] = origins[k + 1 :]


@compiled
def add_turn(R: Matrix, pull: Pull, stiffness: float, torque: Vector) -> None:
    """Add the torque (3,) that draws the hand's rotation to the target's."""
    nothing, turn = np.zeros(3), np.empty(3)
    if pull.turned == LOGARITHM:
        turn_between(pull.rotation, R, nothing, turn)
        for i in range(3):
            torque[i] += stiffness * turn[i]
    elif pull.turned == RAW:
        level = np.eye(3)
        turn_between(pull.rotation, level, nothing, turn)
        for i in range(3):
            torque[i] += stiffness * turn[i]
        turn_between(R, level, nothing, turn)
        for i in range(3):
            torque[i] -= stiffness * turn[i]


@compiled
def turn_by(rotation_rad: Vector, R: Matrix) -> None:
    """Turn R (3, 3) by a rotation vector (3,) of the base frame, in place."""
    angle = np.sqrt(np.sum(rotation_rad * rotation_rad))
    if angle < SMALL_RAD:
        return
    x, y, z = rotation_rad[0] / angle, rotation_rad[1] / angle, rotation_rad[2] / angle
    s, half = np.sin(angle), np.sin(0.5 * angle)
    c = 2.0 * half * half
    for j in range(3):
        a, b, d = R[0, j], R[1, j], R[2, j]
        u, v, w = y * d - z * b, z * a - x * d, x * b - y * a
        R[0, j] = a + s * u + c * (y * w - z * v)
        R[1, j] = b + s * v + c * (z * u - x * w)
        R[2, j] = d + s * w + c * (x * v - y * u)


@compiled
def move(
    q: Vector,
    dq: Vector,
    x: Vector,
    R: Matrix,
    time_s: float,
    pull: Pull,
    obstacles: Scene,
    chain: ChainArrays,
    arm: ArmConstants,
    dt_s: float,
) -> None:
    """One period of explicit Euler: q (n,), dq (n,), x (3,) and R (3, 3) in place."""
    k = len(chain.joints)
    axes, origins = np.empty((k + 1, 3)), np.empty((k + 4, 3))
    place_chain(q, chain.joints, chain.turns, chain.places, axes, origins)
    force, torque = np.zeros(3), np.zeros(3)
    for i in range(3):
        force[i] = arm.stiffness_n_m * (pull.position_m[i] - x[i])
    add_repulsion(x, obstacles, force)
    add_turn(R, pull, arm.angular_stiffness_nm_rad, torque)
    gain = time_base(time_s, arm.duration_s, arm.epsilon) if arm.has_time_base else 1.0
    dq[:] = arm.limit_gain_nm * limit_field(q, arm.lower_rad, arm.upper_rad)
    columns = np.empty((k, 3))  # linear rows of the Jacobian, transposed
    for j in range(k):
        a, r = axes[j], origins[k] - origins[j]
        columns[j, 0] = a[1] * r[2] - a[2] * r[1]
        columns[j, 1] = a[2] * r[0] - a[0] * r[2]
        columns[j, 2] = a[0] * r[1] - a[1] * r[0]
        for i in range(3):
            dq[chain.joints[j]] += columns[j, i] * force[i] + a[i] * torque[i]
    for joint in range(len(q)):
        dq[joint] *= gain * arm.admittance_rad_nms[joint]
        wanted = q[joint] + dt_s * dq[joint]
        if arm.clamped and not arm.lower_rad[joint] <= wanted <= arm.upper_rad[joint]:
            wanted = min(max(wanted, arm.lower_rad[joint]), arm.upper_rad[joint])
            dq[joint] = (wanted - q[joint]) / dt_s
        q[joint] = wanted
    if not arm.integrates:
        place_tip(q, chain, x, R)
        return
    turned = np.zeros(3)
    for j in range(k):
        way = dt_s * dq[chain.joints[j]]
        for i in range(3):
            x[i] += way * columns[j, i]
            turned[i] += way * axes[j, i]
    turn_by(turned, R)


@compiled
def move_many(
    q: Matrix,
    x: Matrix,
    R: Rotations,
    time_s: float,
    pull: Pull,
    obstacles: Scene,
    chain: ChainArrays,
    arm: ArmConstants,
    dt_s: float,
) -> None:
    """Fill row after row from the first: q (k, n), x (k, 3), R (k, 3, 3)."""
    dq = np.zeros(q.shape[1])
    for row in range(1, len(q)):
        q[row], x[row], R[row] = q[row - 1], x[row - 1], R[row - 1]
        move(q[row], dq, x[row], R[row], time_s, pull, obstacles, chain, arm, dt_s)
        time_s += dt_s
