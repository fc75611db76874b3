"""Signed distance of a point from a solid in the solid's own axes, for numba.

Negative inside. The gradient is the unit vector along which the distance grows: on the surface the
outward normal. Where several are right (centres, axes, edges) one of them is given.
"""

import math

from dforc.collision.obstacles import Shape
from dforc.compiled import compiled

SPHERE, ELLIPSOID = int(Shape.SPHERE), int(Shape.ELLIPSOID)
BOX, CYLINDER = int(Shape.BOX), int(Shape.CYLINDER)

NEWTON_STEPS = 60  # three are taken
CONVERGED = 1e-9  # of u: what is left of a step is its square

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
    u = _root(ga, gb, gc, ax, by, cz)
    px = ax / (u + ga) if ax > 0.0 and u + ga > 0.0 else 0.0
    py = by / (u + gb) if by > 0.0 and u + gb > 0.0 else 0.0
    pz = cz / (u + gc) if cz > 0.0 and u + gc > 0.0 else 0.0
    if u == 0.0:
        missing = math.sqrt(max(1.0 - px * px - py * py - pz * pz, 0.0))
        if ga == 0.0:
            px = missing
        elif gb == 0.0:
            py = missing
        else:
            pz = missing
    nx, ny, nz = px / a, py / b, pz / c
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    return (
        (u - m2) * length,
        side_x * nx / length,
        side_y * ny / length,
        side_z * nz / length,
    )


@compiled
def _root(ga: float, gb: float, gc: float, ax: float, by: float, cz: float) -> float:
    """The u >= 0 with |p(u)| = 1; 0 where |p| is below 1 for all."""
    low = max(ax - ga, max(by - gb, cz - gc))  # there one component alone is 1
    high = ax + by + cz
    if low <= 0.0:
        low = 0.0
        px = ax / ga if ax > 0.0 else 0.0
        py = by / gb if by > 0.0 else 0.0
        pz = cz / gc if cz > 0.0 else 0.0
        if px * px + py * py + pz * pz <= 1.0:
            return 0.0
    u = low
    for _ in range(NEWTON_STEPS):
        ra = 1.0 / (u + ga) if ax > 0.0 else 0.0
        rb = 1.0 / (u + gb) if by > 0.0 else 0.0
        rc = 1.0 / (u + gc) if cz > 0.0 else 0.0
        px, py, pz = ax * ra, by * rb, cz * rc
        px, py, pz = px * px, py * py, pz * pz
        square = px + py + pz
        if square >= 1.0:
            low = u
        else:
            high = u
        step = (math.sqrt(square) - 1.0) * square / (px * ra + py * rb + pz * rc)
        u += step
        if not low <= u <= high:
            u = 0.5 * (low + high)
        elif abs(step) <= CONVERGED * u:
            break
    return u
