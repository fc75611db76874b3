"""The iCub's right hand and both hands, inverse kinematics for them, and moves between poses."""

import icub_models
import numpy as np
import pytest

from dforc.arrays import Matrix, Vector
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import IkProblem, Tip, TipTarget
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from dforc.rotation import angle_between

Move = tuple[Vector, Vector]  # start posture, target posture


@pytest.fixture(scope="module")
def tip(model: RobotModel) -> Tip:
    return Tip("right_hand", model)


@pytest.fixture(scope="module")
def solver(tip: Tip, limits: JointLimits, rest: Vector, rest_weights: Vector) -> InverseKinematics:
    return InverseKinematics(IkProblem.make([tip], limits, rest, rest_weights))


@pytest.fixture(scope="module")
def moves(tip: Tip, limits: JointLimits, solver: InverseKinematics, rest: Vector) -> list[Move]:
    """Ten moves of 12 to 41 cm, turns below 120 degrees; both postures by inverse kinematics."""
    rng, found = np.random.default_rng(5), list[Move]()
    while len(found) < 10:
        poses: list[tuple[Matrix, Vector]] = []
        while len(poses) < 2:
            q = rng.uniform(limits.lower_rad, limits.upper_rad)
            if limits.violation(q) < 0.0:
                poses.append(tip.pose(q))
        (R_start, start), (R_goal, goal) = poses
        near = 0.12 <= np.linalg.norm(goal - start) <= 0.41
        if not near or angle_between(R_start, R_goal) >= np.radians(120.0):
            continue
        first = solver.solve([TipTarget.checked(start, R_start)], rest)
        second = solver.solve([TipTarget.checked(goal, R_goal)], first.q_rad)
        if max(first.orientation_error_rad, second.orientation_error_rad) < 1e-3:
            found.append((first.q_rad, second.q_rad))
    return found


@pytest.fixture(scope="module")
def both_hands(limits: JointLimits) -> tuple[tuple[Tip, Tip], JointLimits]:
    """17 joints: torso, left arm, right arm; the left hand, then the right one."""
    arm = "shoulder_pitch shoulder_roll shoulder_yaw elbow wrist_prosup wrist_pitch wrist_yaw"
    names = [f"torso_{name}" for name in ("pitch", "roll", "yaw")]
    names += [f"{side}_{name}" for side in "lr" for name in arm.split()]
    joints = tuple(names)
    urdf = str(icub_models.get_model_file("iCubLisboa01"))
    left, right = (RobotModel(urdf, joints, f"{s}_hand_dh_frame", {}) for s in "lr")
    rows = np.zeros((14, 17))
    rows[:7, 3:10] = rows[7:, 10:] = limits.rows[:, 3:]
    bounds = (np.tile(limits.lower[10:], 2), np.tile(limits.upper[10:], 2))
    whole = JointLimits.make(left.lower_rad, left.upper_rad, rows, *bounds)
    return (Tip("left_hand", left), Tip("right_hand", right)), whole
