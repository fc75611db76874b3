"""The rigid bodies: what the links of the URDF do under joint torques, and what sensors feel of it.

Forward dynamics is pinocchio's joint-space inertia, factorised along the tree: (M + B) ddq = tau -
h. What the drives add to the inertia, B, is more than a diagonal where motors are coupled, which
the articulated-body algorithm cannot take; but coupled joints lie on one branch, so that B fills no
zero of the sparse factor, and the price is the same.

The sensors read the same step's motion: a second model, in which each sensor is a joint frozen at
zero, gives the wrench between its two sides. Bodies are heavier or lighter than the URDF says and
their centres of mass are off, by the seed; no object is shared with any controller's model.
Joint vectors have the order of the joints handed in. SI units, radians.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dforc.robot_model import frame_index, joint_columns, load_model
from firmware_sim.description import PlantSpec
from firmware_sim.draws import Draw, generator

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]
Pairs = Sequence[tuple[int, int]]


class PushPoint(NamedTuple):
    """A point of a link, where the world may push."""

    frame: int  # of the model
    point_m: Vector  # in that frame
    felt: tuple[bool, ...]  # by which sensors: those between the link and the base


class Push(NamedTuple):
    """A force (3, N, base frame) on a point."""

    at: PushPoint
    force_n: Vector


class RigidBodies:
    """Links and joints of the URDF, in some motion, and the wrenches at the sensors.

    Callers write `motion` and `cut_motion`, a row per quantity; joint i of those handed in stands
    in column `columns[i]` or `cut_columns[i]`. `wrenches[i]` is what the limb beyond sensor i
    exerts on the near side (6: N then Nm).
    """

    def __init__(
        self,
        spec: PlantSpec,
        joints: Sequence[str],
        sensor_frames: Sequence[str],
        coupled: Pairs = (),
    ) -> None:
        """`coupled` are the pairs of joints that some motor turns together."""
        self.n = len(joints)
        self._cut = load_model(spec.urdf, tuple(joints), tuple(sensor_frames))
        _disturb(self._cut, spec)
        frozen = [self._cut.getJointId(frame) for frame in sensor_frames]
        self._model = pin.buildReducedModel(self._cut, frozen, pin.neutral(self._cut))
        self._data, self._cut_data = self._model.createData(), self._cut.createData()
        self.columns = joint_columns(self._model, joints)
        self.cut_columns = joint_columns(self._cut, joints)
        self.motion: Matrix = np.zeros((4, self._model.nv))  # q, dq, tau, added to the diagonal
        self.cut_motion: Matrix = np.zeros((3, self._cut.nv))  # q, dq, ddq
        self._armature = self._model.armature  # a live view, as are M and the wrenches
        self._M = self._data.M
        self._pairs = _pair_columns(self.columns, coupled)
        self._tip = frame_index(self._model, spec.tip_frame)
        self._sensor_joints = frozen
        self._sensor_places = [self._cut_data.oMi[i] for i in frozen]
        self._near_on_far = [self._cut_data.f[i].vector for i in frozen]
        self.wrenches: Matrix = np.zeros((len(frozen), 6))

    def accelerate(self, off_diagonal: Vector) -> Vector:
        """Accelerations under the torques of `motion`, in the order of its columns.

        `off_diagonal` is added to the inertia between the coupled pairs.
        """
        if self.n == 0:
            return np.zeros(0)
        q, dq, tau, diagonal = self.motion
        self._armature[:] = diagonal
        pin.crba(self._model, self._data, q)
        if len(off_diagonal):
            self._M[self._pairs] += off_diagonal
        tau -= pin.nonLinearEffects(self._model, self._data, q, dq)
        pin.cholesky.decompose(self._model, self._data)
        ddq: Vector = pin.cholesky.solve(self._model, self._data, tau)
        return ddq

    def feel(self) -> None:
        """Find the wrenches between the sensors' sides in `cut_motion`."""
        q, dq, ddq = self.cut_motion
        pin.rnea(self._cut, self._cut_data, q, dq, ddq)
        if self._near_on_far:
            np.negative(self._near_on_far, out=self.wrenches)

    def push_point(self, frame: str, point_m: Sequence[float]) -> PushPoint | None:
        """A point (m) in a link or joint frame of the URDF; None without such a frame."""
        if not self._model.existFrame(frame):
            return None
        link = self._cut.frames[frame_index(self._cut, frame)]
        before = set(self._cut.supports[link.parentJoint])
        felt = tuple(joint in before for joint in self._sensor_joints)
        return PushPoint(frame_index(self._model, frame), np.array(point_m), felt)

    def pushed(self, q_rad: Vector, push: Push) -> tuple[Vector, Vector]:
        """Joint torques of a push, and its wrench (6: N, Nm) about the base's origin."""
        q, frame = self._posture(q_rad), push.at.frame
        J = pin.computeFrameJacobian(self._model, self._data, q, frame, pin.WORLD)
        point_m = pin.updateFramePlacement(self._model, self._data, frame).act(push.at.point_m)
        wrench: Vector = np.concatenate([push.force_n, pin.skew(point_m) @ push.force_n])
        return J[:, self.columns].T @ wrench, wrench

    def feel_push(self, at: PushPoint, wrench: Vector) -> None:
        """Add to the wrenches just felt that of a push (6, about the base's origin)."""
        pin.updateGlobalPlacements(self._cut, self._cut_data)  # rnea leaves them as they were
        push = pin.Force(wrench)
        for felt, row, place in zip(at.felt, self.wrenches, self._sensor_places, strict=True):
            if felt:
                row += place.actInv(push).vector

    def tip_pose(self, q_rad: Vector) -> tuple[Vector, Vector]:
        """Position (3, m) and rotation vector (3, rad) of the tip frame in the base frame."""
        pin.forwardKinematics(self._model, self._data, self._posture(q_rad))
        place = pin.updateFramePlacement(self._model, self._data, self._tip)
        rotation_rad: Vector = pin.log3(place.rotation)
        return place.translation.copy(), rotation_rad

    def _posture(self, q_rad: Vector) -> Vector:
        q: Vector = np.zeros(self._model.nv)
        q[self.columns] = q_rad
        return q

    def inertial_points(self, frames: Sequence[str]) -> "InertialPoints":
        """The motion of points of the links, as of the last `feel`."""
        return InertialPoints(self._cut, self._cut_data, frames)


