"""The regressor of a sensor's wrench in the inertial parameters of the bodies beyond it."""

import icub_models
import numpy as np
import pytest

from dforc.robot_model import RobotModel

JOINTS = ("r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw", "r_elbow", "r_wrist_pitch")


@pytest.fixture(scope="module")
def model() -> RobotModel:
    path = str(icub_models.get_model_file("iCubLisboa01"))
    return RobotModel(path, JOINTS, "r_hand", {"arm": "r_arm_ft_sensor"})


def test_regressor_times_parameters_is_the_wrench(model: RobotModel) -> None:
    rng = np.random.default_rng(0)
    parameters = model.inertial_parameters("arm")
    assert parameters.shape == (30,)  # the rest of the upper arm, the forearm, the hand
    for _ in range(50):
        state = rng.uniform(-1, 1, 5), rng.uniform(-3, 3, 5), rng.uniform(-10, 10, 5)
        wrench = model.sensor_wrench(*state, "arm")
        R = model.sensor_regressor(*state, "arm")
        np.testing.assert_allclose(R @ parameters, wrench, atol=1e-12)


def test_the_masses_are_those_of_the_bodies_beyond(model: RobotModel) -> None:
    # at rest the sensor carries the weight of all of them
    at_rest = np.zeros(5), np.zeros(5), np.zeros(5)
    mass_kg = model.inertial_parameters("arm")[[0, 10, 20]].sum()
    force_n = np.linalg.norm(model.sensor_wrench(*at_rest, "arm")[:3])
    assert force_n == pytest.approx(9.81 * mass_kg)


def test_the_torque_regressor_times_parameters_is_the_torque() -> None:
    path = str(icub_models.get_model_file("iCubLisboa01"))
    model = RobotModel(path, JOINTS, "r_hand", {})
    rng = np.random.default_rng(1)
    for _ in range(20):
        state = rng.uniform(-1, 1, 5), rng.uniform(-3, 3, 5), rng.uniform(-10, 10, 5)
        R = model.torque_regressor(*state)
        np.testing.assert_allclose(R @ model.joint_parameters(), model.rnea(*state), atol=1e-12)
