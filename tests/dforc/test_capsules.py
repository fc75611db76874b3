"""Distances of the limb's capsules, by hand and against sampling."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.capsules import (
    ICUB_RIGHT_ARM,
    Capsule,
    CapsuleError,
    arm_clearance,
    clearances,
)
from dforc.errors import NotFiniteError
from dforc.robot_model import RobotModel

STRAIGHT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
TIP_M = np.array([1.0, 1.0, 0.0])
PIECES = (
    Capsule(name="upper", start="a", end="b", radius_m=0.1),
    Capsule(name="hand", start="b", end="tip", radius_m=0.05),
)


def apart(centre: tuple[float, float, float]) -> dict[str, float]:
    return clearances(PIECES, ("a", "b"), STRAIGHT, TIP_M, centre, 0.2)


def test_distance_is_measured_beside_a_segment_and_beyond_its_ends() -> None:
    assert apart((0.5, 0.0, 0.7))["upper"] == pytest.approx(0.7 - 0.1 - 0.2)
    assert apart((-0.3, 0.0, 0.4))["upper"] == pytest.approx(0.5 - 0.1 - 0.2)
    assert apart((1.0, 1.6, 0.0))["hand"] == pytest.approx(0.6 - 0.05 - 0.2)


def test_overlap_is_negative() -> None:
    assert apart((1.0, 0.5, 0.0))["hand"] == pytest.approx(-0.25)


def test_arm_clearance_is_the_smallest_of_a_dense_sampling(
    model: RobotModel, postures: list[Vector]
) -> None:
    rng = np.random.default_rng(6)
    for q in postures[:10]:
        origins, tip = model.joint_positions(q), model.tip_pose(q)[1]
        centre = tip + rng.normal(size=3) * 0.1
        points = dict(zip((*model.joints, "tip"), [*origins, tip], strict=True))
        sampled = min(
            float(np.linalg.norm(a + s * (b - a) - centre)) - piece.radius_m
            for piece in ICUB_RIGHT_ARM
            for a, b in [(points[piece.start], points[piece.end])]
            for s in np.linspace(0.0, 1.0, 2001)
        )
        found = arm_clearance(model.joints, origins, tip, centre, 0.05)
        assert found == pytest.approx(sampled - 0.05, abs=1e-5)


def test_capsule_of_an_unknown_joint_is_named_with_what_there_is() -> None:
    wrong = (Capsule(name="tail", start="a", end="c", radius_m=0.1),)
    with pytest.raises(CapsuleError, match=r"'tail'.*'c'.*a, b, tip"):
        clearances(wrong, ("a", "b"), STRAIGHT, TIP_M, (0.0, 0.0, 0.0), 0.1)


def test_what_is_not_finite_is_refused() -> None:
    with pytest.raises(NotFiniteError):
        apart((np.nan, 0.0, 0.0))
    with pytest.raises(NotFiniteError):
        clearances(PIECES, ("a", "b"), STRAIGHT, TIP_M * np.nan, (0.0, 0.0, 0.0), 0.2)
