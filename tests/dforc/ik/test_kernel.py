"""The compiled parts of the search, each against something independent of it."""

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Matrix, Vector
from dforc.ik.kernel_chain import chain_arrays, place_chain
from dforc.ik.kernel_cost import (
    CONDITION,
    COST,
    Chains,
    Geometry,
    Goal,
    Multipliers,
    cost,
    expand,
    rotation_vector,
)
from dforc.robot_model import RobotModel

STEP = 1e-6


def test_chain_ends_where_the_model_says(model: RobotModel, postures: list[Vector]) -> None:
    chain = chain_arrays(model.chain_description())
    axes, origins = np.zeros((11, 3)), np.zeros((14, 3))
    for q in postures[:20]:
        place_chain(q, chain.joints, chain.turns, chain.places, axes, origins)
        R, p = model.tip_pose(q)
        assert origins[10] == pytest.approx(p, abs=1e-13)
        assert origins[11:] == pytest.approx(R, abs=1e-13)
        J = model.tip_jacobian(q)
        assert pytest.approx(J[3:], abs=1e-12) == axes[:10].T
        assert pytest.approx(J[:3], abs=1e-12) == np.cross(axes[:10], p - origins[:10]).T


@pytest.mark.parametrize(
    "vector",
    [
        [0.0, 0.0, 0.0],
        [1e-9, 0.0, -1e-9],
        [0.3, -0.2, 0.9],
        [np.pi, 0.0, 0.0],
        [0.0, -np.pi, 0.0],
        [np.pi * 0.6, 0.0, np.pi * 0.8],
        [0.0, 3.1415926, 0.0],
    ],
)
def test_rotation_vector_is_exact_up_to_half_a_turn(vector: list[float]) -> None:
    R, found = rotation.matrix(vector), np.zeros(3)
    k, b = rotation_vector(R, found)
    assert rotation.matrix(found) == pytest.approx(R, abs=1e-8)
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(vector), abs=1e-7)
    angle = np.linalg.norm(vector)
    if angle > 1e-3:
        assert k == pytest.approx(0.5 * angle / np.tan(0.5 * angle), abs=1e-6)
        assert b == pytest.approx((1.0 - k) / angle**2, abs=1e-6)


def goal_of(model: RobotModel, q: Vector, roles: tuple[int, int], proximal: float) -> Goal:
    R, p = model.tip_pose(q)
    turned = rotation.matrix([0.4, -0.3, 0.5]) @ R
    return Goal(
        positions=(p + np.array([0.03, -0.02, 0.05]))[None],
        rotations=turned.reshape(1, 9).copy(),
        roles=np.array([roles]),
        weights=np.array([100.0, 1.0]),
        radii=np.array([0.02, 0.1]),
        nearest=np.array([1e5, 1e3]),
        rest=q + 0.2,
        stiffness=np.full(10, 0.01),
        start=q - 0.1,
        proximal=np.array([proximal]),
    )


def expanded(
    model: RobotModel, q: Vector, roles: tuple[int, int], radii: tuple[float, float], free: Vector
) -> tuple[Vector, Matrix, Vector, Matrix]:
    """Gradient and Hessian by `expand`, and by central differences of `cost` and of the first."""
    chain = chain_arrays(model.chain_description())
    chains = Chains(np.array([10]), chain.joints[None], chain.turns[None], chain.places[None])
    goal = goal_of(model, q, roles, 0.03)
    y = np.array([[[0.7, -0.4, 0.2], [0.1, 0.3, -0.2]]])
    multipliers = Multipliers(y, np.array([50.0, 5.0]), np.array(radii))
    geometry = Geometry(
        np.zeros((11, 3)),
        np.zeros((14, 3)),
        np.zeros((10, 3)),
        np.zeros((1, 2, 3)),
        np.zeros((3, 3)),
    )
    indices = free.astype(np.int64)
    slots = np.full(10, -1)
    slots[indices] = np.arange(len(indices))

    def at(posture: Vector) -> tuple[Vector, Matrix]:
        f = len(indices)
        g, H, B = np.zeros(f), np.zeros((f, f)), np.zeros((f, f))
        expand(posture, chains, goal, multipliers, geometry, indices, slots, g, H, B)
        lower = H + B
        return g, lower + np.tril(lower, -1).T

    g, H = at(q)
    g_by_differences, H_by_differences = np.zeros_like(g), np.zeros_like(H)
    for column, joint in enumerate(indices):
        step = np.zeros(10)
        step[joint] = STEP
        ahead = cost(q + step, chains, goal, multipliers, geometry)
        behind = cost(q - step, chains, goal, multipliers, geometry)
        g_by_differences[column] = (ahead - behind) / (2.0 * STEP)
        H_by_differences[:, column] = (at(q + step)[0] - at(q - step)[0]) / (2.0 * STEP)
    return g, H, g_by_differences, H_by_differences


@pytest.mark.parametrize("radii", [(0.0, 0.0), (0.02, 0.1)])
@pytest.mark.parametrize("free", [np.arange(10), np.array([0, 3, 4, 7, 9])])
def test_derivatives_are_exact_where_position_is_the_condition(
    model: RobotModel, postures: list[Vector], radii: tuple[float, float], free: Vector
) -> None:
    for q in postures[:5]:
        g, H, g_d, H_d = expanded(model, q, (CONDITION, COST), radii, free)
        assert g == pytest.approx(g_d, abs=1e-6)
        assert pytest.approx(H_d, abs=1e-5) == H


def test_gradient_is_exact_where_orientation_is_the_condition(
    model: RobotModel, postures: list[Vector]
) -> None:
    for q in postures[:5]:
        g, H, g_d, H_d = expanded(model, q, (COST, CONDITION), (0.0, 0.1), np.arange(10.0))
        assert g == pytest.approx(g_d, abs=1e-6)
        # The bending of a rotation that is a condition is taken for small angles.
        assert np.abs(H - H_d).max() < 0.5 * np.abs(H_d).max()
