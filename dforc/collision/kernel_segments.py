"""Nearest point of a segment to a solid, in the solid's own axes, and of two segments, for numba.

The signed distance from a convex solid is a convex function along a segment, inside as well: where
the segment runs through the solid its smallest value is at the deepest point. The search keeps the
minimum between two points whose tangents fall towards it. Where the tangents meet is a lower bound;
the search ends when no lower value than the one found can be more than GAP_M below.
"""

import math

from dforc.collision.kernel_points import SPHERE, own_distance, sphere_distance
from dforc.compiled import compiled

GAP_M = 1e-13
TURNS = 100  # eight are taken, 21 at worst
SHORTEST_M2 = 1e-24  # below it a segment is a point
PARALLEL = 1e-14  # square of the sine between two segments

OwnSegment = tuple[float, float, float, float, float]  # signed distance, share, gradient
Crossing = tuple[float, float, float]  # distance, shares of the first and the second segment


@compiled
def own_segment(
    kind: int,
    sx: float,
    sy: float,
    sz: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    enough: float,
) -> OwnSegment:
    """Smallest signed distance on the segment a to b, where it is (0 at a, 1 at b), the gradient.

    Once no point can be nearer than `enough` the search ends with whatever it has.
    """
    dx, dy, dz = bx - ax, by - ay, bz - az
    length2 = dx * dx + dy * dy + dz * dz
    if kind == SPHERE:
        share = _share_nearest_origin(ax, ay, az, dx, dy, dz, length2)
        far, nx, ny, nz = sphere_distance(sx, ax + share * dx, ay + share * dy, az + share * dz)
        return far, share, nx, ny, nz
    far, nx, ny, nz = own_distance(kind, sx, sy, sz, ax, ay, az)
    slope = nx * dx + ny * dy + nz * dz
    if slope >= 0.0 or length2 <= SHORTEST_M2:
        return far, 0.0, nx, ny, nz
    far_b, mx, my, mz = own_distance(kind, sx, sy, sz, bx, by, bz)
    slope_b = mx * dx + my * dy + mz * dz
    if slope_b <= 0.0:
        return far_b, 1.0, mx, my, mz
    best, share = far, 0.0
    if far_b < far:
        best, share, nx, ny, nz = far_b, 1.0, mx, my, mz
    low, high = 0.0, 1.0
    for turn in range(TURNS):
        meet = low + (far_b - far - slope_b * (high - low)) / (slope - slope_b)
        bound = far + slope * (meet - low)
        if bound >= enough or best - bound <= GAP_M:
            break
        # A kink is where the tangents meet, a smooth minimum near that of the cubic between them.
        trial = _trial(turn, meet, low, high, far, far_b, slope, slope_b)
        if trial in (low, high):
            break
        at, mx, my, mz = own_distance(
            kind, sx, sy, sz, ax + trial * dx, ay + trial * dy, az + trial * dz
        )
        slope_at = mx * dx + my * dy + mz * dz
        if at < best:
            best, share, nx, ny, nz = at, trial, mx, my, mz
        if slope_at < 0.0:
            low, far, slope = trial, at, slope_at
        else:
            high, far_b, slope_b = trial, at, slope_at
    return best, share, nx, ny, nz


@compiled
def _trial(
    turn: int,
    meet: float,
    low: float,
    high: float,
    far: float,
    far_b: float,
    slope: float,
    slope_b: float,
) -> float:
    """Where to look next: at the meeting point of the tangents, or where the cubic is smallest."""
    trial = meet
    if turn % 2 == 0:
        width = high - low
        middle = 3.0 * (far - far_b) / width + slope + slope_b
        root = math.sqrt(max(middle * middle - slope * slope_b, 0.0))
        trial = high - width * (slope_b + root - middle) / (slope_b - slope + 2.0 * root)
    if not low < trial < high:
        trial = 0.5 * (low + high)
    return trial


@compiled
def _share_nearest_origin(
    ax: float, ay: float, az: float, dx: float, dy: float, dz: float, length2: float
) -> float:
    if length2 <= SHORTEST_M2:
        return 0.0
    return min(max(-(ax * dx + ay * dy + az * dz) / length2, 0.0), 1.0)


@compiled
def segments_apart(
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
    dx: float,
    dy: float,
    dz: float,
) -> Crossing:
    """Distance of the segments a-b and c-d and the shares of their nearest points."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = dx - cx, dy - cy, dz - cz
    wx, wy, wz = ax - cx, ay - cy, az - cz
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    uw, vw = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
    s, t = 0.0, 0.0
    if uu > SHORTEST_M2 and vv > SHORTEST_M2:
        across = uu * vv - uv * uv
        if across > PARALLEL * uu * vv:
            s = min(max((uv * vw - vv * uw) / across, 0.0), 1.0)
        t = (uv * s + vw) / vv
        if t < 0.0:
            t, s = 0.0, min(max(-uw / uu, 0.0), 1.0)
        elif t > 1.0:
            t, s = 1.0, min(max((uv - uw) / uu, 0.0), 1.0)
    elif uu > SHORTEST_M2:
        s = min(max(-uw / uu, 0.0), 1.0)
    elif vv > SHORTEST_M2:
        t = min(max(vw / vv, 0.0), 1.0)
    x, y, z = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return math.sqrt(x * x + y * y + z * z), s, t
