"""The paper's force: exact against a reference of its own, cut off or not, switched on and off."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from dforc import rotation
from dforc.errors import NotFiniteError
from dforc.field.force import (
    Ellipsoid,
    FieldError,
    FieldParams,
    PointState,
    Rows,
    Target,
    Triple,
    ball,
    force,
    repulsion,
    scene_of,
)

ORIGIN: Triple = (0.0, 0.0, 0.0)
NOTHING: Triple = (0.0, 0.0, 0.0)
POINTS = 100_000


def turn(rotation_rad: Triple) -> Rows:
    a, b, c = rotation.matrix(rotation_rad).tolist()
    return tuple(a), tuple(b), tuple(c)


def reference(
    x: NDArray[np.float64],
    v: NDArray[np.float64],
    targets: list[Target],
    obstacles: list[Ellipsoid],
    params: FieldParams,
) -> NDArray[np.float64]:
    """Eqs. 3 to 5 as printed, for many points (k, 3) at once, with an inverted covariance."""
    total = np.zeros_like(x)
    for target in targets:
        total += params.stiffness_n_m * (np.array(target.position_m) - x)
        total -= params.damping_ns_m * v
    for item in obstacles:
        R = np.array(item.rotation)
        radii = np.array(item.semi_axes_m) + params.margin_m
        information = np.linalg.inv(R @ np.diag(radii**2) @ R.T)
        away = x - np.array(item.centre_m)
        q = np.einsum("ki,ij,kj->k", away, information, away)
        size = params.gain_n * np.exp(-q)
        if params.truncated:
            size[q > 1.0] = 0.0
        total += size[:, None] * away / np.linalg.norm(away, axis=1)[:, None]
    return total


@pytest.mark.parametrize("truncated", [True, False])
@pytest.mark.parametrize("margin_m", [0.0, 0.01])
def test_force_equals_the_equations_at_1e5_random_points(truncated: bool, margin_m: float) -> None:
    rng = np.random.default_rng(3)
    params = FieldParams(margin_m=margin_m, truncated=truncated)
    targets = [Target(position_m=(0.1, -0.2, 0.05)), Target(position_m=(-0.05, 0.1, 0.3))]
    obstacles = [
        Ellipsoid(
            centre_m=tuple(rng.uniform(-0.1, 0.1, 3).tolist()),
            semi_axes_m=tuple(rng.uniform(0.02, 0.12, 3).tolist()),
            rotation=turn(tuple(rng.normal(size=3).tolist())),
        )
        for _ in range(4)
    ]
    x, v = rng.uniform(-0.2, 0.2, (POINTS, 3)), rng.normal(size=(POINTS, 3)) * 0.2
    expected = reference(x, v, targets, obstacles, params)
    scene = scene_of(targets, obstacles, params)
    found = np.array(
        [
            force(PointState(position_m=tuple(p), velocity_m_s=tuple(u)), scene)
            for p, u in zip(x.tolist(), v.tolist(), strict=True)
        ]
    )
    inside = np.linalg.norm(expected - reference(x, v, targets, [], params), axis=1) > 0.0
    assert inside.sum() > POINTS // 20  # the obstacles do take part
    # A point within rounding of a surface may be in for one and out for the other: none is.
    assert np.abs(found - expected).max() < 1e-12


def test_targets_add_up_and_one_that_is_off_does_not_act() -> None:
    params = FieldParams(stiffness_n_m=4.0, damping_ns_m=8.0)
    near, far = Target(position_m=(0.1, 0.0, 0.0)), Target(position_m=(0.0, 0.3, 0.0))
    state = PointState(position_m=ORIGIN, velocity_m_s=(0.0, 0.0, 0.5))
    both = force(state, scene_of((near, far), (), params))
    assert both == pytest.approx((0.4, 1.2, -8.0))
    off = Target(position_m=far.position_m, active=False)
    assert force(state, scene_of((near, off), (), params)) == pytest.approx((0.4, 0.0, -4.0))


def test_target_and_obstacle_may_have_constants_of_their_own() -> None:
    target = Target(position_m=(0.1, 0.0, 0.0), stiffness_n_m=10.0, damping_ns_m=0.0)
    state = PointState(position_m=ORIGIN, velocity_m_s=(0.0, 1.0, 0.0))
    assert force(state, scene_of((target,), (), FieldParams())) == pytest.approx((1.0, 0.0, 0.0))
    item = Ellipsoid(centre_m=ORIGIN, semi_axes_m=(0.05, 0.05, 0.05), gain_n=2.0, margin_m=0.05)
    fx, _, _ = repulsion((0.1, 0.0, 0.0), scene_of((), (item,), FieldParams()))
    assert fx == pytest.approx(2.0 / math.e)


def test_without_an_active_target_a_free_point_feels_nothing() -> None:
    state = PointState(position_m=ORIGIN, velocity_m_s=(1.0, 0.0, 0.0))
    assert force(state, scene_of((), (), FieldParams())) == NOTHING


def test_obstacle_that_is_off_does_not_act() -> None:
    on = ball(ORIGIN, 0.05)
    off = Ellipsoid(centre_m=ORIGIN, semi_axes_m=(0.05, 0.05, 0.05), active=False)
    x = (0.03, 0.0, 0.0)
    assert repulsion(x, scene_of((), (on,), FieldParams())) != NOTHING
    assert repulsion(x, scene_of((), (off,), FieldParams())) == NOTHING


def test_force_begins_at_radius_plus_margin_with_a_jump_of_gain_over_e() -> None:
    params = FieldParams(margin_m=0.02)
    scene = scene_of((), (ball(ORIGIN, 0.05),), params)
    assert repulsion((0.070001, 0.0, 0.0), scene) == NOTHING
    fx, fy, fz = repulsion((0.069999, 0.0, 0.0), scene)
    assert fx == pytest.approx(params.gain_n / math.e, rel=1e-3)
    assert (fy, fz) == (0.0, 0.0)


def test_with_tails_the_force_goes_on_outside() -> None:
    scene = scene_of((), (ball(ORIGIN, 0.05),), FieldParams(truncated=False))
    fx, _, _ = repulsion((0.1, 0.0, 0.0), scene)
    assert fx == pytest.approx(10.0 * math.exp(-4.0))


def test_sigma_of_the_radius_itself_acts_as_a_ball_of_its_root() -> None:
    """The paper's words taken literally, Sigma = diag(r): 5 cm reach out to 22 cm."""
    literal = scene_of((), (ball(ORIGIN, math.sqrt(0.05)),), FieldParams())
    ours = scene_of((), (ball(ORIGIN, 0.05),), FieldParams())
    x = (0.22, 0.0, 0.0)
    assert repulsion(x, literal)[0] == pytest.approx(10.0 * math.exp(-(0.22**2) / 0.05))
    assert repulsion(x, ours) == NOTHING


