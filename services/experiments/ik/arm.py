"""The arms of the inverse kinematics' comparisons, with kinematics and checks of their own.

pinocchio on the robot's URDF; nothing of dforc, so that no error of the solvers judges itself.
Lengths in m, angles in rad, base frame, joint vectors in the order of `joints`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from services.config import load_robot
from services.reaching.limb import find_limb, limb_joints, limb_problem
from services.robotfile.model_file import urdf_path

Array = NDArray[np.float64]

TOLERANCE_M = 1e-3  # sqrt(eps) of eq. 11
BETA = 0.01
TORSO = ("torso_pitch", "torso_roll", "torso_yaw")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_prosup")
WRIST = ("wrist_pitch", "wrist_yaw")
REST_DEG = (-30.0, 30.0, 0.0, 50.0, 0.0, 0.0, 0.0)
# Over shoulder pitch, roll, yaw, elbow, prosup: coefficients, lower and upper bound in degrees.
ROWS: tuple[tuple[tuple[float, ...], float, float], ...] = (
    ((1.71, -1.71, 0.0, 0.0, 0.0), -347.0, np.inf),
    ((1.71, -1.71, -1.71, 0.0, 0.0), -366.57, 112.42),
    ((0.0, 1.0, 1.0, 0.0, 0.0), -66.6, 213.3),
    ((0.0, 1.0, 0.042735, 0.0, 0.0), 26.4188, np.inf),
    ((0.0, 1.0, 0.0, 0.0, 0.0), -np.inf, 100.0),
    ((0.0, 0.0, 0.0, 2.5, 1.0), -np.inf, 302.5),
    ((0.0, 0.0, 0.0, -2.5, 1.0), -302.5, np.inf),
)


@dataclass(frozen=True, eq=False)
class Link:
    """One joint: go by (R, p) from the one before, then turn about `axis`. Joint -1 is a tip."""

    R: Array
    p: Array
    axis: Array
    joint: int


class Arm:
    """Joints, limits, rows and rest posture of one problem, and what a posture is worth there."""

    def __init__(
        self,
        name: str,
        urdf: str,
        joints: Sequence[str],
        tips: Sequence[str],
        rows: tuple[Array, Array, Array],
        rest_rad: Array,
        limits_rad: tuple[Array, Array] | None = None,
    ) -> None:
        """Load the model; without limits of their own the joints have the URDF's."""
        self.name, self.urdf, self.joints, self.tips = name, urdf, tuple(joints), tuple(tips)
        self.n = len(joints)
        full = pin.buildModelFromUrdf(urdf)
        locked = [full.getJointId(j) for j in list(full.names)[1:] if j not in joints]
        self.model = pin.buildReducedModel(full, locked, pin.neutral(full))
        self._data = self.model.createData()
        self._ids = [self.model.getJointId(j) for j in joints]
        self._at = np.array([self.model.idx_vs[i] for i in self._ids])
        self._frames = [self.model.getFrameId(tip) for tip in tips]
        own: tuple[Array, Array] = (
            self.model.lowerPositionLimit[self._at],
            self.model.upperPositionLimit[self._at],
        )
        lower, upper = own if limits_rad is None else limits_rad
        self.lower: Array = lower
        self.upper: Array = upper
        self.A, self.row_lower, self.row_upper = rows
        self.rest = rest_rad
        self.weights: Array = np.where(np.arange(self.n) < len(TORSO), 1.0, 0.1)

    def model_order(self, q: Array) -> Array:
        """A joint vector in pinocchio's own order."""
        given = np.zeros(self.model.nq)
        given[self._at] = q
        return given

    def own_order(self, q: Array) -> Array:
        """Back from pinocchio's order."""
        found: Array = np.asarray(q)[self._at]
        return found

    def pose(self, q: Array, tip: int = 0) -> tuple[Array, Array]:
        """Rotation (3, 3) and position (3,) of a tip."""
        pin.forwardKinematics(self.model, self._data, self.model_order(q))
        place = pin.updateFramePlacement(self.model, self._data, self._frames[tip])
        return place.rotation.copy(), place.translation.copy()

    def jacobian(self, q: Array, tip: int = 0) -> Array:
        """Geometric Jacobian (6, n), linear rows first."""
        given, frame = self.model_order(q), self._frames[tip]
        J = pin.computeFrameJacobian(self.model, self._data, given, frame, pin.LOCAL_WORLD_ALIGNED)
        columns: Array = J[:, self._at]
        return columns

    def distance_m(self, q: Array, position: Array, tip: int = 0) -> float:
        """From the tip to a position."""
        return float(np.linalg.norm(self.pose(q, tip)[1] - position))

    def angle_rad(self, q: Array, rotation: Array, tip: int = 0) -> float:
        """From the tip's rotation to another."""
        return float(np.linalg.norm(pin.log3(self.pose(q, tip)[0] @ rotation.T)))

    def violation(self, q: Array) -> float:
        """Largest distance outside a limit or a row [rad]; negative inside all of them."""
        row = self.A @ q
        outside = [self.lower - q, q - self.upper, self.row_lower - row, row - self.row_upper]
        return float(max(part.max() for part in outside))

    def objective(self, q: Array, rotation: Array) -> float:
        """Cost of eq. 11 for one tip."""
        away = q - self.rest
        return self.angle_rad(q, rotation) ** 2 + BETA * float(self.weights @ (away * away))

    def postures(self, rng: np.random.Generator, count: int) -> Array:
        """Random postures inside limits and rows (count, n), uniform there."""
        found: list[Array] = []
        while len(found) < count:
            q = rng.uniform(self.lower, self.upper)
            if self.violation(q) <= 0.0:
                found.append(q)
        return np.array(found)

    def inside(self, q: Array) -> Array:
        """The first posture on the way from here to the rest posture that keeps everything."""
        way = self.rest - np.clip(q, self.lower, self.upper)
        for share in np.linspace(0.0, 1.0, 101):
            candidate: Array = self.rest - (1.0 - share) * way
            if self.violation(candidate) <= 0.0:
                return candidate
        return self.rest

    def chain(self, tip: int = 0) -> list[Link]:
        """The joints from the base to a tip, and the tip."""
        frame = self.model.frames[self._frames[tip]]
        links = []
        for i in list(self.model.supports[frame.parentJoint])[1:]:
            place = self.model.jointPlacements[i]
            links.append(Link(place.rotation, place.translation, self._axis(i), self._ids.index(i)))
        place = frame.placement
        links.append(Link(place.rotation, place.translation, np.zeros(3), -1))
        return links

    def _axis(self, joint: int) -> Array:
        """Axis of a revolute joint in its own frame: where its motion subspace points."""
        data = self.model.createData()
        v = np.zeros(self.model.nv)
        v[self.model.idx_vs[joint]] = 1.0
        pin.forwardKinematics(self.model, data, pin.neutral(self.model), v)
        parent = self.model.parents[joint]
        motion = data.v[joint] - data.liMi[joint].actInv(data.v[parent])
        axis: Array = motion.angular
        return axis


