"""From any posture of a limb to one with its hands at their goals, clear of everything, for numba.

Gauss-Newton steps inside limits and rows, in a trust region. Positions weigh so much more than the
rest that nothing moves them noticeably; then nearness, orientations, and least the posture.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.cartesian.rotation_kernel import turn_between
from dforc.collision.kernel_body import proximities, tip_jacobian, tip_pose
from dforc.compiled import compiled
from dforc.ik.kernel_chain import Indices
from dforc.quadratic_kernel import solve_quadratic
from dforc.virtual_arm.kernel_edge import Scene
from dforc.virtual_arm.kernel_random import Room

POSITION_WEIGHT = 1e7  # 1/m^2
NEAR_WEIGHT = 1e6  # 1/m^2
TURN_WEIGHT = 1e3  # 1/rad^2
POSTURE_WEIGHT = 0.1  # 1/m^2, in the metric of postures

FIRST_TRUST_RAD, LARGEST_TRUST_RAD, LEAST_TRUST_RAD = 0.5, 0.8, 1e-3
WIDER, NARROWER = 2.0, 0.3
SETTLED_RAD = 1e-3
QP_ROOM_ROWS = 7


class Aim(NamedTuple):
    """Where the hands that have a goal are to be, base frame."""

    tips: Indices  # (t,) of the body
    positions: Matrix  # (t, 3)
    rotations: NDArray[np.float64]  # (t, 3, 3)
    turned: NDArray[np.bool_]  # (t,) whether the rotation matters


class Work(NamedTuple):
    """Scratch for n joints of N, r limits and rows, and k surfaces."""

    H: Matrix  # (n, n)
    g: Vector  # (n,)
    qp: Matrix  # (7 + 3 n, n)
    lower: Vector  # (r,)
    upper: Vector
    J: Matrix  # (6, N)
    rotation: Matrix  # (3, 3)
    position: Vector  # (3,)
    turn: Vector  # (3,)
    distances: Vector  # (k,)
    gradients: Matrix  # (k, N)
    drifts: Vector
    which: NDArray[np.int64]  # (k, 2)
    mask: NDArray[np.bool_]  # (c,) capsules that count against obstacles
    q: Vector  # (n,)
    trust: Vector  # (1,) rad: how far a step may move a joint


Errors = tuple[float, float, float]  # cost, largest position [m] and orientation error [rad]


@compiled
def add_row(H: Matrix, g: Vector, J: Vector, columns: Indices, weight: float, off: float) -> None:
    """Add weight / 2 (off + J dq)^2 to the quadratic model, lower triangle."""
    for i in range(len(columns)):
        scaled = weight * J[columns[i]]
        if scaled == 0.0:
            continue
        g[i] += scaled * off
        for j in range(i + 1):
            H[i, j] += scaled * J[columns[j]]


@compiled
def weigh_hands(scene: Scene, aim: Aim, work: Work) -> Errors:
    """The part of the hands, of a posture that is placed."""
    cost, far, turned = 0.0, 0.0, 0.0
    columns, nowhere = scene.moving.columns, np.zeros(3)
    for k in range(len(aim.tips)):
        flat = work.rotation.reshape(9)
        tip_pose(scene.body, aim.tips[k], scene.frames, flat, work.position)
        tip_jacobian(scene.body, aim.tips[k], scene.frames, work.J)
        square = 0.0
        for i in range(3):
            off = work.position[i] - aim.positions[k, i]
            square += off * off
            add_row(work.H, work.g, work.J[i], columns, POSITION_WEIGHT, off)
        cost += 0.5 * POSITION_WEIGHT * square
        far = max(far, math.sqrt(square))
        if aim.turned[k]:
            turn_between(work.rotation, aim.rotations[k], nowhere, work.turn)
            square = 0.0
            for i in range(3):
                square += work.turn[i] * work.turn[i]
                add_row(work.H, work.g, work.J[3 + i], columns, TURN_WEIGHT, work.turn[i])
            cost += 0.5 * TURN_WEIGHT * square
            turned = max(turned, math.sqrt(square))
    return cost, far, turned


@compiled
def weigh(
    q: Vector, reference: Vector, pull: float, scene: Scene, aim: Aim, nearness: Vector, work: Work
) -> Errors:
    """Cost of a posture; its quadratic model into H and g.

    Args:
        q: (n,).
        reference: posture that it is pulled to (n,), with the share `pull` of the usual weight.
        pull: see there.
        scene: the limb among obstacles.
        aim: of the hands.
        nearness: distances to keep from obstacles and between capsules [m] (2,).
        work: scratch.
    """
    moving, n = scene.moving, len(q)
    columns = moving.columns
    for j in range(n):
        scene.whole[columns[j]] = q[j]
    count = proximities(
        scene.whole,
        scene.body,
        scene.world,
        work.mask,
        nearness[0],
        nearness[1],
        scene.frames,
        scene.segments,
        work.distances,
        work.gradients,
        work.drifts,
        work.which,
    )
    cost = 0.0
    for i in range(n):
        for j in range(i):
            work.H[i, j] = 0.0
        weight = pull * POSTURE_WEIGHT * moving.metric[i] * moving.metric[i]
        away = q[i] - reference[i]
        work.H[i, i], work.g[i] = weight, weight * away
        cost += 0.5 * weight * away * away
    for k in range(count):
        kept = nearness[0] if work.which[k, 1] >= 0 else nearness[1]
        off = work.distances[k] - kept
        cost += 0.5 * NEAR_WEIGHT * off * off
        add_row(work.H, work.g, work.gradients[k], columns, NEAR_WEIGHT, off)
    hands, far, turned = weigh_hands(scene, aim, work)
    return cost + hands, far, turned


@compiled
def step_from(q: Vector, trust: float, room: Room, work: Work) -> bool:
    """The posture one step from q into work.q; False if there is none."""
    n = len(q)
    for i in range(len(room.lower)):
        value = 0.0
        for j in range(n):
            value += room.C[i, j] * q[j]
        work.lower[i] = min(room.lower[i] - value, 0.0)
        work.upper[i] = max(room.upper[i] - value, 0.0)
        if i < n:
            work.lower[i] = max(work.lower[i], -trust)
            work.upper[i] = min(work.upper[i], trust)
    if solve_quadratic(work.H, work.g, room.C, work.lower, work.upper, work.qp) < 0:
        return False
    for j in range(n):
        work.q[j] = min(max(q[j] + work.qp[0, j], room.lower[j]), room.upper[j])
    return True


@compiled
def approach(
    q: Vector,
    reference: Vector,
    pull: float,
    scene: Scene,
    room: Room,
    aim: Aim,
    nearness: Vector,
    work: Work,
    most_steps: int,
) -> tuple[float, float, int]:
    """From q, inside limits and rows, towards a posture nearby that costs least, in place.

    Returns its largest position [m] and orientation error [rad], and the steps taken: fewer than
    it may take once it is there. It begins with, and leaves, the trust that is in `work`.
    """
    n, trust, steps = len(q), work.trust[0], 0
    cost, far, turned = weigh(q, reference, pull, scene, aim, nearness, work)
    while steps < most_steps and trust > LEAST_TRUST_RAD:
        if not step_from(q, trust, room, work):
            break
        steps += 1
        longest = 0.0
        for j in range(n):
            longest = max(longest, abs(work.q[j] - q[j]))
        there, far_there, turned_there = weigh(work.q, reference, pull, scene, aim, nearness, work)
        if there <= cost:
            settled = longest <= SETTLED_RAD
            q[:] = work.q
            cost, far, turned = there, far_there, turned_there
            trust = min(WIDER * trust, LARGEST_TRUST_RAD)
            if settled:
                break
        else:
            trust = NARROWER * min(trust, longest)
            weigh(q, reference, pull, scene, aim, nearness, work)
    work.trust[0] = trust
    return far, turned, steps
