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
TURNS = 60  # about six are taken
SHORTEST_M2 = 1e-24  # below it a segment is a point

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
        share = 0.0
        if length2 > SHORTEST_M2:
            share = min(max(-(ax * dx + ay * dy + az * dz) / length2, 0.0), 1.0)
        far, nx, ny, nz = sphere_distance(sx, ax + share * dx, ay + share * dy, az + share * dz)
        return far, share, nx, ny, nz
    low, high = 0.0, 1.0
    f_low, nx, ny, nz = own_distance(kind, sx, sy, sz, ax, ay, az)
    g_low = nx * dx + ny * dy + nz * dz
    if g_low >= 0.0 or length2 <= SHORTEST_M2:
        return f_low, 0.0, nx, ny, nz
    best, share = f_low, 0.0
    f_high, mx, my, mz = own_distance(kind, sx, sy, sz, bx, by, bz)
    g_high = mx * dx + my * dy + mz * dz
    if g_high <= 0.0:
        return f_high, 1.0, mx, my, mz
    if f_high < best:
        best, share, nx, ny, nz = f_high, 1.0, mx, my, mz
    for turn in range(TURNS):
        meet = low + (f_high - f_low - g_high * (high - low)) / (g_low - g_high)
        bound = f_low + g_low * (meet - low)
        if bound >= enough or best - bound <= GAP_M:
            break
        # Tangents meet at a kink; a smooth minimum is where the slope's secant is zero.
        trial = meet
        if turn % 3 == 1:
            trial = low - g_low * (high - low) / (g_high - g_low)
        elif turn % 3 == 2:
            trial = 0.5 * (low + high)
        if not low < trial < high:
            trial = 0.5 * (low + high)
            if not low < trial < high:
                break
        f, mx, my, mz = own_distance(
            kind, sx, sy, sz, ax + trial * dx, ay + trial * dy, az + trial * dz
        )
        g = mx * dx + my * dy + mz * dz
        if f < best:
            best, share, nx, ny, nz = f, trial, mx, my, mz
        if g == 0.0:
            break
        if g < 0.0:
            low, f_low, g_low = trial, f, g
        else:
            high, f_high, g_high = trial, f, g
    return best, share, nx, ny, nz


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
        if across > 1e-14 * uu * vv:
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
