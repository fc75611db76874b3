"""Nearest points of segments: to solids, to each other."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.collision.kernel_points import BOX, CYLINDER, ELLIPSOID, SPHERE, own_distance
from dforc.collision.kernel_segments import segments_apart
from dforc.collision.kernel_shapes import is_segment_free, segment_distance
from dforc.collision.obstacles import box, cylinder, sphere, world_of
from tests.dforc.collision.bodies import along

KINDS = (SPHERE, ELLIPSOID, BOX, CYLINDER)
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
IDENTITY = np.eye(3).ravel()


def at(kind: int, size: Vector, x: Vector) -> float:
    return own_distance(kind, *size.tolist(), *x.tolist())[0]


def by_golden_section(kind: int, size: Vector, a: Vector, b: Vector) -> float:
    low, high = 0.0, 1.0
    for _ in range(60):
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        if at(kind, size, a + left * (b - a)) <= at(kind, size, a + right * (b - a)):
            high = right
        else:
            low = left
    return min(at(kind, size, a + t * (b - a)) for t in (0.0, 0.5 * (low + high), 1.0))


@pytest.mark.parametrize("kind", KINDS)
def test_no_point_of_a_segment_is_nearer_than_the_one_found(kind: int) -> None:
    rng = np.random.default_rng(kind)
    for _ in range(400):
        size = 10.0 ** rng.uniform(-2.5, -0.5, 3)
        a, b = rng.normal(size=(2, 3)) * 10.0 ** rng.uniform(-2.0, 0.0, (2, 1))
        axis = rng.integers(3)
        if rng.random() < 0.3:
            b[axis] = a[axis]  # along a face
        if rng.random() < 0.1:
            a[axis] = b[axis] = 0.0
        if rng.random() < 0.1:
            b = -a  # through the centre
        far, share, n = along(kind, size, a, b)
        assert far == pytest.approx(by_golden_section(kind, size, a, b), abs=1e-12)
        assert far == pytest.approx(at(kind, size, a + share * (b - a)), abs=1e-14)
        assert np.linalg.norm(n) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_segment_of_no_length_is_a_point(kind: int) -> None:
    size, x = np.array([0.1, 0.2, 0.05]), np.array([0.2, 0.3, -0.1])
    far, _, n = along(kind, size, x, x)
    expected = own_distance(kind, *size.tolist(), *x.tolist())
    assert far == expected[0]
    assert tuple(n) == expected[1:]


def test_a_segment_through_a_box_is_as_deep_as_its_deepest_point() -> None:
    normal = np.zeros(3)
    far, share = segment_distance(
        BOX,
        np.array([0.1, 0.2, 0.05]),
        IDENTITY,
        np.zeros(3),
        np.array([0.07, 0.0, -1.0]),
        np.array([0.07, 0.0, 1.0]),
        normal,
    )
    assert far == pytest.approx(-0.03)
    assert normal.tolist() == [1.0, 0.0, 0.0]
    assert abs(share - 0.5) <= 0.01  # anywhere 3 cm below the side and no less below the ends


def test_the_share_counts_from_the_first_end() -> None:
    normal = np.zeros(3)
    far, share = segment_distance(
        SPHERE,
        np.array([0.1, 0.0, 0.0]),
        IDENTITY,
        np.array([0.25, 0.0, 0.5]),
        np.zeros(3),
        np.array([1.0, 0.0, 0.0]),
        normal,
    )
    assert (far, share) == pytest.approx((0.4, 0.25))
    assert normal == pytest.approx([0.0, 0.0, -1.0])


@pytest.mark.parametrize("kind", KINDS)
def test_a_distance_that_is_enough_is_not_below_it_and_a_smaller_one_is_exact(kind: int) -> None:
    rng = np.random.default_rng(20 + kind)
    size = np.array([0.1, 0.2, 0.15])
    for a, b in rng.normal(size=(300, 2, 3)) * 0.4:
        exact = along(kind, size, a, b)[0]
        rough = along(kind, size, a, b, 0.05)[0]
        if exact < 0.05:
            assert rough == pytest.approx(exact, abs=1e-12)
        else:
            assert rough >= exact - 1e-12


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ("0 0 0  1 0 0   0 0 1  0 1 1", (1.0, 0.0, 0.0)),
        ("0 0 0  1 0 0   0.5 -1 0.2  0.5 1 0.2", (0.2, 0.5, 0.5)),
        ("0 0 0  1 0 0   2 1 0  2 2 0", (np.sqrt(2.0), 1.0, 0.0)),
        ("0 0 0  0 0 0   0 3 4  0 3 4", (5.0, 0.0, 0.0)),
        ("0 0 0  0 0 0   -1 1 0  1 1 0", (1.0, 0.0, 0.5)),
        ("-1 1 0  1 1 0   0 0 0  0 0 0", (1.0, 0.5, 0.0)),
        ("0 0 0  1 0 0   0.5 0 0  0.5 1 0", (0.0, 0.5, 0.0)),
    ],
)
def test_segments_are_as_far_apart_as_worked_out_by_hand(
    ends: str, expected: tuple[float, float, float]
) -> None:
    assert segments_apart(*map(float, ends.split())) == pytest.approx(expected)


def test_parallel_segments_side_by_side_are_their_lines_apart() -> None:
    apart, s, t = segments_apart(0, 0, 0, 1, 0, 0, 0.5, 0.3, 0, 3, 0.3, 0)
    assert apart == pytest.approx(0.3)
    assert s - 0.5 == pytest.approx(t * 2.5)


def test_no_two_points_of_two_segments_are_nearer_than_those_found() -> None:
    rng = np.random.default_rng(9)
    grid = np.linspace(0.0, 1.0, 41)
    for _ in range(500):
        a, b, c, d = rng.normal(size=(4, 3))
        if rng.random() < 0.3:
            d = c + (b - a) * rng.normal() + rng.normal(size=3) * 10.0 ** rng.uniform(-12.0, 0.0)
        apart, s, t = segments_apart(*np.concatenate([a, b, c, d]).tolist())
        on_first = a + grid[:, None] * (b - a)
        on_second = c + grid[:, None] * (d - c)
        between = np.linalg.norm(on_first[:, None] - on_second[None], axis=2)
        assert apart <= between.min() + 1e-7
        found = np.linalg.norm(a + s * (b - a) - c - t * (d - c))
        assert apart == pytest.approx(float(found), abs=1e-14)


def test_a_segment_is_free_as_long_as_all_of_it_keeps_the_clearance() -> None:
    world = world_of(
        [
            box("wall", (0.0, 0.0, 0.0), (0.01, 1.0, 1.0)),
            cylinder("pole", (1.0, 0.0, 0.0), 0.05, 1.0),
        ]
    )
    a, b = np.array([0.2, 0.0, 0.0]), np.array([0.2, 0.5, 0.0])
    assert is_segment_free(a, b, world, 0.18)
    assert not is_segment_free(a, b, world, 0.2)
    assert not is_segment_free(a, -a, world, 0.0)  # the wall is thin, and between the two ends
    assert is_segment_free(a, -a, world_of([]), 10.0)


def test_an_obstacles_own_margin_is_kept_free_too() -> None:
    world = world_of([sphere("ball", (0.0, 0.0, 0.0), 0.1)])
    a, b = np.array([-1.0, 0.0, 0.2]), np.array([1.0, 0.0, 0.2])
    assert is_segment_free(a, b, world, 0.09)
    assert not is_segment_free(a, b, world._replace(margins=np.array([0.02])), 0.09)
