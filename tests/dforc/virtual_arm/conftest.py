"""An arm of three links in a plane, small enough to see what it can do."""

import numpy as np
import pytest

from dforc.collision.body import Body, BodyArrays
from dforc.limits import JointLimits

LINK_M, RADIUS_M = 0.2, 0.02


def flat_arm() -> Body:
    """Links of 20 cm and 2 cm radius along x, joints about z; the third may meet the first."""
    flat = np.tile(np.eye(3).ravel(), (3, 1))
    arrays = BodyArrays(
        parents=np.array([-1, 0, 1]),
        turns=flat,
        places=np.array([[0.0, 0.0, 0.0], [LINK_M, 0.0, 0.0], [LINK_M, 0.0, 0.0]]),
        carriers=np.array([0, 1, 2]),
        starts=np.zeros((3, 3)),
        ends=np.tile([LINK_M, 0.0, 0.0], (3, 1)),
        radii=np.full(3, RADIUS_M),
        pairs=np.array([[0, 2]]),
        tip_carriers=np.array([2]),
        tip_turns=flat[:1],
        tip_places=np.array([[LINK_M, 0.0, 0.0]]),
        halves=np.full(3, LINK_M / 2),
    )
    return Body(
        joints=("a", "b", "c"), capsules=("first", "second", "third"), tips=("hand",), arrays=arrays
    )


def bent_limits() -> JointLimits:
    """Ranges of 150 degrees to both sides, and a row: the last two bend 200 together."""
    bend = np.radians(150.0)
    row = np.radians(200.0)
    return JointLimits.make([-bend] * 3, [bend] * 3, np.array([[0.0, 1.0, 1.0]]), [-row], [row])


@pytest.fixture(scope="session")
def flat_body() -> Body:
    return flat_arm()


@pytest.fixture(scope="session")
def flat_limits() -> JointLimits:
    return bent_limits()
