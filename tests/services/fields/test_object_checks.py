"""Which objects are taken, and why the others are not."""

import math

import msgspec
import pytest

from services.core.errors import ConfigError
from services.fields.object_checks import as_objects, check_object
from services.fields.seen import semi_axes_m, solid_of
from services.messages import Objects, Obstacle, WorldObject

BALL = WorldObject(name="ball", shape="sphere", size_m=(0.05,), position_m=(0.1, 0.2, 0.3))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"name": ""}, "a name has 1 to 64 letters"),
        ({"name": "a/b"}, "no '/'"),
        ({"shape": "blob"}, "unknown shape 'blob'; known: sphere, ellipsoid, box, cylinder, mesh"),
        ({"role": "friend"}, "unknown role 'friend'; known: obstacle, target"),
        ({"size_m": (0.0,)}, "size_m"),
        ({"size_m": (-0.1,)}, "size_m"),
        ({"size_m": (5.1,)}, "size_m of 5.1 is beyond 5"),
        ({"size_m": ()}, "size_m"),
        ({"size_m": (0.1, 0.1)}, "size_m"),
        ({"shape": "box", "size_m": (0.1, 0.1)}, "size_m"),
        ({"position_m": (math.nan, 0.0, 0.0)}, "position_m is not finite"),
        ({"position_m": (0.0, 101.0, 0.0)}, "position_m of 101 is beyond 100"),
        ({"rotation_rad": (0.0, 0.0, math.inf)}, "rotation_rad is not finite"),
        ({"velocity_m_s": (0.0, 0.0, math.nan)}, "velocity_m_s is not finite"),
        ({"covariance_m2": (1e-4, 0.0, 0.0)}, "covariance_m2 has 6 numbers"),
        ({"covariance_m2": (-1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)}, "a negative variance"),
        ({"covariance_m2": (0.36, 0.0, 0.0, 0.0, 0.0, 0.0)}, "a place known to 0.6 m"),
        ({"shape": "mesh", "size_m": ()}, "a mesh has 1 to 100000 vertices_m"),
        ({"seen_ns": -1}, "seen_ns of -1 is before all time"),
    ],
)
def test_an_object_that_is_none_is_refused_by_name(change: dict[str, object], why: str) -> None:
    item = msgspec.structs.replace(BALL, **change)
    with pytest.raises(ConfigError) as caught:
        check_object(item)
    assert why in str(caught.value)
    assert repr(item.name) in str(caught.value)


def test_every_shape_is_taken() -> None:
    for shape, size_m in (
        ("sphere", (0.1,)),
        ("sphere", (0.1, 0.0, 0.0)),
        ("ellipsoid", (0.1, 0.2, 0.3)),
        ("box", (0.1, 0.2, 0.3)),
        ("cylinder", (0.1, 0.2)),
    ):
        check_object(msgspec.structs.replace(BALL, shape=shape, size_m=size_m))


def test_a_mesh_is_the_box_about_its_vertices() -> None:
    item = msgspec.structs.replace(
        BALL,
        shape="mesh",
        size_m=(),
        rotation_rad=(0.0, 0.0, math.pi / 2),
        vertices_m=((0.0, 0.0, 0.0), (0.2, 0.1, 0.4)),
    )
    check_object(item)
    solid = solid_of(item)
    assert solid.size_m == pytest.approx((0.1, 0.05, 0.2))
    # its own (0.1, 0.05, 0.2), turned by 90 degrees about z
    assert solid.position_m == pytest.approx((0.1 - 0.05, 0.2 + 0.1, 0.3 + 0.2))


def test_balls_of_the_short_form_are_objects_at_rest() -> None:
    message = Objects(stamp_ns=0, obstacles=(Obstacle((0.1, 0.2, 0.3), 0.05),), objects=(BALL,))
    first, second = as_objects(message)
    assert (first.name, first.size_m, first.velocity_m_s) == ("ball 1", (0.05,), (0.0, 0.0, 0.0))
    assert second == BALL


def test_the_paper_s_ellipsoid_holds_the_corners_of_a_box_and_the_rims_of_a_cylinder() -> None:
    box = solid_of(msgspec.structs.replace(BALL, shape="box", size_m=(0.1, 0.2, 0.3)))
    a, b, c = semi_axes_m(box)
    assert (0.1 / a) ** 2 + (0.2 / b) ** 2 + (0.3 / c) ** 2 == pytest.approx(1.0)
    cylinder = solid_of(msgspec.structs.replace(BALL, shape="cylinder", size_m=(0.1, 0.3)))
    a, _, c = semi_axes_m(cylinder)
    assert (0.1 / a) ** 2 + (0.3 / c) ** 2 == pytest.approx(1.0)
