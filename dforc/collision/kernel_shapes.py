"""Signed distances of points and segments from obstacles in the base frame, for numba."""

import math

from dforc.arrays import Matrix, Vector
from dforc.collision.kernel_points import own_distance
from dforc.collision.kernel_segments import own_segment
from dforc.collision.obstacles import World
from dforc.compiled import compiled

NEVER = -1e300  # lower than any distance: search to the end


@compiled
def point_distance(
    kind: int, size: Vector, rotation: Vector, centre: Vector, x: Vector, normal_out: Vector
) -> float:
    """Signed distance [m] of a point, negative inside; into `normal_out` (3,) the unit normal.

    The normal points out of the solid, in the base's axes, and is defined everywhere.
    """
    r = rotation
    px, py, pz = x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]
    far, nx, ny, nz = own_distance(
        kind,
        size[0],
        size[1],
        size[2],
        r[0] * px + r[3] * py + r[6] * pz,
        r[1] * px + r[4] * py + r[7] * pz,
        r[2] * px + r[5] * py + r[8] * pz,
    )
    normal_out[0] = r[0] * nx + r[1] * ny + r[2] * nz
    normal_out[1] = r[3] * nx + r[4] * ny + r[5] * nz
    normal_out[2] = r[6] * nx + r[7] * ny + r[8] * nz
    return far


@compiled
def segment_distance(
    kind: int,
    size: Vector,
    rotation: Vector,
    centre: Vector,
    a: Vector,
    b: Vector,
    normal_out: Vector,
) -> tuple[float, float]:
    """Smallest signed distance [m] on a segment, and its share of the way from a to b.

    Into `normal_out` (3,) the unit normal there. A segment that enters the solid has its deepest
    point as nearest.
    """
    r = rotation
    px, py, pz = a[0] - centre[0], a[1] - centre[1], a[2] - centre[2]
    qx, qy, qz = b[0] - centre[0], b[1] - centre[1], b[2] - centre[2]
    far, share, nx, ny, nz = own_segment(
        kind,
        size[0],
        size[1],
        size[2],
        r[0] * px + r[3] * py + r[6] * pz,
        r[1] * px + r[4] * py + r[7] * pz,
        r[2] * px + r[5] * py + r[8] * pz,
        r[0] * qx + r[3] * qy + r[6] * qz,
        r[1] * qx + r[4] * qy + r[7] * qz,
        r[2] * qx + r[5] * qy + r[8] * qz,
        -NEVER,
    )
    normal_out[0] = r[0] * nx + r[1] * ny + r[2] * nz
    normal_out[1] = r[3] * nx + r[4] * ny + r[5] * nz
    normal_out[2] = r[6] * nx + r[7] * ny + r[8] * nz
    return far, share


@compiled
def nearest_on(
    i: int, world: World, a: Matrix, enough: float
) -> tuple[float, float, float, float, float]:
    """As `segment_distance`, of obstacle i and a segment (6,), margins not counted.

    Returns distance, share and normal. Where the distance is not below `enough` they are rough.
    """
    r, s, c = world.rotations, world.sizes, world.centres
    px, py, pz = a[0] - c[i, 0], a[1] - c[i, 1], a[2] - c[i, 2]
    qx, qy, qz = a[3] - c[i, 0], a[4] - c[i, 1], a[5] - c[i, 2]
    far, share, nx, ny, nz = own_segment(
        world.kinds[i],
        s[i, 0],
        s[i, 1],
        s[i, 2],
        r[i, 0] * px + r[i, 3] * py + r[i, 6] * pz,
        r[i, 1] * px + r[i, 4] * py + r[i, 7] * pz,
        r[i, 2] * px + r[i, 5] * py + r[i, 8] * pz,
        r[i, 0] * qx + r[i, 3] * qy + r[i, 6] * qz,
        r[i, 1] * qx + r[i, 4] * qy + r[i, 7] * qz,
        r[i, 2] * qx + r[i, 5] * qy + r[i, 8] * qz,
        enough,
    )
    return (
        far,
        share,
        r[i, 0] * nx + r[i, 1] * ny + r[i, 2] * nz,
        r[i, 3] * nx + r[i, 4] * ny + r[i, 5] * nz,
        r[i, 6] * nx + r[i, 7] * ny + r[i, 8] * nz,
    )


@compiled
def world_distance(x: Vector, world: World) -> float:
    """Smallest signed distance [m] of a point from any obstacle's margin; inf without obstacles."""
    least = math.inf
    r, s, c = world.rotations, world.sizes, world.centres
    for i in range(len(world.kinds)):
        px, py, pz = x[0] - c[i, 0], x[1] - c[i, 1], x[2] - c[i, 2]
        margin = world.margins[i]
        if math.sqrt(px * px + py * py + pz * pz) - world.reaches[i] - margin >= least:
            continue
        far, _, _, _ = own_distance(
            world.kinds[i],
            s[i, 0],
            s[i, 1],
            s[i, 2],
            r[i, 0] * px + r[i, 3] * py + r[i, 6] * pz,
            r[i, 1] * px + r[i, 4] * py + r[i, 7] * pz,
            r[i, 2] * px + r[i, 5] * py + r[i, 8] * pz,
        )
        least = min(least, far - margin)
    return least


@compiled
def is_segment_free(a: Vector, b: Vector, world: World, clearance: float) -> bool:
    """Whether every point from a to b is at least `clearance` [m] from every obstacle's margin."""
    r, s, c = world.rotations, world.sizes, world.centres
    for i in range(len(world.kinds)):
        needed = clearance + world.margins[i]
        px, py, pz = a[0] - c[i, 0], a[1] - c[i, 1], a[2] - c[i, 2]
        qx, qy, qz = b[0] - c[i, 0], b[1] - c[i, 1], b[2] - c[i, 2]
        far, _, _, _, _ = own_segment(
            world.kinds[i],
            s[i, 0],
            s[i, 1],
            s[i, 2],
            r[i, 0] * px + r[i, 3] * py + r[i, 6] * pz,
            r[i, 1] * px + r[i, 4] * py + r[i, 7] * pz,
            r[i, 2] * px + r[i, 5] * py + r[i, 8] * pz,
            r[i, 0] * qx + r[i, 3] * qy + r[i, 6] * qz,
            r[i, 1] * qx + r[i, 4] * qy + r[i, 7] * qz,
            r[i, 2] * qx + r[i, 5] * qy + r[i, 8] * qz,
            needed,
        )
        if far < needed:
            return False
    return True
