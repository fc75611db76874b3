"""Force field that moves a virtual point to the goal and around obstacles (DForC, eqs. 3 to 5).

Eq. 3  F_target   = K (x_t - x) - D dx, unit mass.
Eq. 4  F_obstacle = G exp(-(x - x_c)' Sigma^-1 (x - x_c)) (x - x_c) / |x - x_c|.
Eq. 5  F_obstacle is zero outside the ellipsoid (x - x_c)' Sigma^-1 (x - x_c) = 1.

Sigma = R diag(r^2) R', with the semi-axes r and the rotation R of the obstacle. (The paper's
"diagonal equal to the radius" is off by its unit: taken literally, a ball of 50 mm acts as one of
224 mm.) The truncated force begins only inside the ellipsoid, so an obstacle that is in the way is
always entered a little. Here r is the obstacle's semi-axis plus an explicit margin: what is
entered is the margin, not the obstacle.

Positions in m in one frame (the robot's base), velocities in m/s, forces in N on a mass of 1 kg.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from dforc.errors import DforcError, NotFiniteError

Triple = tuple[float, float, float]
Rows = tuple[Triple, Triple, Triple]

IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
HEAD_ON_SINE = 0.02  # "exactly in front": within 1.1 degrees of the line from centre to goal
HEAD_ON_SHARE = 0.02  # sideways force there, as a share of the repulsion
NO_FORCE: Triple = (0.0, 0.0, 0.0)


class FieldError(DforcError, ValueError):
    """A parameter or an obstacle that makes no field."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldParams:
    """Constants of the field.

    DELIBERATE: the papers' K = 4 N/m, D = 8 Ns/m have poles at -0.54 and -7.46 1/s: 7.8 s to come
    within 5 mm of a target 0.3 m away, and 2 s of lag behind a moving one. K = 9, D = 6 is
    critically damped (both poles at -3 1/s): 2.0 s and 0.67 s.
    """

    stiffness_n_m: float = 9.0
    damping_ns_m: float = 6.0
    gain_n: float = 25.0  # at the boundary G/e = 9.2 N = K 1.02 m: holds against goals within 1 m
    margin_m: float = 0.02  # added to every semi-axis: the force acts within radius + margin

    def __post_init__(self) -> None:
        """Refuse constants that let the point run away."""
        values = (self.stiffness_n_m, self.damping_ns_m, self.gain_n, self.margin_m)
        if not all(math.isfinite(value) and value >= 0.0 for value in values):
            raise FieldError(f"stiffness, damping, gain and margin must be >= 0, not {values}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipsoid:
    """An obstacle: centre and semi-axes, without margin [m]; its axes are columns of `rotation`."""

    centre_m: Triple
    semi_axes_m: Triple
    rotation: Rows = IDENTITY


@dataclass(frozen=True, slots=True, kw_only=True)
class PointState:
    """The virtual point: position [m] and velocity [m/s] in the base frame."""

    position_m: Triple
    velocity_m_s: Triple = (0.0, 0.0, 0.0)


def ball(centre_m: Triple, radius_m: float) -> Ellipsoid:
    """A ball as an obstacle."""
    return Ellipsoid(centre_m=centre_m, semi_axes_m=(radius_m, radius_m, radius_m))


def step(
    state: PointState,
    goal_m: Triple,
    obstacles: Sequence[Ellipsoid],
    params: FieldParams,
    dt_s: float,
) -> PointState:
    """Move the point by one period of semi-implicit Euler (10 ms in the papers).

    Raises:
        NotFiniteError: state, goal, an obstacle or dt_s holds NaN or infinity; keep the old state.
        FieldError: an obstacle without volume, or a dt_s that is not positive.
    """
    _refuse_bad_input(state, goal_m, obstacles, dt_s)
    fx, fy, fz = force(state, goal_m, obstacles, params)
    (x, y, z), (u, v, w) = state.position_m, state.velocity_m_s
    u, v, w = u + dt_s * fx, v + dt_s * fy, w + dt_s * fz
    return PointState(position_m=(x + dt_s * u, y + dt_s * v, z + dt_s * w), velocity_m_s=(u, v, w))


def force(
    state: PointState, goal_m: Triple, obstacles: Sequence[Ellipsoid], params: FieldParams
) -> Triple:
    """Sum of eq. 3 and of eq. 5 over all obstacles [N]."""
    k, d = params.stiffness_n_m, params.damping_ns_m
    (x, y, z), (u, v, w) = state.position_m, state.velocity_m_s
    px, py, pz = goal_m[0] - x, goal_m[1] - y, goal_m[2] - z
    fx, fy, fz = k * px - d * u, k * py - d * v, k * pz - d * w
    for obstacle in obstacles:
        rx, ry, rz = repulsion(state.position_m, obstacle, params)
        if rx or ry or rz:
            sx, sy, sz = _sideways((rx, ry, rz), (px, py, pz))
            fx, fy, fz = fx + rx + sx, fy + ry + sy, fz + rz + sz
    return fx, fy, fz


def repulsion(position_m: Triple, obstacle: Ellipsoid, params: FieldParams) -> Triple:
    """Eq. 5 [N]: eq. 4 inside the obstacle grown by the margin, zero outside and at its centre."""
    cx, cy, cz = obstacle.centre_m
    dx, dy, dz = position_m[0] - cx, position_m[1] - cy, position_m[2] - cz
    q = _ellipsoidal(dx, dy, dz, obstacle, params.margin_m)
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if q > 1.0 or distance == 0.0:
        return NO_FORCE
    scale = params.gain_n * math.exp(-q) / distance
    return scale * dx, scale * dy, scale * dz


def _ellipsoidal(dx: float, dy: float, dz: float, obstacle: Ellipsoid, margin_m: float) -> float:
    """(x - x_c)' Sigma^-1 (x - x_c), with the margin in Sigma."""
    a, b, c = obstacle.semi_axes_m
    if obstacle.rotation is not IDENTITY:
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = obstacle.rotation
        dx, dy, dz = (
            r00 * dx + r10 * dy + r20 * dz,
            r01 * dx + r11 * dy + r21 * dz,
            r02 * dx + r12 * dy + r22 * dz,
        )
    a, b, c = dx / (a + margin_m), dy / (b + margin_m), dz / (c + margin_m)
    return a * a + b * b + c * c


def _sideways(repulsion_n: Triple, to_goal_m: Triple) -> Triple:
    """A small force across the line centre-goal where the obstacle stands exactly in the way.

    DELIBERATE: not in the paper, whose field has an unstable equilibrium there: the point chatters
    in front of the obstacle and never arrives. The direction is fixed, so that runs repeat.
    """
    rx, ry, rz = repulsion_n
    px, py, pz = to_goal_m
    r2, p2 = rx * rx + ry * ry + rz * rz, px * px + py * py + pz * pz
    dot = rx * px + ry * py + rz * pz
    if dot >= 0.0 or dot * dot < (1.0 - HEAD_ON_SINE**2) * r2 * p2:
        return NO_FORCE
    # r x e, with e the base axis that is least along r
    smallest = min(abs(rx), abs(ry), abs(rz))
    if abs(rz) == smallest:
        across = (ry, -rx, 0.0)
    elif abs(ry) == smallest:
        across = (-rz, 0.0, rx)
    else:
        across = (0.0, rz, -ry)
    scale = HEAD_ON_SHARE * math.sqrt(r2 / sum(component * component for component in across))
    return scale * across[0], scale * across[1], scale * across[2]


def _refuse_bad_input(
    state: PointState, goal_m: Triple, obstacles: Sequence[Ellipsoid], dt_s: float
) -> None:
    # A sum is finite only if every term is: one test for all.
    total = sum(state.position_m) + sum(state.velocity_m_s) + sum(goal_m) + dt_s
    if not math.isfinite(total):
        raise NotFiniteError(f"the field was given {state}, goal {goal_m}, period {dt_s} s")
    if dt_s <= 0.0:
        raise FieldError(f"period must be positive, not {dt_s} s")
    for obstacle in obstacles:
        total = sum(obstacle.centre_m) + sum(obstacle.semi_axes_m)
        if obstacle.rotation is not IDENTITY:
            total += sum(sum(row) for row in obstacle.rotation)
        if not math.isfinite(total):
            raise NotFiniteError(f"the field was given {obstacle}")
        if min(obstacle.semi_axes_m) <= 0.0:
            raise FieldError(f"an obstacle needs positive semi-axes, not {obstacle.semi_axes_m}")
