"""Signed distance of a point from a solid in the solid's own axes, for numba.

Negative inside. The gradient is the unit vector along which the distance grows: on the surface the
outward normal. Where several are right (centres, axes, edges) one of them is given.
"""

import math

from dforc.collision.obstacles import Shape
from dforc.compiled import compiled

SPHERE, ELLIPSOID = int(Shape.SPHERE), int(Shape.ELLIPSOID)
BOX, CYLINDER = int(Shape.BOX), int(Shape.CYLINDER)

NEWTON_STEPS = 60  # four or five are taken
ROUNDING = 4e-16

Distance = tuple[float, float, float, float]  # signed distance, gradient


@compiled
def own_distance(
    kind: int, sx: float, sy: float, sz: float, x: float, y: float, z: float
) -> Distance:
    """Signed distance and gradient of the point (x, y, z) from a solid of size (sx, sy, sz)."""
    if kind == SPHERE:
        return sphere_distance(sx, x, y, z)
    if kind == BOX:
        return box_distance(sx, sy, sz, x, y, z)
    if kind == CYLINDER:
        return cylinder_distance(sx, sy, x, y, z)
    return ellipsoid_distance(sx, sy, sz, x, y, z)


@compiled
def sphere_distance(radius: float, x: float, y: float, z: float) -> Distance:
    """From a ball; at its centre up is out."""
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return -radius, 0.0, 0.0, 1.0
    return length - radius, x / length, y / length, z / length


@compiled
def box_distance(hx: float, hy: float, hz: float, x: float, y: float, z: float) -> Distance:
    """From a box with half edges (hx, hy, hz)."""
    side_x, side_y, side_z = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
    x, y, z = abs(x) - hx, abs(y) - hy, abs(z) - hz
    out_x, out_y, out_z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    length = math.sqrt(out_x * out_x + out_y * out_y + out_z * out_z)
    if length > 0.0:
        return length, side_x * out_x / length, side_y * out_y / length, side_z * out_z / length
    if x >= y and x >= z:
        return x, side_x, 0.0, 0.0
    if y >= z:
        return y, 0.0, side_y, 0.0
    return z, 0.0, 0.0, side_z


@compiled
def cylinder_distance(radius: float, half: float, x: float, y: float, z: float) -> Distance:
    """From a cylinder around z with flat ends at -half and half."""
    side = math.copysign(1.0, z)
    length = math.sqrt(x * x + y * y)
    ux, uy = 1.0, 0.0
    if length > 0.0:
        ux, uy = x / length, y / length
    across, along = length - radius, abs(z) - half
    if across > 0.0 and along > 0.0:
        away = math.sqrt(across * across + along * along)
        return away, ux * across / away, uy * across / away, side * along / away
    if across >= along:
        return across, ux, uy, 0.0
    return along, 0.0, 0.0, side


@compiled
def ellipsoid_distance(a: float, b: float, c: float, x: float, y: float, z: float) -> Distance:
    """From an ellipsoid with semi-axes (a, b, c).

    The nearest point of the surface is r_i^2 x_i / (u + r_i^2 - m^2), m the smallest semi-axis,
    where |p(u)| = 1, p_i = r_i x_i / (u + r_i^2 - m^2). 1 / |p| is nearly straight in u > 0, so
    Newton's method finds it in a few steps; u is kept between bounds of the root. Where |p| < 1 for
    every u > 0 (inside, in the plane across the smallest semi-axis) u is 0, and what is missing
    of 1 is the component along that axis.
    """
    side_x, side_y, side_z = math.copysign(1.0, x), math.copysign(1.0, y), math.copysign(1.0, z)
    m = min(a, min(b, c))
    m2 = m * m
    ga, gb, gc = a * a - m2, b * b - m2, c * c - m2
    ax, by, cz = a * abs(x), b * abs(y), c * abs(z)
    high = math.sqrt(ax * ax + by * by + cz * cz)
    low = _along_smallest(ga, gb, gc, ax, by, cz)
    u = _root(ga, gb, gc, ax, by, cz, low, high)
    # Components of p; of the smallest semi-axis what the others leave of 1 where u is 0.
    px = ax / (u + ga) if u + ga > 0.0 else 0.0
    py = by / (u + gb) if u + gb > 0.0 else 0.0
    pz = cz / (u + gc) if u + gc > 0.0 else 0.0
    missing = 1.0 - px * px - py * py - pz * pz
    if u + min(ga, min(gb, gc)) <= 0.0 and missing > 0.0:
        if ga == 0.0:
            px = math.sqrt(missing)
        elif gb == 0.0:
            py = math.sqrt(missing)
        else:
            pz = math.sqrt(missing)
    nx, ny, nz = px / a, py / b, pz / c
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    return (
        (u - m2) * length,
        side_x * nx / length,
        side_y * ny / length,
        side_z * nz / length,
    )


@compiled
def _along_smallest(ga: float, gb: float, gc: float, ax: float, by: float, cz: float) -> float:
    """Length of what belongs to the smallest semi-axes: p alone of it is 1 at u = this."""
    total = 0.0
    if ga == 0.0:
        total += ax * ax
    if gb == 0.0:
        total += by * by
    if gc == 0.0:
        total += cz * cz
    return math.sqrt(total)


@compiled
def _root(
    ga: float, gb: float, gc: float, ax: float, by: float, cz: float, low: float, high: float
) -> float:
    """The u >= 0 with |p(u)| = 1, between low and high; 0 where |p| is below 1 for all."""
    if low == 0.0:
        px = ax / ga if ga > 0.0 else 0.0
        py = by / gb if gb > 0.0 else 0.0
        pz = cz / gc if gc > 0.0 else 0.0
        if px * px + py * py + pz * pz <= 1.0:
            return 0.0
    u = low if low > 0.0 else 0.0
    for _ in range(NEWTON_STEPS):
        da, db, dc = u + ga, u + gb, u + gc
        px = ax / da if ax > 0.0 else 0.0
        py = by / db if by > 0.0 else 0.0
        pz = cz / dc if cz > 0.0 else 0.0
        square = px * px + py * py + pz * pz
        if square >= 1.0:
            low = max(low, u)
        else:
            high = min(high, u)
        slope = 0.0
        slope += px * px / da if ax > 0.0 else 0.0
        slope += py * py / db if by > 0.0 else 0.0
        slope += pz * pz / dc if cz > 0.0 else 0.0
        step = (math.sqrt(square) - 1.0) * square / slope
        if abs(step) <= ROUNDING * u:
            break
        trial = u + step
        if not low <= trial <= high:
            trial = 0.5 * (low + high)
        u = trial
        if high - low <= ROUNDING * high:
            break
    return u
