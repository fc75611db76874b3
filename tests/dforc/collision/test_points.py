"""Signed distances of points: by hand, against 50 digits, and by their properties."""

from decimal import Decimal, localcontext

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.collision.kernel_points import BOX, CYLINDER, ELLIPSOID, SPHERE, own_distance
from dforc.collision.kernel_shapes import point_distance, world_distance
from dforc.collision.obstacles import box, ellipsoid, sphere, world_of

KINDS = (SPHERE, ELLIPSOID, BOX, CYLINDER)
SIZE = {
    SPHERE: (0.1, 0.0, 0.0),
    ELLIPSOID: (0.1, 0.2, 0.05),
    BOX: (0.1, 0.2, 0.05),
    CYLINDER: (0.1, 0.2, 0.0),
}


def distance(kind: int, size: tuple[float, float, float], x: Vector) -> tuple[float, Vector]:
    found = own_distance(kind, *size, *x.tolist())
    return found[0], np.array(found[1:])


@pytest.mark.parametrize(
    ("kind", "point", "expected", "normal"),
    [
        (SPHERE, (0.3, 0.0, 0.4), 0.4, (0.6, 0.0, 0.8)),
        (SPHERE, (0.0, 0.0, 0.0), -0.1, (0.0, 0.0, 1.0)),
        (BOX, (0.13, -0.24, 0.0), 0.05, (0.6, -0.8, 0.0)),
        (BOX, (0.0, 0.0, 0.3), 0.25, (0.0, 0.0, 1.0)),
        (BOX, (0.09, 0.0, 0.0), -0.01, (1.0, 0.0, 0.0)),
        (BOX, (0.0, 0.0, 0.0), -0.05, (0.0, 0.0, 1.0)),
        (CYLINDER, (0.0, 0.13, 0.24), 0.05, (0.0, 0.6, 0.8)),
        (CYLINDER, (0.3, 0.0, 0.1), 0.2, (1.0, 0.0, 0.0)),
        (CYLINDER, (0.0, 0.0, -0.3), 0.1, (0.0, 0.0, -1.0)),
        (CYLINDER, (0.0, 0.0, 0.0), -0.1, (1.0, 0.0, 0.0)),
        (CYLINDER, (0.0, 0.0, 0.19), -0.01, (0.0, 0.0, 1.0)),
        (ELLIPSOID, (0.5, 0.0, 0.0), 0.4, (1.0, 0.0, 0.0)),
        (ELLIPSOID, (0.0, 0.199, 0.0), -0.001, (0.0, 1.0, 0.0)),
        (ELLIPSOID, (0.0, 0.0, 0.0), -0.05, (0.0, 0.0, 1.0)),
    ],
)
def test_distance_and_normal_are_those_worked_out_by_hand(
    kind: int,
    point: tuple[float, float, float],
    expected: float,
    normal: tuple[float, float, float],
) -> None:
    far, n = distance(kind, SIZE[kind], np.array(point))
    assert far == pytest.approx(expected, abs=1e-12)
    assert n == pytest.approx(normal, abs=1e-12)


def exact_distance(axes: Vector, x: Vector) -> float:
    """From an ellipsoid, by halving in 60 digits."""
    with localcontext() as context:
        context.prec = 60
        r = [Decimal(float(v)) for v in axes]
        y = [a * abs(Decimal(float(v))) for a, v in zip(r, x, strict=True)]
        over = [a * a - min(r) ** 2 for a in r]

        def pull(u: Decimal) -> Decimal:
            each = zip(y, over, strict=True)
            return sum(((a / (u + g)) ** 2 for a, g in each if a > 0), Decimal(0))

        low, high = max(a - g for a, g in zip(y, over, strict=True)), sum(y)
        u = Decimal(0)
        if low > 0 or pull(u) > 1:
            low = max(low, Decimal(0))
            for _ in range(190):
                u = (low + high) / 2
                low, high = (u, high) if pull(u) >= 1 else (low, u)
        near = [
            a * b / (u + g) if b > 0 else Decimal(0) for a, b, g in zip(r, y, over, strict=True)
        ]
        missing = 1 - sum(((p / a) ** 2 for p, a in zip(near, r, strict=True)), Decimal(0))
        if u == 0 and missing > 0:
            smallest = over.index(Decimal(0))
            near[smallest] = r[smallest] * missing.sqrt()
        away = sum(
            ((p - abs(Decimal(float(v)))) ** 2 for p, v in zip(near, x, strict=True)), Decimal(0)
        )
        return float(away.sqrt().copy_sign(u - min(r) ** 2))


