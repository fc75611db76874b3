"""Rigid-body model of the robot, from its URDF: kinematics, inverse dynamics, sensor wrenches.

The one file of dforc that imports pinocchio. The base frame is the URDF's root link (root_link of
the iCub), fixed, z up; gravity is 9.81 m/s2 along its -z. Joint vectors have the order of the names
handed in; all other joints are locked at zero. SI units and radians; nothing here is thread-safe.

A force-torque sensor is a fixed joint of the URDF (r_arm_ft_sensor). pinocchio would lump the
bodies at its two sides, so it is loaded as a revolute joint that stays at angle zero: the wrench
between the two is then one result of the same Newton-Euler pass.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector, constant
from dforc.errors import DforcError

ROUNDING_NOISE = 1e-12  # the URDF's angles carry four to six digits; pi/2 is among them as 1.5708
ENDLESS_RAD = 1e9  # either way; an infinite limit is no URDF


class ModelError(DforcError, ValueError):
    """The URDF is missing, unreadable, or lacks a joint or frame that was asked for."""


class ChainElement(NamedTuple):
    """One step from the base to the tip: go by (R, p), then turn about `axis` by the joint's angle.

    R (3x3) and p (3, m) place the element in the one before it (in the base, where `parent` is -1),
    at angle zero. `axis` is a unit vector in the element's own frame. The last element is the tip
    frame itself: `joint` is -1 and `axis` is zero. Rounding noise below 1e-12 is an exact zero, so
    that symbolic expressions built from it stay small.
    """

    parent: int  # index of the element before this one in the chain, -1 for the base
    R: Matrix
    p: Vector
    axis: Vector
    joint: int  # index into the joint vector, -1 for the tip


class RobotModel:
    """Kinematics and dynamics of one limb or several, from one URDF.

    `sensor_frames` maps each force-torque sensor's name to the fixed joint of the URDF that carries
    it; the sensor frame is that joint's child link frame.
    """

    def __init__(
        self,
        urdf_path: str,
        joints: tuple[str, ...],
        tip_frame: str,
        sensor_frames: Mapping[str, str],
    ) -> None:
        self.joints = joints
        self.n = len(joints)
        self._model = load_model(urdf_path, joints, tuple(sensor_frames.values()))
        self._data = self._model.createData()
        self._at = joint_columns(self._model, joints)
        self._ids = [self._model.getJointId(name) for name in joints]
        self.lower_rad: Vector = constant(self._model.lowerPositionLimit[self._at])
        self.upper_rad: Vector = constant(self._model.upperPositionLimit[self._at])
        self._q: Vector = np.zeros(self._model.nv)
        self._v: Vector = np.zeros(self._model.nv)
        self._a: Vector = np.zeros(self._model.nv)
        self._tip = frame_index(self._model, tip_frame)
        ids = {name: self._model.getJointId(frame) for name, frame in sensor_frames.items()}
        self._sensor_ids = ids
        # Live views into pinocchio's results, valid as long as self._data is: never handed out.
        self._force_at = {name: self._data.f[i].vector for name, i in ids.items()}
        self._place_at = {name: self._data.oMi[i] for name, i in ids.items()}
        self._origin_at = [self._data.oMi[i].translation for i in self._ids]
        self._tip_at = self._data.oMf[self._tip]

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3x3) and position (3, m) of the tip frame in the base frame."""
        self._q[self._at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        pin.updateFramePlacement(self._model, self._data, self._tip)
        return self._tip_at.rotation.copy(), self._tip_at.translation.copy()

    def tip_jacobian(self, q_rad: Vector) -> Matrix:
        """Geometric Jacobian at the tip, 6 x n: linear rows, then angular, in the base's axes."""
        self._q[self._at] = q_rad
        J = pin.computeFrameJacobian(
            self._model, self._data, self._q, self._tip, pin.LOCAL_WORLD_ALIGNED
        )
        columns: Matrix = J[:, self._at]
        return columns

    def joint_positions(self, q_rad: Vector) -> Matrix:
        """Origin of each joint in the base frame, n x 3, m."""
        self._q[self._at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        return np.array(self._origin_at)

    def sensor_pose(self, q_rad: Vector, name: str) -> tuple[Matrix, Vector]:
        """Rotation (3x3) and position (3, m) of a sensor's frame in the base frame."""
        self._q[self._at] = q_rad
        pin.forwardKinematics(self._model, self._data, self._q)
        place = self._place_at[name]
        return place.rotation.copy(), place.translation.copy()

    def gravity(self, q_rad: Vector) -> Vector:
        """Torques (n, Nm) that hold the posture still against gravity."""
        self._q[self._at] = q_rad
        tau: Vector = pin.computeGeneralizedGravity(self._model, self._data, self._q)[self._at]
        return tau

    def rnea(self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector) -> Vector:
        """Torques (n, Nm) that the drives exert on the joints in this motion, gravity included."""
        self._q[self._at] = q_rad
        self._v[self._at] = dq_rad_s
        self._a[self._at] = ddq_rad_s2
        tau: Vector = pin.rnea(self._model, self._data, self._q, self._v, self._a)[self._at]
        return tau

    def inverse_dynamics(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector
    ) -> tuple[Vector, dict[str, Vector]]:
        """Torques as in `rnea` and every sensor's wrench as in `sensor_wrench`, in one pass."""
        tau_nm = self.rnea(q_rad, dq_rad_s, ddq_rad_s2)
        return tau_nm, {name: -force for name, force in self._force_at.items()}

    def sensor_wrench(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector, name: str
    ) -> Vector:
        """Wrench (6: N then Nm) that the limb beyond a sensor exerts on the near side.

        In the sensor's frame, about its origin; what the sensor shows without contact and offset.
        """
        self.rnea(q_rad, dq_rad_s, ddq_rad_s2)
        wrench: Vector = -self._force_at[name]
        return wrench

    def inertial_parameters(self, name: str) -> Vector:
        """Ten per body beyond a sensor (10 k): mass, mass times centre, inertia at the joint.

        A body is what moves with one joint, or with the sensor. In the order of
        `sensor_regressor`: m, m c (3), then xx, xy, yy, xz, yz, zz of the inertia.
        """
        bodies = self._bodies_beyond(name)
        return np.concatenate([self._model.inertias[i].toDynamicParameters() for i in bodies])

    def sensor_regressor(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector, name: str
    ) -> Matrix:
        """R (6, 10 k) with `sensor_wrench` = R `inertial_parameters`, whatever those are."""
        self.rnea(q_rad, dq_rad_s, ddq_rad_s2)
        bodies = self._bodies_beyond(name)
        carried = {bodies[0]: pin.SE3.Identity()}  # placements in the sensor; rnea leaves no oMi
        blocks = []
        for i in bodies:
            if i not in carried:
                carried[i] = carried[self._model.parents[i]] * self._data.liMi[i]
            block = pin.jointBodyRegressor(self._model, self._data, i)
            blocks.append(-carried[i].toDualActionMatrix() @ block)
        R: Matrix = np.hstack(blocks)
        return R

    def joint_parameters(self) -> Vector:
        """As `inertial_parameters`, of the bodies that the joints carry (10 n), in their order."""
        return np.concatenate([self._model.inertias[i].toDynamicParameters() for i in self._ids])

    def torque_regressor(self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector) -> Matrix:
        """R (n, 10 n) with `rnea` = R `joint_parameters`, whatever those are. Without sensors."""
        self._q[self._at] = q_rad
        self._v[self._at] = dq_rad_s
        self._a[self._at] = ddq_rad_s2
        R = pin.computeJointTorqueRegressor(self._model, self._data, self._q, self._v, self._a)
        columns = [10 * (i - 1) + k for i in self._ids for k in range(10)]
        chosen: Matrix = R[np.ix_(self._at, columns)]
        return chosen

    def _bodies_beyond(self, name: str) -> list[int]:
        return list(self._model.subtrees[self._sensor_ids[name]])

    def chain_description(self) -> list[ChainElement]:
        """Placements and axes of the moving joints from the base to the tip, and the tip itself."""
        tip = self._model.frames[self._tip]
        path = [i for i in self._model.supports[tip.parentJoint] if i > 0]
        moving = {joint_id: joint for joint, joint_id in enumerate(self._ids)}
        chain: list[ChainElement] = []
        carried = pin.SE3.Identity()
        for i in path:
            carried = carried * self._model.jointPlacements[i]
            if i in moving:
                axis = _axis_of(self._model, i)
                chain.append(_element(len(chain) - 1, carried, axis, moving[i]))
                carried = pin.SE3.Identity()
        chain.append(_element(len(chain) - 1, carried * tip.placement, np.zeros(3), -1))
        return chain


def tree_description(
    urdf_path: str, joints: Sequence[str], frames: Sequence[str]
) -> tuple[list[ChainElement], list[ChainElement]]:
    """One element per joint, in the order of `joints`, and one per frame (a link of the URDF).

    As `RobotModel.chain_description` has them; `parent` counts in `joints`.
    """
    model = load_model(urdf_path, joints, ())
    number = {model.getJointId(name): joint for joint, name in enumerate(joints)}
    tree = []
    for joint_id, joint in number.items():
        parent = number.get(model.parents[joint_id], -1)
        placement = model.jointPlacements[joint_id]
        tree.append(_element(parent, placement, _axis_of(model, joint_id), joint))
    held = []
    for name in frames:
        frame = model.frames[frame_index(model, name)]
        parent = number.get(frame.parentJoint, -1)
        held.append(_element(parent, frame.placement, np.zeros(3), -1))
    return tree, held


def load_model(urdf_path: str, joints: Sequence[str], frozen: Sequence[str]) -> "pin.Model":
    """A pinocchio model in which only `joints` move and the fixed joints `frozen` are kept apart.

    The frozen ones are revolute joints of their own, for the caller to keep at angle zero.
    """
    try:
        root = ElementTree.fromstring(Path(urdf_path).read_text(encoding="utf-8"))
    except (OSError, ElementTree.ParseError) as error:
        raise ModelError(f"cannot read the robot model {urdf_path}: {error}") from error
    for joint in root.findall("joint"):
        if joint.get("type") == "continuous":  # pinocchio would ask for its sine and cosine
            _make_revolute(joint, -ENDLESS_RAD, ENDLESS_RAD)
    for name in frozen:
        _free_fixed_joint(root, name, urdf_path)
    full = pin.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))
    for name in joints:
        if not full.existJointName(name):
            known = ", ".join(list(full.names)[1:])
            raise ModelError(f"{urdf_path} has no joint {name!r}; it has {known}")
    kept = {"universe", *joints, *frozen}
    locked = [full.getJointId(name) for name in full.names if name not in kept]
    return pin.buildReducedModel(full, locked, pin.neutral(full))


