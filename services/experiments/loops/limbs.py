"""The limbs of the closed-loop experiment: what is controlled, where they begin, where pushed."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.robot_model import RobotModel
from services.messages import Vector3
from services.robotfile.model_file import model_path
from services.robotfile.robot_tables import RobotFile

Forces = tuple[Vector3, ...]

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM_DEG = (-30.0, 40.0, 10.0, 50.0, 0.0, 0.0, 0.0)
LEG_DEG = (25.0, -20.0, 5.0, -45.0, 0.0, 0.0)
ARM_STEPS_NM = (1.5, 1.5, 1.5, 1.5, 0.3)  # gravity beside them stays within the sensor's 8 Nm
LEG_STEPS_NM = (3.0, 3.0, 3.0, 3.0, 1.5, 1.5)
DOWN, FORWARD = (0.0, 0.0, -20.0), (20.0, 0.0, 0.0)
RIGHT, LEFT = (0.0, -20.0, 0.0), (0.0, 20.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Limb:
    """One arm or leg. Joint names are the model's."""

    part: str
    posture_deg: tuple[float, ...]  # every joint of the part
    torque: tuple[str, ...]  # joints whose torque is known
    steps_nm: tuple[float, ...]  # of those
    compliant: tuple[str, ...]
    end: str  # frame of the hand or foot
    middle: str  # frame at elbow or knee
    pushes: tuple[tuple[str, str, Vector3], ...]  # name of the place, frame, force in base axes
    turned: tuple[str, ...]  # joints that turn at constant velocity
    guided_m_s: Vector3  # where a person leads the end to


def limbs(robot: RobotFile) -> tuple[Limb, ...]:
    """Those of the robot that have a force/torque sensor, by part."""
    return tuple(
        made
        for part, make in (("left_arm", _arm), ("right_arm", _arm), *_LEGS)
        if part in robot.parts
        for made in (make(part),)
    )


def _arm(part: str) -> Limb:
    side = part[0]
    palm, forearm = f"{side}_hand_dh_frame", f"{side}_forearm"
    # A push on the palm bends the left wrist, whose motors are coupled, beyond its limit.
    hand = "l_hand" if side == "l" else palm
    joints = tuple(f"{side}_{name}" for name in ARM)
    return Limb(
        part=part,
        posture_deg=ARM_DEG,
        torque=(*joints, f"{side}_wrist_prosup"),
        steps_nm=ARM_STEPS_NM,
        compliant=joints,
        end=palm,
        middle=forearm,
        pushes=(
            ("hand", hand, DOWN),
            ("elbow", forearm, RIGHT),
            ("hand", hand, LEFT),
            ("elbow", forearm, DOWN),
            ("hand", hand, RIGHT),
            ("hand", hand, FORWARD),
        ),
        turned=(joints[0], joints[3]),
        guided_m_s=(0.0, 0.0, 0.1),
    )


def _leg(part: str) -> Limb:
    side = part[0]
    foot, lower_leg = f"{side}_sole", f"{side}_lower_leg"
    joints = tuple(f"{side}_{name}" for name in LEG)
    return Limb(
        part=part,
        posture_deg=LEG_DEG,
        torque=joints,
        steps_nm=LEG_STEPS_NM,
        compliant=joints,
        end=foot,
        middle=lower_leg,
        pushes=(
            ("knee", lower_leg, FORWARD),
            ("foot", foot, FORWARD),
            ("knee", lower_leg, RIGHT),
            ("foot", foot, LEFT),
            ("knee", lower_leg, LEFT),
            ("foot", foot, RIGHT),
        ),
        turned=(joints[0], joints[3]),
        guided_m_s=(0.1, 0.0, 0.0),
    )


_LEGS = (("left_leg", _leg), ("right_leg", _leg))


class Point:
    """A point of a link: where it is and how joints move it. Joint vectors (n,) as `joints`."""

    def __init__(self, robot: RobotFile, limb: Limb, frame: str, point_m: Vector3 = ORIGIN) -> None:
        self.frame = frame
        self.point_m = point_m
        self.joints = (*robot.parts.get("torso", ()), *robot.parts[limb.part])
        self._model = RobotModel(str(model_path(robot)), self.joints, frame, {})

    def place_m(self, q_rad: Vector) -> Vector:
        """Position (3,) in the base frame."""
        turn, origin = self._model.tip_pose(q_rad)
        place: Vector = origin + turn @ np.array(self.point_m)
        return place

    def jacobian(self, q_rad: Vector) -> Matrix:
        """Speed of the point per speed of the joints, 3 x n, base axes."""
        at_origin = self._model.tip_jacobian(q_rad)
        lever = self._model.tip_pose(q_rad)[0] @ np.array(self.point_m)
        at_point: Matrix = at_origin[:3] + np.cross(at_origin[3:].T, lever).T
        return at_point
