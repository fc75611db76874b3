"""The iCub's torso and right arm, for every test of the numerics."""

import icub_models
import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

JOINTS = (
    "torso_pitch",
    "torso_roll",
    "torso_yaw",
    "r_shoulder_pitch",
    "r_shoulder_roll",
    "r_shoulder_yaw",
    "r_elbow",
    "r_wrist_prosup",
    "r_wrist_pitch",
    "r_wrist_yaw",
)


@pytest.fixture(scope="module")
def model() -> RobotModel:
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    return RobotModel(urdf, JOINTS, "r_hand_dh_frame", {"r_arm_ft": "r_arm_ft_sensor"})


@pytest.fixture(scope="module")
def limits(model: RobotModel) -> JointLimits:
    """Ranges of the model and the rows of shoulder and elbow (iKin's LIC_0 to LIC_6)."""
    A = np.zeros((7, 10))
    A[0, 3:5] = 1.71, -1.71
    A[1, 3:6] = 1.71, -1.71, -1.71
    A[2, 4:6] = 1.0, 1.0
    A[3, 4:6] = 1.0, 0.042735
    A[4, 4] = 1.0
    A[5, 6:8] = 2.5, 1.0
    A[6, 6:8] = -2.5, 1.0
    inf = np.inf
    lower = np.radians([-347.0, -366.57, -66.6, 26.4188, -inf, -inf, -302.5])
    upper = np.radians([inf, 112.42, 213.3, inf, 100.0, 302.5, inf])
    return JointLimits.make(model.lower_rad, model.upper_rad, A, lower, upper)


@pytest.fixture(scope="module")
def home() -> Vector:
    """Start posture of the reach."""
    return np.radians([0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def rest() -> Vector:
    return np.radians([0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 50.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def rest_weights() -> Vector:
    return np.array([1.0] * 3 + [0.1] * 7)


@pytest.fixture(scope="module")
def postures(limits: JointLimits) -> list[Vector]:
    """Random postures inside all limits and rows."""
    rng = np.random.default_rng(11)
    found: list[Vector] = []
    while len(found) < 60:
        q = rng.uniform(limits.lower_rad, limits.upper_rad)
        if limits.violation(q) < 0.0:
            found.append(q)
    return found
