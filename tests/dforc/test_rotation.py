"""Rotations: round trips, near zero and near half a turn too."""

import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from dforc.errors import NotFiniteError


def unit_axes() -> list[Vector]:
    rng = np.random.default_rng(0)
    drawn = list(rng.normal(size=(20, 3))) + list(np.eye(3))
    return [axis / np.linalg.norm(axis) for axis in drawn]


@pytest.mark.parametrize("angle_rad", [0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.0, np.pi - 1e-9])
def test_rotation_vector_comes_back(angle_rad: float) -> None:
    for axis in unit_axes():
        again = rotation.rotation_vector(rotation.matrix(axis * angle_rad))
        assert again == pytest.approx(axis * angle_rad, abs=1e-14 + 1e-15 / (np.pi - angle_rad))


def test_half_a_turn_comes_back_up_to_its_direction() -> None:
    for axis in unit_axes():
        again = rotation.rotation_vector(rotation.matrix(axis * np.pi))
        assert abs(float(again @ axis)) == pytest.approx(np.pi, abs=1e-9)


def test_matrix_turns_a_quarter_about_z() -> None:
    turned = rotation.matrix((0.0, 0.0, np.pi / 2)) @ np.array([1.0, 0.0, 0.0])
    assert turned == pytest.approx([0.0, 1.0, 0.0])


def test_quaternion_comes_back() -> None:
    for axis in unit_axes():
        R = rotation.matrix(axis * 2.9)
        w, x, y, z = rotation.quaternion(R)
        assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
        assert w >= 0.0
        assert rotation.matrix_from_quaternion((w, x, y, z)) == pytest.approx(R, abs=1e-14)


def test_error_turns_the_first_orientation_into_the_second() -> None:
    a, b = rotation.matrix((0.3, -0.2, 0.9)), rotation.matrix((-1.0, 0.4, 0.1))
    error = rotation.rotation_error(a, b)
    assert rotation.matrix(error) @ a == pytest.approx(b, abs=1e-14)
    assert rotation.angle_between(a, b) == pytest.approx(float(np.linalg.norm(error)))


@pytest.mark.parametrize("size_rad", [float("nan"), float("inf"), 1e200])
def test_vector_that_is_not_finite_is_refused(size_rad: float) -> None:
    with pytest.raises(NotFiniteError):
        rotation.matrix((size_rad, 0.0, 0.0))