class InertialPoints:
    """What accelerometers and gyroscopes in frames of the URDF read: rows in their own axes."""

    def __init__(self, model: "pin.Model", data: "pin.Data", frames: Sequence[str]) -> None:
        places = [model.frames[frame_index(model, frame)] for frame in frames]
        self._model, self._data = model, data
        self._joints = [place.parentJoint for place in places]
        # A point of a link that the base carries has no joint: it stands still, and feels gravity.
        self._speeds = [data.v[i].vector for i in self._joints]
        self._accelerations = [data.a_gf[i].vector for i in self._joints]
        self._turn = np.array([place.placement.rotation.T for place in places]).reshape(-1, 3, 3)
        points = [pin.skew(place.placement.translation) for place in places]
        self._minus_point_m = -np.array(points).reshape(-1, 3, 3)  # turns a rate into a speed
        self._placements = [place.placement for place in places]

    def read(self) -> tuple[Matrix, Matrix]:
        """Specific force (k x 3, m/s2; +9.81 upwards at rest) and turn rate (k x 3, rad/s)."""
        speed = np.array(self._speeds)[:, :, None]
        acceleration = np.array(self._accelerations)[:, :, None]
        v, w = speed[:, :3], speed[:, 3:]
        at_point = v + self._minus_point_m @ w
        force = acceleration[:, :3] + self._minus_point_m @ acceleration[:, 3:]
        force += np.cross(w, at_point, axis=1)
        return (self._turn @ force)[:, :, 0], (self._turn @ w)[:, :, 0]

    def orientation(self, index: int, mounted: Matrix) -> tuple[Matrix, list[float]]:
        """Rotation (3x3) and quaternion (w, x, y, z) from a sensor's axes to the base's.

        `mounted` (3x3) turns the frame's axes into the sensor's.
        """
        pin.updateGlobalPlacements(self._model, self._data)
        place = self._data.oMi[self._joints[index]] * self._placements[index]
        R: Matrix = place.rotation @ mounted.T
        x, y, z, w = pin.Quaternion(R).coeffs().tolist()
        return R, [w, x, y, z]


def _pair_columns(at: Indices, coupled: Pairs) -> tuple[Indices, Indices]:
    """Places of the coupled pairs in the upper triangle of M."""
    columns = [sorted((int(at[i]), int(at[j]))) for i, j in coupled]
    upper = np.array(columns, dtype=np.intp).reshape(-1, 2)
    return upper[:, 0], upper[:, 1]


def _disturb(model: "pin.Model", spec: PlantSpec) -> None:
    """Change mass and centre of mass of every moving body, in place.

    In place because pinocchio's Inertia constructor refuses one link of iCubLisboa01.
    """
    mass_rng, lever_rng = generator(spec.seed, Draw.MASS), generator(spec.seed, Draw.LEVER)
    for i in range(1, model.njoints):
        factor = 1.0 + mass_rng.uniform(-spec.mass_error, spec.mass_error)
        direction = lever_rng.standard_normal(3)
        body = model.inertias[i]
        if body.mass > 0.0:
            body.mass = body.mass * factor
            body.lever = body.lever + spec.com_error_m * direction / np.linalg.norm(direction)
