"""The arm on which PMP's figures were measured, and the targets drawn for it.

Torso and right arm, 10 joints within the model's own limits; no rows of shoulder and elbow, which
PMP does not know. How the published targets were drawn is not said beyond "mid-range" and "one
wrist joint at its upper limit, arm stretched"; here:

mid-range  every arm joint up to 30 degrees from home, 5 degrees inside its limits, torso straight;
edge       arm joints anywhere but in the outer tenths of their ranges, elbow bent by 15 to 25
           degrees (15 is its limit), wrist pitch or wrist yaw at its upper limit, torso straight.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.robot_model import RobotModel
from services.robotfile.model_file import urdf_path

MEASURED, OWN = "iCubGazeboV2_5", "iCubLisboa01"
TIP = "r_hand_dh_frame"
TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
ARM = (
    *("r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw", "r_elbow"),
    *("r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw"),
)
JOINTS = (*TORSO, *ARM)
ELBOW, WRIST = JOINTS.index("r_elbow"), (8, 9)
HOME_DEG = (0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 0.0)
NEAR_HOME_DEG, ROOM_DEG = 30.0, 5.0
OUTER_SHARE = 0.1
STRETCHED_DEG = 10.0  # of the elbow, beyond its limit


@dataclass(frozen=True, slots=True, eq=False)
class PmpArm:
    """Kinematics and limits of one model."""

    name: str
    model: RobotModel
    home_rad: Vector

    @property
    def home_m(self) -> Vector:
        """Where the hand begins (3,)."""
        return self.model.tip_pose(self.home_rad)[1]

    def poses(self, postures: Matrix) -> "list[HandPose]":
        """Pose of the hand in every posture (k, 10)."""
        return [HandPose(*self.model.tip_pose(q), q) for q in postures]


@dataclass(frozen=True, slots=True, eq=False)
class HandPose:
    """A target that one posture at least attains."""

    rotation: Matrix
    position_m: Vector
    q_rad: Vector


def arm_of(urdf: str) -> PmpArm:
    """The arm of a model of icub-models."""
    model = RobotModel(str(urdf_path(urdf)), JOINTS, TIP, {})
    return PmpArm(urdf, model, np.radians(HOME_DEG))


def mid_range(arm: PmpArm, rng: np.random.Generator, count: int) -> Matrix:
    """Postures (count, 10) whose hands are mid-range targets."""
    model, around = arm.model, np.radians(NEAR_HOME_DEG)
    q = np.tile(arm.home_rad, (count, 1))
    q[:, len(TORSO) :] += around * (2.0 * spread(rng, count, len(ARM)) - 1.0)
    room = np.radians(ROOM_DEG)
    return np.clip(q, model.lower_rad + room, model.upper_rad - room)


def edge(arm: PmpArm, rng: np.random.Generator, count: int) -> Matrix:
    """Postures (count, 10) whose hands are targets at the edge of the workspace."""
    lower, upper = arm.model.lower_rad, arm.model.upper_rad
    outer = OUTER_SHARE * (upper - lower)
    q = lower + outer + (upper - lower - 2.0 * outer) * spread(rng, count, len(JOINTS))
    q[:, : len(TORSO)] = 0.0
    q[:, ELBOW] = lower[ELBOW] + np.radians(STRETCHED_DEG) * rng.uniform(size=count)
    for k, joint in enumerate(WRIST):
        q[k :: len(WRIST), joint] = upper[joint]
    return q


def spread(rng: np.random.Generator, count: int, width: int) -> Matrix:
    """Random numbers (count, width) in 0..1 that fill every column evenly (Latin hypercube)."""
    cells = np.column_stack([rng.permutation(count) for _ in range(width)])
    numbers: Matrix = (cells + rng.uniform(size=(count, width))) / count
    return numbers


def leaving_room(arm: PmpArm, targets: Sequence[HandPose], distance_m: float) -> list[HandPose]:
    """Those that are farther than that from the hand at home."""
    home = arm.home_m
    return [t for t in targets if float(np.linalg.norm(t.position_m - home)) > distance_m]