def test_turned_ellipsoid_acts_along_its_own_axes() -> None:
    turned = Ellipsoid(
        centre_m=ORIGIN, semi_axes_m=(0.1, 0.02, 0.02), rotation=turn((0.0, 0.0, math.pi / 2))
    )
    scene = scene_of((), (turned,), FieldParams())
    assert repulsion((0.05, 0.0, 0.0), scene) == NOTHING
    assert repulsion((0.0, 0.05, 0.0), scene)[1] == pytest.approx(10.0 * math.exp(-0.25))


def test_force_points_away_from_the_centre_and_not_along_the_normal() -> None:
    item = Ellipsoid(centre_m=ORIGIN, semi_axes_m=(0.1, 0.02, 0.02))
    fx, fy, _ = repulsion((0.05, 0.01, 0.0), scene_of((), (item,), FieldParams()))
    assert fy / fx == pytest.approx(0.2)


def test_centre_of_an_obstacle_has_no_direction_and_no_force() -> None:
    scene = scene_of((), (ball((0.1, 0.2, 0.3), 0.05),), FieldParams())
    assert repulsion((0.1, 0.2, 0.3), scene) == NOTHING


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_even_while_it_is_off(bad: float) -> None:
    with pytest.raises(NotFiniteError):
        scene_of((Target(position_m=(0.0, bad, 0.0), active=False),), (), FieldParams())
    with pytest.raises(NotFiniteError):
        scene_of((), (ball((bad, 0.0, 0.0), 0.05),), FieldParams())
    with pytest.raises(NotFiniteError):
        scene_of((), (ball(ORIGIN, bad),), FieldParams())


def test_obstacle_without_volume_is_refused() -> None:
    with pytest.raises(FieldError, match="positive semi-axes"):
        scene_of((), (ball(ORIGIN, 0.0),), FieldParams())


@pytest.mark.parametrize(
    "rows",
    [
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),  # a mirror
        ((2.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0)),
    ],
)
def test_axes_that_are_no_rotation_are_refused(rows: Rows) -> None:
    with pytest.raises(FieldError, match="rotation"):
        scene_of(
            (),
            (Ellipsoid(centre_m=ORIGIN, semi_axes_m=(0.1, 0.1, 0.1), rotation=rows),),
            FieldParams(),
        )


def test_negative_constants_are_refused_by_name() -> None:
    with pytest.raises(FieldError, match="margin"):
        FieldParams(margin_m=-0.01)
    with pytest.raises(FieldError, match="gain"):
        FieldParams(gain_n=math.nan)
    with pytest.raises(FieldError, match="stiffness"):
        scene_of((Target(position_m=ORIGIN, stiffness_n_m=-1.0),), (), FieldParams())
