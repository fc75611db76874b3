"""Sensor frames that the robot file adds to the model."""

import numpy as np
import pinocchio as pin
import pytest

from dforc.robot_model import load_model
from services.config import load_robot
from services.core.errors import ConfigError
from services.robotfile.model_file import model_path, urdf_path, with_frames


def test_a_robot_without_added_frames_has_the_plain_model() -> None:
    robot = load_robot("icub:reach")
    assert model_path(robot) == urdf_path("iCubLisboa01")


def test_the_feet_get_a_sensor_where_they_begin() -> None:
    robot = load_robot("icub:left_leg")
    joints = robot.parts["left_leg"]
    model = load_model(str(model_path(robot)), joints, ("l_foot_ft_sensor",))
    plain = load_model(str(urdf_path("iCubLisboa01")), joints, ())
    assert model.existJointName("l_foot_ft_sensor")
    total, plain_total = (pin.computeTotalMass(each) for each in (model, plain))
    assert total == pytest.approx(plain_total)
    ankle, foot = (model.getJointId(n) for n in ("l_ankle_roll", "l_foot_ft_sensor"))
    assert model.inertias[ankle].mass == pytest.approx(0.0)
    assert model.inertias[foot].mass == pytest.approx(
        plain.inertias[plain.getJointId("l_ankle_roll")].mass
    )
    np.testing.assert_allclose(model.jointPlacements[foot].homogeneous, np.eye(4), atol=1e-12)


def test_a_frame_behind_an_unknown_joint_is_refused() -> None:
    with pytest.raises(ConfigError, match="has no joint 'l_tail'"):
        with_frames(urdf_path("iCubLisboa01"), (("tail_ft_sensor", "l_tail"),))
