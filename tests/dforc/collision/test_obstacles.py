"""What may be an obstacle, and the arrays of several."""

from dataclasses import replace

import numpy as np
import pytest

from dforc.collision.obstacles import (
    Obstacle,
    ObstacleError,
    Shape,
    Triple,
    box,
    cylinder,
    ellipsoid,
    mesh_bounds,
    sphere,
    world_of,
)

BALL = sphere("ball", (0.1, 0.2, 0.3), 0.05)
QUARTER_ABOUT_Z = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    "size",
    [
        (0.0, 0.0, 0.0),
        (-0.1, 0.0, 0.0),
        (0.1, 0.1, 0.0),
        (float("nan"), 0.0, 0.0),
        (float("inf"), 0.0, 0.0),
    ],
)
def test_a_ball_without_one_positive_radius_is_refused(size: Triple) -> None:
    with pytest.raises(ObstacleError, match="'ball'"):
        replace(BALL, size_m=size)


def test_a_box_needs_three_edges_and_a_cylinder_two_numbers() -> None:
    with pytest.raises(ObstacleError, match="first 3 must be positive"):
        box("crate", (0.0, 0.0, 0.0), (0.1, 0.1, 0.0))
    with pytest.raises(ObstacleError, match="first 2 must be positive"):
        cylinder("pole", (0.0, 0.0, 0.0), 0.1, 0.0)


def test_a_mirror_and_a_stretch_are_no_rotations() -> None:
    with pytest.raises(ObstacleError, match="mirror"):
        replace(BALL, rotation=((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    with pytest.raises(ObstacleError, match="no rotation"):
        replace(BALL, rotation=((1.1, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def test_a_place_velocity_or_margin_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ObstacleError, match="position_m"):
        replace(BALL, position_m=(float("nan"), 0.0, 0.0))
    with pytest.raises(ObstacleError, match="velocity_m_s"):
        replace(BALL, velocity_m_s=(0.0, float("inf"), 0.0))
    with pytest.raises(ObstacleError, match="margin_m"):
        replace(BALL, margin_m=-0.01)


def test_no_obstacles_make_an_empty_world() -> None:
    world = world_of([])
    assert world.kinds.shape == (0,)
    assert world.sizes.shape == world.centres.shape == world.velocities.shape == (0, 3)
    assert world.rotations.shape == (0, 9)


def test_a_world_has_one_row_per_obstacle_in_their_order() -> None:
    pole = cylinder("pole", (1.0, 2.0, 3.0), 0.03, 0.4, QUARTER_ABOUT_Z)
    moving = replace(BALL, velocity_m_s=(0.0, 0.0, -0.4), margin_m=0.02)
    egg = ellipsoid("egg", (0.0, 0.0, 0.0), (0.1, 0.3, 0.2))
    world = world_of([pole, moving, egg])
    assert world.kinds.tolist() == [Shape.CYLINDER, Shape.SPHERE, Shape.ELLIPSOID]
    assert world.sizes.tolist() == [[0.03, 0.4, 0.0], [0.05, 0.0, 0.0], [0.1, 0.3, 0.2]]
    assert world.rotations[0].tolist() == [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    assert world.centres[1].tolist() == [0.1, 0.2, 0.3]
    assert world.velocities.tolist() == [[0.0, 0.0, 0.0], [0.0, 0.0, -0.4], [0.0, 0.0, 0.0]]
    assert world.margins.tolist() == [0.0, 0.02, 0.0]
    assert world.reaches == pytest.approx([np.hypot(0.03, 0.4), 0.05, 0.3])


def test_bounds_of_a_turned_mesh_are_a_box_around_its_middle() -> None:
    corners = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.2, 0.6]])
    bounds = mesh_bounds("part", corners, (1.0, 0.0, 0.0), QUARTER_ABOUT_Z)
    assert bounds.shape is Shape.BOX
    assert bounds.size_m == pytest.approx((0.2, 0.1, 0.3))
    assert bounds.position_m == pytest.approx((0.9, 0.2, 0.3))  # x of the mesh is y of the base


def test_a_flat_mesh_gets_a_thin_box_and_no_mesh_none() -> None:
    sheet = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.2, 0.0]])
    assert mesh_bounds("sheet", sheet).size_m == pytest.approx((0.2, 0.1, 1e-4))
    with pytest.raises(ObstacleError, match="vertices"):
        mesh_bounds("nothing", np.zeros((0, 3)))


def test_an_obstacle_of_another_shape_keeps_its_numbers() -> None:
    crate = Obstacle(name="x", shape=Shape.BOX, size_m=(1.0, 2.0, 3.0), position_m=(0.0, 0.0, 0.0))
    assert world_of([crate]).reaches == pytest.approx([np.sqrt(14.0)])