def sheet_rows(n: int, shoulders: Sequence[int]) -> tuple[Array, Array, Array]:
    """The seven rows for each arm whose first shoulder joint is given."""
    A = np.zeros((len(ROWS) * len(shoulders), n))
    for k, first in enumerate(shoulders):
        for i, (coefficients, _, _) in enumerate(ROWS):
            A[k * len(ROWS) + i, first : first + 5] = coefficients
    lower = np.radians([row[1] for row in ROWS] * len(shoulders))
    return A, lower, np.radians([row[2] for row in ROWS] * len(shoulders))


def _arm_joints(side: str) -> tuple[str, ...]:
    return tuple(f"{side}_{joint}" for joint in (*ARM, *WRIST))


def measured_arm() -> Arm:
    """The arm that the figures of the literature notes were measured on."""
    rest = np.radians([0.0, 0.0, 0.0, *REST_DEG])
    joints = (*TORSO, *_arm_joints("r"))
    urdf = str(urdf_path("iCubGazeboV2_5"))
    rows = sheet_rows(len(joints), (len(TORSO),))
    return Arm("iCubGazeboV2_5", urdf, joints, ("r_hand_dh_frame",), rows, rest)


def both_arms() -> Arm:
    """Both arms over one waist: 17 joints, two tips."""
    joints = (*TORSO, *_arm_joints("l"), *_arm_joints("r"))
    rest = np.radians([0.0, 0.0, 0.0, *REST_DEG, *REST_DEG])
    rows = sheet_rows(len(joints), (len(TORSO), len(TORSO) + len(REST_DEG)))
    tips = ("l_hand_dh_frame", "r_hand_dh_frame")
    return Arm("both arms", str(urdf_path("iCubGazeboV2_5")), joints, tips, rows, rest)


def robot_arm(name: str = "icub", limb: str = "right_arm") -> Arm:
    """A limb of a robot file with one tip, within the limits that planners keep there."""
    robot = load_robot(name)
    problem = limb_problem(robot, limb)
    limits = problem.limits
    rows = limits.rows, limits.lower[limits.n :], limits.upper[limits.n :]
    arm = Arm(
        robot.robot.urdf,
        str(urdf_path(robot.robot.urdf)),
        limb_joints(robot, limb),
        (find_limb(robot, limb).tips[0].frame,),
        rows,
        np.array(problem.rest_rad),
        (np.array(limits.lower_rad), np.array(limits.upper_rad)),
    )
    arm.weights = np.array(problem.rest_weights)
    return arm
