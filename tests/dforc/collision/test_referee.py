"""The same distances as coal, pinocchio's collision library, finds by its own methods."""

from collections.abc import Callable

import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.collision.obstacles import Obstacle, Shape, world_of
from dforc.robot_model import RobotModel
from tests.dforc.collision.bodies import (
    CAPSULES,
    JOINTS,
    URDF,
    Room,
    make_body,
    random_obstacles,
    random_postures,
)

coal = pytest.importorskip("coal")

TOLERANCE_M = 1e-6  # coal's own is set to 1e-9, its result for curved shapes is coarser


def solid(obstacle: Obstacle) -> object:
    a, b, c = obstacle.size_m
    made: dict[Shape, Callable[[], object]] = {
        Shape.SPHERE: lambda: coal.Sphere(a),
        Shape.ELLIPSOID: lambda: coal.Ellipsoid(a, b, c),
        Shape.BOX: lambda: coal.Box(2.0 * a, 2.0 * b, 2.0 * c),
        Shape.CYLINDER: lambda: coal.Cylinder(a, 2.0 * b),
    }
    return made[obstacle.shape]()


def capsule_between(a: Vector, b: Vector, radius_m: float) -> tuple[object, object]:
    """A capsule of coal is along z, around its middle."""
    length = float(np.linalg.norm(b - a))
    z = (b - a) / length
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    R = np.column_stack([x, np.cross(z, x), z])
    return coal.Capsule(radius_m, length), coal.Transform3s(R, 0.5 * (a + b))


def apart(one: object, at: object, other: object, other_at: object) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance = 1e-9
    return float(coal.distance(one, at, other, other_at, request, result))


def capsules_at(q: Vector) -> list[tuple[object, object]]:
    """Every capsule where pinocchio has its link."""
    placed = []
    for capsule in CAPSULES:
        R, p = RobotModel(URDF, JOINTS, capsule.link, {}).tip_pose(q)
        ends: Matrix = np.array([capsule.start_m, capsule.end_m]) @ R.T + p
        placed.append(capsule_between(ends[0], ends[1], capsule.radius_m))
    return placed


@pytest.mark.parametrize("seed", range(5))
def test_distances_from_obstacles_and_within_the_body_are_coals(seed: int) -> None:
    obstacles = random_obstacles(12, seed=100 + seed)
    room = Room(make_body(), rows=200)
    q = random_postures(1, seed=seed)[0]
    near = room.near(q, world_of(obstacles))
    placed = capsules_at(q)
    checked = 0
    for (i, other), (far, _, _) in near.items():
        if far < 0.0:
            continue  # how deep two solids are in each other is another question there
        if other >= 0:
            obstacle = obstacles[other]
            at = coal.Transform3s(np.array(obstacle.rotation), np.array(obstacle.position_m))
            found = apart(*placed[i], solid(obstacle), at)
        else:
            found = apart(*placed[i], *placed[-1 - other])
        assert far == pytest.approx(found, abs=TOLERANCE_M)
        checked += 1
    assert checked > 60


@pytest.mark.parametrize("seed", range(5))
def test_coal_sees_contact_where_a_distance_is_negative(seed: int) -> None:
    obstacles = random_obstacles(12, seed=200 + seed)
    room = Room(make_body(), rows=200)
    q = random_postures(1, seed=seed)[0]
    placed = capsules_at(q)
    for (i, other), (far, _, _) in room.near(q, world_of(obstacles)).items():
        if other >= 0 and abs(far) > TOLERANCE_M:
            obstacle = obstacles[other]
            at = coal.Transform3s(np.array(obstacle.rotation), np.array(obstacle.position_m))
            found = coal.collide(
                *placed[i], solid(obstacle), at, coal.CollisionRequest(), coal.CollisionResult()
            )
            assert bool(found) == (far < 0.0)
