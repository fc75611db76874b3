"""Both arms of the iCub over one waist, and the problem of the right one."""

import icub_models
import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import IkProblem, Tip
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel

TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
ARM = (
    "shoulder_pitch",
    "shoulder_roll",
    "shoulder_yaw",
    "elbow",
    "wrist_prosup",
    "wrist_pitch",
    "wrist_yaw",
)


@pytest.fixture(scope="module")
def problem(
    model: RobotModel, limits: JointLimits, rest: Vector, rest_weights: Vector
) -> IkProblem:
    return IkProblem.make([Tip("right_hand", model)], limits, rest, rest_weights)


@pytest.fixture
def solver(problem: IkProblem) -> InverseKinematics:
    return InverseKinematics(problem)


@pytest.fixture(scope="module")
def both_arms(limits: JointLimits, rest: Vector, rest_weights: Vector) -> IkProblem:
    """17 joints: torso, left arm, right arm; the left hand, then the right one."""
    joints = TORSO + tuple(f"{side}_{name}" for side in "lr" for name in ARM)
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    tips = [Tip(f"{s}_hand", RobotModel(urdf, joints, f"{s}_hand_dh_frame", {})) for s in "lr"]
    rows = np.zeros((14, 17))
    rows[:7, 3:10] = limits.rows[:, 3:]
    rows[7:, 10:] = limits.rows[:, 3:]
    model = tips[0].model
    assert isinstance(model, RobotModel)
    bounds = (np.tile(limits.lower[10:], 2), np.tile(limits.upper[10:], 2))
    whole = JointLimits.make(model.lower_rad, model.upper_rad, rows, *bounds)
    twice = np.concatenate([rest, rest[3:]])
    return IkProblem.make(tips, whole, twice, np.concatenate([rest_weights, rest_weights[3:]]))
