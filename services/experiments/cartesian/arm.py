"""The limb of the Cartesian experiment: kinematics, limits, and the posture for a pose."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from dforc.ik.inverse_kinematics import IkResult, InverseKinematics
from dforc.ik.problem import Tip, TipTarget
from dforc.kinematics import HandKinematics
from dforc.limits import JointLimits
from services.core.errors import ServiceError
from services.reaching.limb import find_limb, limb_joints, limb_problem
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import chain_limits_rad, chain_rows_rad

TORSO = "torso"
STARTS = 12  # postures from which a search may begin
TRACK_STEP_RAD = math.radians(4.0)


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where the hand is to be."""

    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Reached:
    """The nearest pose to one that was asked for, and the posture that takes the hand there."""

    pose: Pose
    q_rad: Vector  # (n,)
    off_m: float  # from the pose asked for
    off_rad: float


class Arm:
    """A limb with or without its torso. A blocked torso stands upright."""

    def __init__(self, robot: RobotFile, limb: str, *, torso: bool) -> None:
        problem = limb_problem(robot, limb)
        self.robot = robot
        self.limb = find_limb(robot, limb)
        self.joints = limb_joints(robot, limb)
        self.free: NDArray[np.bool_] = np.array(
            [torso or joint not in robot.parts[TORSO] for joint in self.joints]
        )
        self._ik = InverseKinematics(problem.changed(free=self.free))
        self.tip: Tip = problem.tips[0]
        self.limits = problem.limits  # as planners keep them
        self.hard_limits = _hard_limits(robot, self.joints)
        self.speed_limits_rad_s = tuple(
            math.radians(robot.joints[joint].max_velocity_deg_s) for joint in self.joints
        )
        self.rest_rad = np.where(self.free, problem.rest_rad, 0.0)
        self.home_rad: Vector = np.where(self.free, np.radians(self.limb.home_deg), 0.0)

    @property
    def degrees_of_freedom(self) -> int:
        """Joints that may move."""
        return int(self.free.sum())

    @property
    def own_limits(self) -> JointLimits:
        """The planners' limits, where a blocked joint has no range at all."""
        limits, n = self.limits, self.limits.n
        return JointLimits.make(
            np.where(self.free, limits.lower_rad, 0.0),
            np.where(self.free, limits.upper_rad, 0.0),
            limits.rows,
            limits.lower[n:],
            limits.upper[n:],
        )

    @property
    def kinematics(self) -> HandKinematics:
        """Of the hand alone."""
        return self.tip.model

    def pose(self, q_rad: Vector) -> Pose:
        """Of the hand."""
        rotation, position_m = self.tip.pose(q_rad)
        return Pose(position_m, rotation)

    def reached(self, pose: Pose, q_start_rad: Vector) -> Reached:
        """By a search.

        Raises:
            ServiceError: inverse kinematics came to no end.
        """
        return self._made(self._ik.solve([_target(pose)], q_start_rad, starts=STARTS))

    def followed(self, poses: Sequence[Pose]) -> list[Reached]:
        """Along a path, beginning with a search for its first pose."""
        found = [self.reached(poses[0], self.rest_rad)]
        for pose in poses[1:]:
            before = found[-1].q_rad
            result = self._ik.track([_target(pose)], before, step_limit_rad=TRACK_STEP_RAD)
            found.append(self._made(result))
        return found

    def _made(self, result: IkResult) -> Reached:
        if result.status == "out_of_time":
            raise ServiceError(f"inverse kinematics of {self.limb.name}: {result.reason}")
        return Reached(
            pose=self.pose(result.q_rad),
            q_rad=result.q_rad,
            off_m=result.position_error_m,
            off_rad=result.orientation_error_rad,
        )


def _target(pose: Pose) -> TipTarget:
    return TipTarget.checked(pose.position_m, pose.rotation)


def _hard_limits(robot: RobotFile, joints: Sequence[str]) -> JointLimits:
    """Ranges and rows of the robot file, without any margin."""
    return JointLimits.make(*chain_limits_rad(robot, joints), *chain_rows_rad(robot, joints))
