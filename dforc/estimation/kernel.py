"""One estimate in one pass over the tree, for numba: loops over flat tables, no allocation.

All vectors are in base axes and all moments about the base's origin, so that wrenches of bodies,
sub-trees and sub-models are plain sums (eqs. 8 to 10 of the force control paper, with the moment
taken about one point). The base accelerates with minus gravity, so gravity needs no term of its
own. The order of the tables is that of tables.py. A body's row holds its constants and, behind
them, room: motion (MOVE: omega, alpha, acceleration), wrench needed (NEED) and given (GIVEN).
A pose is three columns of a rotation and an origin, as pinocchio keeps it.
"""

import math

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.plan import GRAVITY_M_S2
from dforc.estimation.tree_model import Places

MOVE, NEED, GIVEN = 43, 52, 58


@compiled
def turned(pose: Vector, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of a body in base axes."""
    return (
        pose[0] * x + pose[3] * y + pose[6] * z,
        pose[1] * x + pose[4] * y + pose[7] * z,
        pose[2] * x + pose[5] * y + pose[8] * z,
    )


@compiled
def turned_back(pose: Vector, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector in base axes in a body's own."""
    return (
        pose[0] * x + pose[1] * y + pose[2] * z,
        pose[3] * x + pose[4] * y + pose[5] * z,
        pose[6] * x + pose[7] * y + pose[8] * z,
    )


@compiled
def place(q: Vector, links: Places, bodies: Matrix, poses: Matrix) -> None:
    """Rotation and origin of every body in the base."""
    for k in range(12):
        poses[0, k] = 1.0 if k == 0 or k == 4 or k == 8 else 0.0
    for i in range(1, bodies.shape[0]):
        sine, cosine, j = 0.0, 1.0, links[i, 1]
        if j >= 0:
            sine, cosine = math.sin(q[j]), math.cos(q[j])
        row, above, pose = bodies[i], poses[links[i, 0]], poses[i]
        for k in range(3):
            x = row[k] + sine * row[9 + k] + cosine * row[18 + k]
            y = row[3 + k] + sine * row[12 + k] + cosine * row[21 + k]
            z = row[6 + k] + sine * row[15 + k] + cosine * row[24 + k]
            pose[3 * k], pose[3 * k + 1], pose[3 * k + 2] = turned(above, x, y, z)
        x, y, z = turned(above, row[27], row[28], row[29])
        pose[9], pose[10], pose[11] = above[9] + x, above[10] + y, above[11] + z


@compiled
def carried(
    ax: float,
    ay: float,
    az: float,
    wx: float,
    wy: float,
    wz: float,
    rx: float,
    ry: float,
    rz: float,
) -> tuple[float, float, float]:
    """What a lever r adds to an acceleration: alpha x r + omega x (omega x r)."""
    ux, uy, uz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx
    return (
        ay * rz - az * ry + wy * uz - wz * uy,
        az * rx - ax * rz + wz * ux - wx * uz,
        ax * ry - ay * rx + wx * uy - wy * ux,
    )


@compiled
def base_motion(
    source: Vector,
    body: int,
    rates: tuple[Vector, Vector],
    tree: tuple[Places, Matrix, Matrix],
) -> None:
    """Motion of the base: none, or from the source inwards along its supports (eq. 8, reversed).

    `source` is the rotation (9) and the origin (3) of the source on its body, and its motion (9).
    """
    links, bodies, poses = tree
    dq, ddq = rates
    base = bodies[0, MOVE:NEED]
    for k in range(9):
        base[k] = 0.0
    base[8] = GRAVITY_M_S2
    if body < 0:
        return
    pose, motion = poses[body], source[12:]
    lx, ly, lz = turned(source, motion[0], motion[1], motion[2])
    wx, wy, wz = turned(pose, lx, ly, lz)
    lx, ly, lz = turned(source, motion[3], motion[4], motion[5])
    ax, ay, az = turned(pose, lx, ly, lz)
    lx, ly, lz = turned(source, motion[6], motion[7], motion[8])
    vx, vy, vz = turned(pose, lx, ly, lz)
    rx, ry, rz = turned(pose, source[9], source[10], source[11])
    ux, uy, uz = carried(ax, ay, az, wx, wy, wz, rx, ry, rz)
    vx, vy, vz = vx - ux, vy - uy, vz - uz
    while body > 0:
        above, j = poses[links[body, 0]], links[body, 1]
        row, pose = bodies[body], poses[body]
        if j >= 0:
            nx, ny, nz = turned(pose, row[30], row[31], row[32])
            wx, wy, wz = wx - dq[j] * nx, wy - dq[j] * ny, wz - dq[j] * nz
            ax -= ddq[j] * nx + dq[j] * (wy * nz - wz * ny)
            ay -= ddq[j] * ny + dq[j] * (wz * nx - wx * nz)
            az -= ddq[j] * nz + dq[j] * (wx * ny - wy * nx)
        rx, ry, rz = pose[9] - above[9], pose[10] - above[10], pose[11] - above[11]
        ux, uy, uz = carried(ax, ay, az, wx, wy, wz, rx, ry, rz)
        vx, vy, vz = vx - ux, vy - uy, vz - uz
        body = links[body, 0]
    base[0], base[1], base[2] = wx, wy, wz
    base[3], base[4], base[5] = ax, ay, az
    base[6], base[7], base[8] = vx, vy, vz


@compiled
def move(dq: Vector, ddq: Vector, tree: tuple[Places, Matrix, Matrix]) -> None:
    """Angular velocity, its rate, and acceleration of the origin of every body (eq. 8)."""
    links, bodies, poses = tree
    for i in range(1, bodies.shape[0]):
        parent, j = links[i, 0], links[i, 1]
        row, pose, mine = bodies[i], poses[i], bodies[i, MOVE:NEED]
        above, before = bodies[parent, MOVE:NEED], poses[parent]
        wx, wy, wz = above[0], above[1], above[2]
        ax, ay, az = above[3], above[4], above[5]
        rx, ry, rz = pose[9] - before[9], pose[10] - before[10], pose[11] - before[11]
        ux, uy, uz = carried(ax, ay, az, wx, wy, wz, rx, ry, rz)
        mine[6], mine[7], mine[8] = above[6] + ux, above[7] + uy, above[8] + uz
        if j >= 0:
            nx, ny, nz = turned(pose, row[30], row[31], row[32])
            ax += ddq[j] * nx + dq[j] * (wy * nz - wz * ny)
            ay += ddq[j] * ny + dq[j] * (wz * nx - wx * nz)
            az += ddq[j] * nz + dq[j] * (wx * ny - wy * nx)
            wx, wy, wz = wx + dq[j] * nx, wy + dq[j] * ny, wz + dq[j] * nz
        mine[0], mine[1], mine[2] = wx, wy, wz
        mine[3], mine[4], mine[5] = ax, ay, az


@compiled
def spin_moment(
    row: Vector, pose: Vector, wx: float, wy: float, wz: float, ax: float, ay: float, az: float
) -> tuple[float, float, float]:
    """Moment that a body needs about its centre of mass: I alpha + omega x I omega (eq. 9)."""
    lx, ly, lz = turned_back(pose, wx, wy, wz)
    hx = row[37] * lx + row[38] * ly + row[39] * lz
    hy = row[38] * lx + row[40] * ly + row[41] * lz
    hz = row[39] * lx + row[41] * ly + row[42] * lz
    gx, gy, gz = ly * hz - lz * hy, lz * hx - lx * hz, lx * hy - ly * hx
    lx, ly, lz = turned_back(pose, ax, ay, az)
    gx += row[37] * lx + row[38] * ly + row[39] * lz
    gy += row[38] * lx + row[40] * ly + row[41] * lz
    gz += row[39] * lx + row[41] * ly + row[42] * lz
    return turned(pose, gx, gy, gz)


@compiled
def need(links: Places, bodies: Matrix, poses: Matrix) -> None:
    """Wrench that every sub-tree needs for its motion, about the base's origin (eqs. 9, 10)."""
    for i in range(bodies.shape[0]):
        row, pose = bodies[i], poses[i]
        mine, total = row[MOVE:NEED], row[NEED:GIVEN]
        wx, wy, wz = mine[0], mine[1], mine[2]
        ax, ay, az = mine[3], mine[4], mine[5]
        cx, cy, cz = turned(pose, row[34], row[35], row[36])
        ux, uy, uz = carried(ax, ay, az, wx, wy, wz, cx, cy, cz)
        mass = row[33]
        fx, fy, fz = mass * (mine[6] + ux), mass * (mine[7] + uy), mass * (mine[8] + uz)
        gx, gy, gz = spin_moment(row, pose, wx, wy, wz, ax, ay, az)
        cx, cy, cz = cx + pose[9], cy + pose[10], cz + pose[11]
        total[0], total[1], total[2] = fx, fy, fz
        total[3] = gx + cy * fz - cz * fy
        total[4] = gy + cz * fx - cx * fz
        total[5] = gz + cx * fy - cy * fx
    for i in range(bodies.shape[0] - 1, 0, -1):
        for k in range(6):
            bodies[links[i, 0], NEED + k] += bodies[i, NEED + k]
