"""Where the body is, how near it is to obstacles and to itself, and how that changes, for numba.

The gradient of a distance over the joints: the nearest point moves with the joints below it, and
only its motion along the normal counts. How the nearest point wanders over capsule and obstacle
does not change the distance to first order.
"""

import math

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.collision.body import BodyArrays
from dforc.collision.kernel_nearness import (
    add_motion,
    apart,
    axes_bound,
    ball_bound,
    normal_between,
    point_on,
    row_for,
)
from dforc.collision.kernel_shapes import nearest_on
from dforc.collision.obstacles import World
from dforc.compiled import compiled

Mask = NDArray[np.bool_]
Which = NDArray[np.int64]


@compiled
def place_body(q: Vector, body: BodyArrays, frames: Matrix, segments: Matrix) -> None:
    """Frames (N, 12) of the joints (rotation by rows, origin) and axes (c, 6) of the capsules."""
    t, p = body.turns, body.places
    for j in range(len(body.parents)):
        parent = body.parents[j]
        a, b, c, x = 1.0, 0.0, 0.0, 0.0
        d, e, f, y = 0.0, 1.0, 0.0, 0.0
        g, h, i, z = 0.0, 0.0, 1.0, 0.0
        if parent >= 0:
            a, b, c, x = frames[parent, 0], frames[parent, 1], frames[parent, 2], frames[parent, 9]
            d, e, f, y = frames[parent, 3], frames[parent, 4], frames[parent, 5], frames[parent, 10]
            g, h, i, z = frames[parent, 6], frames[parent, 7], frames[parent, 8], frames[parent, 11]
        px, py, pz = p[j, 0], p[j, 1], p[j, 2]
        frames[j, 9] = x + a * px + b * py + c * pz
        frames[j, 10] = y + d * px + e * py + f * pz
        frames[j, 11] = z + g * px + h * py + i * pz
        cosine, sine = math.cos(q[j]), math.sin(q[j])
        # The joint's turn about z mixes the first two columns of its rotation at zero.
        ux = t[j, 0] * cosine + t[j, 1] * sine
        uy = t[j, 3] * cosine + t[j, 4] * sine
        uz = t[j, 6] * cosine + t[j, 7] * sine
        vx = t[j, 1] * cosine - t[j, 0] * sine
        vy = t[j, 4] * cosine - t[j, 3] * sine
        vz = t[j, 7] * cosine - t[j, 6] * sine
        wx, wy, wz = t[j, 2], t[j, 5], t[j, 8]
        frames[j, 0] = a * ux + b * uy + c * uz
        frames[j, 1] = a * vx + b * vy + c * vz
        frames[j, 2] = a * wx + b * wy + c * wz
        frames[j, 3] = d * ux + e * uy + f * uz
        frames[j, 4] = d * vx + e * vy + f * vz
        frames[j, 5] = d * wx + e * wy + f * wz
        frames[j, 6] = g * ux + h * uy + i * uz
        frames[j, 7] = g * vx + h * vy + i * vz
        frames[j, 8] = g * wx + h * wy + i * wz
    for k in range(len(body.carriers)):
        _carry(body.carriers[k], frames, body.starts, k, segments, 0)
        _carry(body.carriers[k], frames, body.ends, k, segments, 3)


@compiled
def _carry(carrier: int, frames: Matrix, points: Matrix, k: int, out: Matrix, at: int) -> None:
    x, y, z = points[k, 0], points[k, 1], points[k, 2]
    if carrier < 0:
        out[k, at], out[k, at + 1], out[k, at + 2] = x, y, z
        return
    f = carrier
    out[k, at] = frames[f, 9] + frames[f, 0] * x + frames[f, 1] * y + frames[f, 2] * z
    out[k, at + 1] = frames[f, 10] + frames[f, 3] * x + frames[f, 4] * y + frames[f, 5] * z
    out[k, at + 2] = frames[f, 11] + frames[f, 6] * x + frames[f, 7] * y + frames[f, 8] * z


@compiled
def tip_pose(body: BodyArrays, tip: int, frames: Matrix, R_out: Vector, p_out: Vector) -> None:
    """Rotation (9,) by rows and position (3,) of a tip, from placed frames."""
    carrier = body.tip_carriers[tip]
    t, p = body.tip_turns, body.tip_places
    for row in range(3):
        a, b, c, x = 0.0, 0.0, 0.0, 0.0
        if carrier < 0:
            a = 1.0 if row == 0 else 0.0
            b = 1.0 if row == 1 else 0.0
            c = 1.0 if row == 2 else 0.0
        else:
            a, b, c = (
                frames[carrier, 3 * row],
                frames[carrier, 3 * row + 1],
                frames[carrier, 3 * row + 2],
            )
            x = frames[carrier, 9 + row]
        for column in range(3):
            R_out[3 * row + column] = (
                a * t[tip, column] + b * t[tip, 3 + column] + c * t[tip, 6 + column]
            )
        p_out[row] = x + a * p[tip, 0] + b * p[tip, 1] + c * p[tip, 2]