def joint_columns(model: "pin.Model", joints: Sequence[str]) -> NDArray[np.intp]:
    """Where each of `joints` stands in the model's own joint vector."""
    return np.array([model.idx_vs[model.getJointId(name)] for name in joints], dtype=np.intp)


def frame_index(model: "pin.Model", frame: str) -> int:
    """Where a frame (a link or joint of the URDF) stands in the model's list of frames."""
    if not model.existFrame(frame):
        raise ModelError(f"the robot model {model.name} has no frame {frame!r}")
    index: int = model.getFrameId(frame)
    return index


def _free_fixed_joint(root: ElementTree.Element, name: str, urdf_path: str) -> None:
    fixed = {
        joint.get("name"): joint for joint in root.findall("joint") if joint.get("type") == "fixed"
    }
    if name not in fixed:
        known = ", ".join(sorted(str(n) for n in fixed if "ft" in str(n)))
        raise ModelError(f"{urdf_path} has no fixed joint {name!r} for a sensor; it has {known}")
    joint = fixed[name]
    for axis in joint.findall("axis"):
        joint.remove(axis)
    ElementTree.SubElement(joint, "axis", xyz="0 0 1")
    _make_revolute(joint, 0.0, 0.0)


def _make_revolute(joint: ElementTree.Element, lower_rad: float, upper_rad: float) -> None:
    joint.set("type", "revolute")
    for limit in joint.findall("limit"):
        joint.remove(limit)
    limits = {"lower": str(lower_rad), "upper": str(upper_rad), "effort": "0", "velocity": "0"}
    ElementTree.SubElement(joint, "limit", limits)


def _axis_of(model: "pin.Model", joint_id: int) -> Vector:
    """Unit axis of a revolute joint in its own frame, whichever of pinocchio's types it is."""
    q = pin.neutral(model)
    q[model.idx_qs[joint_id]] = np.pi / 2
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    turn = model.jointPlacements[joint_id].actInv(data.liMi[joint_id]).rotation
    axis: Vector = pin.log3(turn) / (np.pi / 2)
    return axis / np.linalg.norm(axis)


def _element(parent: int, placement: "pin.SE3", axis: Vector, joint: int) -> ChainElement:
    R, p = placement.rotation, placement.translation
    R, p, axis = (np.where(np.abs(part) < ROUNDING_NOISE, 0.0, part) for part in (R, p, axis))
    return ChainElement(parent, constant(R), constant(p), constant(axis), joint)
