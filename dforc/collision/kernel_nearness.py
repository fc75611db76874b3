"""Parts of the body's distances, for numba: bounds, nearest points, and how they move."""

import math

from dforc.arrays import Matrix, Vector
from dforc.collision.body import BodyArrays
from dforc.collision.kernel_segments import segments_apart
from dforc.collision.obstacles import World
from dforc.compiled import compiled

CROSSING_M = 1e-9  # axes that cross have no normal of their own

Point = tuple[float, float, float]


@compiled
def axes_bound(body: BodyArrays, segments: Matrix, i: int, j: int) -> float:
    """What the axes of two capsules are apart at least [m], by the balls around them."""
    s = segments
    x = s[i, 0] + s[i, 3] - s[j, 0] - s[j, 3]
    y = s[i, 1] + s[i, 4] - s[j, 1] - s[j, 4]
    z = s[i, 2] + s[i, 5] - s[j, 2] - s[j, 5]
    bound: float = 0.5 * math.sqrt(x * x + y * y + z * z) - body.halves[i] - body.halves[j]
    return bound


@compiled
def ball_bound(segments: Matrix, i: int, world: World, obstacle: int) -> float:
    """What the axis of a capsule is apart from an obstacle at least [m], by the ball around it."""
    s, c = segments, world.centres
    dx, dy, dz = s[i, 3] - s[i, 0], s[i, 4] - s[i, 1], s[i, 5] - s[i, 2]
    x, y, z = c[obstacle, 0] - s[i, 0], c[obstacle, 1] - s[i, 1], c[obstacle, 2] - s[i, 2]
    length2 = dx * dx + dy * dy + dz * dz
    along = x * dx + y * dy + z * dz
    if along > 0.0:
        share = 1.0 if along >= length2 else along / length2
        x, y, z = x - share * dx, y - share * dy, z - share * dz
    bound: float = math.sqrt(x * x + y * y + z * z) - world.reaches[obstacle]
    return bound


@compiled
def normal_between(
    x: float, y: float, z: float, length: float, segments: Matrix, i: int, j: int
) -> Point:
    """Unit vector along (x, y, z), from capsule j to i; across both axes where they cross."""
    if length > CROSSING_M:
        return x / length, y / length, z / length
    s = segments
    ux, uy, uz = s[i, 3] - s[i, 0], s[i, 4] - s[i, 1], s[i, 5] - s[i, 2]
    vx, vy, vz = s[j, 3] - s[j, 0], s[j, 4] - s[j, 1], s[j, 5] - s[j, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = math.sqrt(x * x + y * y + z * z)
    if length > 0.0:
        return x / length, y / length, z / length
    return 0.0, 0.0, 1.0


@compiled
def row_for(distance: float, distances: Vector, count: int) -> int:
    """A free row, or that of the farthest kept if it is farther than `distance`, or -1."""
    if count < len(distances):
        return count
    worst = -1
    for row in range(count):
        if distances[row] > distance and (worst < 0 or distances[row] > distances[worst]):
            worst = row
    return worst


@compiled
def add_motion(
    body: BodyArrays,
    carrier: int,
    frames: Matrix,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    gradients: Matrix,
    row: int,
) -> None:
    """Add how fast a carried point moves along n for each joint below it."""
    joint = carrier
    while joint >= 0:
        ax, ay, az = frames[joint, 2], frames[joint, 5], frames[joint, 8]
        rx, ry, rz = x - frames[joint, 9], y - frames[joint, 10], z - frames[joint, 11]
        gradients[row, joint] += (
            nx * (ay * rz - az * ry) + ny * (az * rx - ax * rz) + nz * (ax * ry - ay * rx)
        )
        joint = body.parents[joint]


@compiled
def point_on(segments: Matrix, i: int, share: float) -> Point:
    """Point of a capsule's axis."""
    s = segments
    return (
        s[i, 0] + share * (s[i, 3] - s[i, 0]),
        s[i, 1] + share * (s[i, 4] - s[i, 1]),
        s[i, 2] + share * (s[i, 5] - s[i, 2]),
    )


@compiled
def apart(segments: Matrix, i: int, j: int) -> Point:
    """Distance of two capsules' axes, and the shares of their nearest points."""
    s = segments
    found: Point = segments_apart(
        s[i, 0],
        s[i, 1],
        s[i, 2],
        s[i, 3],
        s[i, 4],
        s[i, 5],
        s[j, 0],
        s[j, 1],
        s[j, 2],
        s[j, 3],
        s[j, 4],
        s[j, 5],
    )
    return found
