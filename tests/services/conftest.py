"""What the tests of the services share."""

import numpy as np
import pytest

from dforc import rotation
from services.config import load_robot
from services.messages import CartesianStatus, JointState
from services.reaching.limb import limb_model
from services.reaching.tip_poses import vector3
from services.robotfile.robot_tables import RobotFile
from tests.services.postures import posture


@pytest.fixture(scope="session")
def robot() -> RobotFile:
    return load_robot("icub:reach")


@pytest.fixture
def home(robot: RobotFile) -> dict[str, JointState]:
    """States of all parts: at rest at home, in position-direct mode."""
    return posture(robot, np.radians(robot.reach.home_deg))


@pytest.fixture
def at_home(robot: RobotFile) -> CartesianStatus:
    """What the Cartesian controller tells of an arm at home that it does not move."""
    q_rad = np.radians(robot.reach.home_deg)
    turned, hand_m = limb_model(robot).tip_pose(q_rad)
    return CartesianStatus(
        stamp_ns=0,
        state="waiting",
        q_rad=tuple(q_rad.tolist()),
        hand_position_m=vector3(hand_m),
        hand_rotation_rad=vector3(rotation.rotation_vector(turned)),
    )
