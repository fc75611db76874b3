"""Force field that moves a virtual point to targets and around obstacles (DForC, eqs. 3 to 5).

Eq. 3  F_target   = K (x_t - x) - D dx, unit mass; the targets' forces add up.
Eq. 4  F_obstacle = G exp(-(x - x_c)' Sigma^-1 (x - x_c)) (x - x_c) / |x - x_c|.
Eq. 5  F_obstacle is zero outside the ellipsoid (x - x_c)' Sigma^-1 (x - x_c) = 1.

Sigma = R diag((r + margin)^2) R', with the semi-axes r and the rotation R of the obstacle. (The
paper's "diagonal equal to the radius" is off by its unit: taken literally, a ball of 50 mm acts as
one of 224 mm.) The truncated force begins only inside the ellipsoid, so an obstacle that is in the
way is always entered a little. With a margin, what is entered is the margin; the paper has none.

This is the paper's field, with its faults: exactly in front of an obstacle the point sticks, some
arrangements trap it, and without truncation it comes to rest beside the target.

Positions in m in one frame (the robot's base), velocities in m/s, forces in N on a mass of 1 kg.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector, constant
from dforc.errors import DforcError, NotFiniteError
from dforc.field.kernel_force import Scene, add_attraction, add_repulsion

Triple = tuple[float, float, float]
Rows = tuple[Triple, Triple, Triple]

IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROTATION_TOLERANCE = 1e-6  # of R'R from the identity


class FieldError(DforcError, ValueError):
    """A parameter, a target or an obstacle that makes no field."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldParams:
    """Constants of the field; by default the paper's, of its tracking experiment."""

    stiffness_n_m: float = 4.0  # K
    damping_ns_m: float = 8.0  # D
    gain_n: float = 10.0  # G
    margin_m: float = 0.0  # added to every semi-axis
    truncated: bool = True  # eq. 5; False: eq. 4 with its tails

    def __post_init__(self) -> None:
        """Refuse constants that let the point run away."""
        _refuse_constants(
            stiffness=self.stiffness_n_m,
            damping=self.damping_ns_m,
            gain=self.gain_n,
            margin=self.margin_m,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A place that draws the point, with constants of its own where they are given."""

    position_m: Triple
    active: bool = True
    stiffness_n_m: float | None = None
    damping_ns_m: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipsoid:
    """An obstacle: centre and semi-axes, without margin [m]; its axes are columns of `rotation`."""

    centre_m: Triple
    semi_axes_m: Triple
    rotation: Rows = IDENTITY
    active: bool = True
    gain_n: float | None = None
    margin_m: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PointState:
    """The virtual point: position [m] and velocity [m/s] in the base frame."""

    position_m: Triple
    velocity_m_s: Triple = (0.0, 0.0, 0.0)


def ball(centre_m: Triple, radius_m: float) -> Ellipsoid:
    """A ball as an obstacle."""
    return Ellipsoid(centre_m=centre_m, semi_axes_m=(radius_m, radius_m, radius_m))


def scene_of(
    targets: Sequence[Target], obstacles: Sequence[Ellipsoid], params: FieldParams
) -> Scene:
    """Everything that is active, checked. Without an active target nothing damps the point.

    Raises:
        NotFiniteError: NaN or infinity in a target or an obstacle, be it active or not.
        FieldError: an obstacle without volume, a rotation that is none, or a negative constant.
    """
    for target in targets:
        _refuse_target(target)
    for obstacle in obstacles:
        _refuse_obstacle(obstacle)
    drawing = [target for target in targets if target.active]
    pushing = [obstacle for obstacle in obstacles if obstacle.active]
    margins = [_own(o.margin_m, params.margin_m) for o in pushing]
    reaches = [
        [r + margin for r in o.semi_axes_m] for o, margin in zip(pushing, margins, strict=True)
    ]
    return Scene(
        targets_m=_table([t.position_m for t in drawing], 3),
        stiffness_n_m=constant([_own(t.stiffness_n_m, params.stiffness_n_m) for t in drawing]),
        damping_ns_m=constant([_own(t.damping_ns_m, params.damping_ns_m) for t in drawing]),
        centres_m=_table([o.centre_m for o in pushing], 3),
        rotations=_table([sum(o.rotation, ()) for o in pushing], 9),
        reaches_m=_table(reaches, 3),
        gains_n=constant([_own(o.gain_n, params.gain_n) for o in pushing]),
        truncated=params.truncated,
    )


def force(state: PointState, scene: Scene) -> Triple:
    """Sum of eq. 3 over all targets and of eq. 5 (or 4) over all obstacles [N]."""
    total = np.zeros(3)
    x = np.array(state.position_m)
    add_attraction(x, np.array(state.velocity_m_s), scene, total)
    add_repulsion(x, scene, total)
    return _triple(total)


def repulsion(position_m: Triple, scene: Scene) -> Triple:
    """Sum of eq. 5 (or 4) over all obstacles [N]."""
    total = np.zeros(3)
    add_repulsion(np.array(position_m), scene, total)
    return _triple(total)


def _triple(values: Vector) -> Triple:
    x, y, z = values.tolist()
    return x, y, z


def _table(rows: Sequence[Sequence[float]], width: int) -> Matrix:
    return constant(np.array(rows, dtype=np.float64).reshape(-1, width))


def _own(value: float | None, common: float) -> float:
    return common if value is None else value


def _refuse_target(target: Target) -> None:
    if not all(map(math.isfinite, target.position_m)):
        raise NotFiniteError(f"the field was given {target}")
    _refuse_constants(stiffness=target.stiffness_n_m, damping=target.damping_ns_m)


def _refuse_obstacle(obstacle: Ellipsoid) -> None:
    # A sum is finite only if every term is: one test for all.
    total = sum(obstacle.centre_m) + sum(obstacle.semi_axes_m) + sum(map(sum, obstacle.rotation))
    if not math.isfinite(total):
        raise NotFiniteError(f"the field was given {obstacle}")
    if min(obstacle.semi_axes_m) <= 0.0:
        raise FieldError(f"an obstacle needs positive semi-axes, not {obstacle.semi_axes_m}")
    if obstacle.rotation is not IDENTITY:
        R = np.array(obstacle.rotation)
        if np.abs(R.T @ R - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
            raise FieldError(f"an obstacle's axes must be a rotation, not {obstacle.rotation}")
    _refuse_constants(gain=obstacle.gain_n, margin=obstacle.margin_m)


def _refuse_constants(**constants: float | None) -> None:
    for name, value in constants.items():
        if value is not None and not (math.isfinite(value) and value >= 0.0):
            raise FieldError(f"the field's {name} must be a number >= 0, not {value}")
