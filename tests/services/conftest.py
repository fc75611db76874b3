"""What the tests of the services share."""

import numpy as np
import pytest

from services.config import load_robot
from services.messages import JointState
from services.robot_tables import RobotFile
from tests.services.postures import posture


@pytest.fixture(scope="session")
def robot() -> RobotFile:
    return load_robot("icub")


@pytest.fixture
def home(robot: RobotFile) -> dict[str, JointState]:
    """States of all parts: at rest at home, in position-direct mode."""
    return posture(robot, np.radians(robot.reach.home_deg))
