"""Eqs. 3 to 5 of DForC over arrays, and their integration, compiled.

The order of the operations is part of the contract: the same scene gives the same bits, compiled
or not, and a plain reference that keeps the order gives them too.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled


class Scene(NamedTuple):
    """What acts on the point, as arrays; `dforc.field.force.scene_of` makes and checks one."""

    targets_m: Matrix  # (t, 3)
    stiffness_n_m: Vector  # (t,)
    damping_ns_m: Vector  # (t,)
    centres_m: Matrix  # (m, 3)
    rotations: Matrix  # (m, 9) row by row; the columns are the ellipsoid's axes in the base
    reaches_m: Matrix  # (m, 3) semi-axes with the margin
    gains_n: Vector  # (m,)
    truncated: bool  # eq. 5; otherwise eq. 4


@compiled
def add_attraction(x: Vector, v: Vector, scene: Scene, force: Vector) -> None:
    """Add eq. 3 of every target to `force` (3,) [N]."""
    for i in range(len(scene.targets_m)):
        stiffness, damping = scene.stiffness_n_m[i], scene.damping_ns_m[i]
        for k in range(3):
            force[k] += stiffness * (scene.targets_m[i, k] - x[k]) - damping * v[k]


@compiled
def add_repulsion(x: Vector, scene: Scene, force: Vector) -> None:
    """Add eq. 5 (or 4) of every obstacle to `force` (3,) [N]; none at an obstacle's very centre."""
    for i in range(len(scene.centres_m)):
        dx = x[0] - scene.centres_m[i, 0]
        dy = x[1] - scene.centres_m[i, 1]
        dz = x[2] - scene.centres_m[i, 2]
        R = scene.rotations[i]
        a = (R[0] * dx + R[3] * dy + R[6] * dz) / scene.reaches_m[i, 0]
        b = (R[1] * dx + R[4] * dy + R[7] * dz) / scene.reaches_m[i, 1]
        c = (R[2] * dx + R[5] * dy + R[8] * dz) / scene.reaches_m[i, 2]
        q = a * a + b * b + c * c
        if scene.truncated and q > 1.0:
            continue
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        if distance == 0.0:
            continue
        scale = scene.gains_n[i] * math.exp(-q) / distance
        force[0] += scale * dx
        force[1] += scale * dy
        force[2] += scale * dz


@compiled
def advance(x: Vector, v: Vector, scene: Scene, dt_s: float, force: Vector) -> None:
    """Move a point of 1 kg by one period of semi-implicit Euler, in place; `force` is scratch."""
    for k in range(3):
        force[k] = 0.0
    add_attraction(x, v, scene, force)
    add_repulsion(x, scene, force)
    for k in range(3):
        v[k] += dt_s * force[k]
        x[k] += dt_s * v[k]


@compiled
def advance_many(
    positions: Matrix, velocities: Matrix, scene: Scene, dt_s: float, within_m: float
) -> int:
    """Fill row after row from the first; the number of rows used, fewer once at the targets.

    At the targets: within `within_m` of the first one, and slower than that per second.
    """
    x, v, force = positions[0].copy(), velocities[0].copy(), np.zeros(3)
    for row in range(1, len(positions)):
        advance(x, v, scene, dt_s, force)
        positions[row] = x
        velocities[row] = v
        if len(scene.targets_m) > 0:
            away = 0.0
            speed = 0.0
            for k in range(3):
                away += (scene.targets_m[0, k] - x[k]) ** 2
                speed += v[k] ** 2
            if max(away, speed) < within_m * within_m:
                return row + 1
    return len(positions)