def test_ellipsoids_of_any_flatness_are_exact_inside_outside_and_on_their_axes() -> None:
    rng = np.random.default_rng(5)
    for _ in range(400):
        axes = 10.0 ** rng.uniform(-4.0, 0.0, 3)
        x = rng.normal(size=3) * 10.0 ** rng.uniform(-5.0, 0.5)
        x[rng.random(3) < 0.25] = 0.0
        if rng.random() < 0.3:
            axes[1] = axes[0]  # a disc or a rod
        far, n = distance(ELLIPSOID, (axes[0], axes[1], axes[2]), x)
        assert far == pytest.approx(exact_distance(axes, x), abs=1e-14, rel=1e-14)
        assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("tiny", [1e-12, 1e-100, 1e-200, 1e-300])
def test_a_hair_beside_the_axis_of_an_ellipsoid_is_as_on_it(tiny: float) -> None:
    on_axis, _ = distance(ELLIPSOID, SIZE[ELLIPSOID], np.array([0.03, 0.0, 0.0]))
    beside, n = distance(ELLIPSOID, SIZE[ELLIPSOID], np.array([0.03, 0.0, tiny]))
    assert beside == pytest.approx(on_axis, abs=1e-11)
    assert np.linalg.norm(n) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_going_back_along_the_normal_ends_on_the_surface(kind: int) -> None:
    rng = np.random.default_rng(6)
    for x in rng.normal(size=(300, 3)) * 0.2:
        far, n = distance(kind, SIZE[kind], x)
        assert distance(kind, SIZE[kind], x - far * n)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_the_normal_is_the_gradient_of_the_distance(kind: int) -> None:
    rng = np.random.default_rng(7)
    h = 1e-6
    for x in rng.normal(size=(200, 3)) * 0.2:
        _, n = distance(kind, SIZE[kind], x)
        slope = [
            (distance(kind, SIZE[kind], x + e)[0] - distance(kind, SIZE[kind], x - e)[0]) / (2 * h)
            for e in h * np.eye(3)
        ]
        assert slope == pytest.approx(n, abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_distance_never_changes_faster_than_the_point_moves(kind: int) -> None:
    rng = np.random.default_rng(8)
    for x, y in rng.normal(size=(500, 2, 3)) * 0.2:
        apart = distance(kind, SIZE[kind], x)[0] - distance(kind, SIZE[kind], y)[0]
        assert abs(apart) <= np.linalg.norm(x - y) + 1e-12


def test_a_turned_and_shifted_solid_is_measured_in_its_own_axes() -> None:
    quarter = np.array([0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])  # its x is y of the base
    normal = np.zeros(3)
    point, centre = np.array([1.0, 0.5, 0.0]), np.array([1.0, 0.2, 0.0])
    far = point_distance(BOX, np.array([0.1, 0.02, 0.05]), quarter, centre, point, normal)
    assert far == pytest.approx(0.2)
    assert normal.tolist() == [0.0, 1.0, 0.0]


def test_the_nearest_obstacle_and_its_margin_make_the_distance_to_the_world() -> None:
    obstacles = [
        box("far", (2.0, 0.0, 0.0), (0.1, 0.1, 0.1)),
        sphere("near", (0.0, 0.0, 0.5), 0.1),
        ellipsoid("aside", (0.0, 1.0, 0.0), (0.1, 0.1, 0.1)),
    ]
    world = world_of(obstacles)
    assert world_distance(np.zeros(3), world) == pytest.approx(0.4)
    wider = world._replace(margins=np.array([0.0, 0.0, 0.6]))
    assert world_distance(np.zeros(3), wider) == pytest.approx(0.3)
    assert world_distance(np.zeros(3), world_of([])) == np.inf
