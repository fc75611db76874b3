"""The arm of the whole-arm scenes: joints, limits, body and referee of one limb of the robot."""

from dataclasses import dataclass

import numpy as np

from dforc.collision.body import Body
from dforc.ik.problem import IkProblem
from dforc.limits import JointLimits
from services.config import load_robot
from services.core.errors import ConfigError
from services.experiments.whole_arm.referee import Array, Capsule, Referee
from services.fields.robot_body import FILE, read_collision_file, robot_body
from services.reaching.limb import find_limb, limb_joints, limb_problem
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile

RIGHT_ARM, BOTH_ARMS = ("icub:reach", "right_arm"), ("icub:arms", "both_arms")


@dataclass(frozen=True, eq=False)
class ArmSetting:
    """One limb. Its vectors have n joints; those of the body have all that may move."""

    robot: RobotFile
    limb: str
    joints: tuple[str, ...]  # of the limb
    problem: IkProblem
    home_rad: Array
    tips: tuple[str, ...]  # frames
    body: Body
    columns: Array  # where the limb's joints stand among the body's
    body_home_rad: Array  # the others' angles
    capsules: tuple[Capsule, ...]
    referee: Referee

    @property
    def n(self) -> int:
        """Joints of the limb."""
        return len(self.joints)

    @property
    def limits(self) -> JointLimits:
        """What planners keep."""
        return self.problem.limits

    def whole(self, q_rad: Array, others_rad: Array | None = None) -> Array:
        """The body's vector: the limb like this, the others as in `others_rad` (N,) or at home."""
        q = (self.body_home_rad if others_rad is None else others_rad).copy()
        q[self.columns] = q_rad
        return q

    def hands(self, q_rad: Array) -> list[tuple[Array, Array]]:
        """Rotation and position of each hand, by the referee's kinematics."""
        return self.hands_of(self.whole(q_rad))

    def hands_of(self, body_rad: Array) -> list[tuple[Array, Array]]:
        """The same of a vector of the whole body."""
        return [self.referee.frame_pose(body_rad, tip) for tip in self.tips]

    def posture(self, rng: np.random.Generator) -> Array:
        """A random one inside limits and rows."""
        limits = self.limits
        while True:
            q = rng.uniform(limits.lower_rad, limits.upper_rad)
            if limits.violation(q) <= 0.0:
                return q

    def self_distance(self, q_rad: Array) -> float:
        """Between the nearest pair of the body [m]."""
        return self.referee.itself(self.whole(q_rad)).distance_m

    def moved_segments(self, q_rad: Array) -> Array:
        """Both ends of every capsule that the limb moves (c, 2, 3)."""
        found: Array = self.referee.segments(self.whole(q_rad))[list(self.moved)]
        return found

    @property
    def moved(self) -> tuple[int, ...]:
        """Indices of the capsules that the limb moves."""
        return tuple(k for k, moves in enumerate(self.referee.moved) if moves)

    @property
    def moved_radii(self) -> Array:
        """Radii of those capsules."""
        return np.array([self.capsules[k].radius_m for k in self.moved])


def arm_setting(robot_name: str = RIGHT_ARM[0], limb: str = RIGHT_ARM[1]) -> ArmSetting:
    """A limb of a robot."""
    robot = load_robot(robot_name)
    chosen = find_limb(robot, limb)
    joints = limb_joints(robot, limb)
    capsules, body = _capsules(robot), robot_body(robot)
    at = {capsule.name: k for k, capsule in enumerate(capsules)}
    pairs = [(at[body.capsules[a]], at[body.capsules[b]]) for a, b in body.arrays.pairs.tolist()]
    urdf = str(urdf_path(robot.robot.urdf))
    columns = np.array([body.joints.index(joint) for joint in joints])
    home = {
        joint: angle
        for name in robot.limbs
        for joint, angle in zip(
            limb_joints(robot, name), np.radians(robot.limbs[name].home_deg), strict=True
        )
    }
    return ArmSetting(
        robot=robot,
        limb=limb,
        joints=joints,
        problem=limb_problem(robot, limb),
        home_rad=np.radians(chosen.home_deg),
        tips=tuple(tip.frame for tip in chosen.tips),
        body=body,
        columns=columns,
        body_home_rad=np.array([home.get(joint, 0.0) for joint in body.joints]),
        capsules=capsules,
        referee=Referee(urdf, body.joints, capsules, pairs, joints),
    )


def _capsules(robot: RobotFile) -> tuple[Capsule, ...]:
    """Of the robot's own table, in its order."""
    file = read_collision_file(robot.path.with_name(FILE))
    if file is None:
        raise ConfigError(f"{robot.robot.name} has no {FILE}: nothing to judge contacts by")
    return tuple(
        Capsule(row.name, row.link, row.start_m, row.end_m, row.radius_m) for row in file.capsules
    )