@compiled
def tip_jacobian(body: BodyArrays, tip: int, frames: Matrix, J_out: Matrix) -> None:
    """Geometric Jacobian (6, N) of a tip: linear rows, then angular, in the base's axes."""
    J_out[:, :] = 0.0
    joint = body.tip_carriers[tip]
    p = body.tip_places
    x, y, z = p[tip, 0], p[tip, 1], p[tip, 2]
    if joint >= 0:
        f = frames[joint]
        x, y, z = (
            f[9] + f[0] * x + f[1] * y + f[2] * z,
            f[10] + f[3] * x + f[4] * y + f[5] * z,
            f[11] + f[6] * x + f[7] * y + f[8] * z,
        )
    while joint >= 0:
        ax, ay, az = frames[joint, 2], frames[joint, 5], frames[joint, 8]
        rx, ry, rz = x - frames[joint, 9], y - frames[joint, 10], z - frames[joint, 11]
        J_out[0, joint] = ay * rz - az * ry
        J_out[1, joint] = az * rx - ax * rz
        J_out[2, joint] = ax * ry - ay * rx
        J_out[3, joint], J_out[4, joint], J_out[5, joint] = ax, ay, az
        joint = body.parents[joint]


@compiled
def clearance(
    q: Vector,
    body: BodyArrays,
    world: World,
    mask: Mask,
    frames: Matrix,
    segments: Matrix,
    margin: float,
    self_margin: float,
    stop_below: float,
) -> float:
    """Smallest of all distances [m] less what they have to be; once below `stop_below` any of them.

    Of the capsules in `mask` (c,) from the obstacles and their margins, less `margin`; of the pairs
    of capsules, less `self_margin`. inf where there is nothing to be near to.
    """
    place_body(q, body, frames, segments)
    least: float = math.inf
    radii, pairs = body.radii, body.pairs
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        reach = radii[i] + radii[j] + self_margin
        if axes_bound(body, segments, i, j) - reach < least:
            far, _, _ = apart(segments, i, j)
            least = min(least, far - reach)
            if least < stop_below:
                return least
    for o in range(len(world.kinds)):
        for i in range(len(radii)):
            if not mask[i]:
                continue
            reach = radii[i] + world.margins[o] + margin
            if ball_bound(segments, i, world, o) - reach < least:
                far, _, _, _, _ = nearest_on(o, world, segments[i], least + reach)
                least = min(least, far - reach)
                if least < stop_below:
                    return least
    return least


@compiled
def proximities(
    q: Vector,
    body: BodyArrays,
    world: World,
    mask: Mask,
    reach_m: float,
    self_reach_m: float,
    frames: Matrix,
    segments: Matrix,
    distances: Vector,
    gradients: Matrix,
    drifts: Vector,
    which: Which,
) -> int:
    """Everything nearer than `reach_m` (obstacles) or `self_reach_m` (itself): how many.

    Fills, for each: the distance of the surfaces [m], obstacles with their own margin; its gradient
    over all N joints; its rate from the obstacle's own velocity [m/s]; (capsule, obstacle), or
    (capsule, -1 - other capsule). If there are more than rows, the nearest are kept.
    """
    place_body(q, body, frames, segments)
    count, rows = 0, len(distances)
    radii, pairs = body.radii, body.pairs
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        reach = radii[i] + radii[j]
        if axes_bound(body, segments, i, j) - reach >= self_reach_m:
            continue
        far, s, t = apart(segments, i, j)
        if far - reach >= self_reach_m:
            continue
        row = row_for(far - reach, distances, count)
        if row < 0:
            continue
        count = min(count + 1, rows)
        distances[row], drifts[row] = far - reach, 0.0
        which[row, 0], which[row, 1] = i, -1 - j
        x, y, z = point_on(segments, i, s)
        u, v, w = point_on(segments, j, t)
        nx, ny, nz = normal_between(x - u, y - v, z - w, far, segments, i, j)
        gradients[row, :] = 0.0
        add_motion(body, body.carriers[i], frames, x, y, z, nx, ny, nz, gradients, row)
        add_motion(body, body.carriers[j], frames, u, v, w, -nx, -ny, -nz, gradients, row)
    for o in range(len(world.kinds)):
        for i in range(len(radii)):
            reach = radii[i] + world.margins[o]
            if not mask[i] or ball_bound(segments, i, world, o) - reach >= reach_m:
                continue
            far, s, nx, ny, nz = nearest_on(o, world, segments[i], reach_m + reach)
            if far - reach >= reach_m:
                continue
            row = row_for(far - reach, distances, count)
            if row < 0:
                continue
            count = min(count + 1, rows)
            v_out = world.velocities
            distances[row] = far - reach
            drifts[row] = -(nx * v_out[o, 0] + ny * v_out[o, 1] + nz * v_out[o, 2])
            which[row, 0], which[row, 1] = i, o
            x, y, z = point_on(segments, i, s)
            gradients[row, :] = 0.0
            add_motion(body, body.carriers[i], frames, x, y, z, nx, ny, nz, gradients, row)
    return count
