"""Contact location without skin: pushes on the meshes of the links, answered from the wrench.

A contact is a point of the links' visual meshes that a finger can reach in the present posture,
evenly spread over that surface; the force, 5 to 20 N, comes from within 30 degrees of the surface's
normal and from where nothing is in its way. Postures are spread evenly over the joints' limits.
The answer uses the capsules of the robot's shapes, so their error is in the figures.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from benchmarks.link_meshes import Mesh, load_meshes
from dforc.arrays import Matrix, Vector
from dforc.contacts.location import Location, WrenchNoise, locate
from dforc.contacts.shapes import LinkShapes
from services.config import load_robot
from services.experiments.rows import Row, at_least, at_most
from services.robotfile.model_file import urdf_path
from services.robotfile.shape_tables import link_shapes

FORCE_N = (5.0, 20.0)
CONE_RAD = math.radians(30.0)
CONTACTS = 1000
SEED = 21
SENSOR = WrenchNoise()
# Of one component: root mean square error of the learner and of CAD on the real recording.
LEARNED = WrenchNoise(force_n=0.37, moment_nm=0.035)
DRAWN = WrenchNoise(force_n=0.65, moment_nm=0.06)


@dataclass(frozen=True, slots=True, kw_only=True)
class Limb:
    """A limb beyond a sensor; the joints behind it, which no other joint of the limb is beyond."""

    name: str
    sensor: str  # frame
    hand: str  # link at which a contact is assumed
    links: tuple[str, ...]
    wrist: tuple[str, ...]


ARM = Limb(
    name="right arm",
    sensor="r_upper_arm",
    hand="r_hand",
    links=("r_upper_arm", "r_forearm", "r_hand"),
    wrist=("r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw"),
)
LEG = Limb(
    name="left leg",
    sensor="l_hip_3",
    hand="l_foot",
    links=("l_upper_leg", "l_lower_leg", "l_ankle_1", "l_foot"),
    wrist=("l_ankle_pitch", "l_ankle_roll"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """A joint in the base frame, and the links beyond it."""

    axis: Vector
    origin_m: Vector
    beyond: frozenset[str]


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """One push and the posture it meets."""

    link: str
    point_m: Vector
    force_n: Vector
    sensor_m: Vector
    rotations: Matrix
    positions_m: Matrix
    axes: tuple[Axis, ...]


class Scene:
    """The model, its meshes, and one limb of it."""

    def __init__(self, urdf: Path, limb: Limb) -> None:
        self.limb = limb
        self._model = pin.buildModelFromUrdf(str(urdf))
        self._data = self._model.createData()
        meshes = load_meshes(urdf)
        self._meshes = [meshes[link] for link in limb.links]
        self._frames = [self._model.getFrameId(link) for link in limb.links]
        self._sensor = self._model.getFrameId(limb.sensor)

    def contacts(self, count: int, generator: np.random.Generator) -> list[Contact]:
        """Random pushes, evenly spread over what can be reached of the limb in random postures."""
        found: list[Contact] = []
        areas = np.array([mesh.areas.sum() for mesh in self._meshes])
        while len(found) < count:
            index = int(generator.choice(len(areas), p=areas / areas.sum()))
            point, outwards, force = _push(self._meshes[index], generator)
            clear = (outwards, -force)
            if any(self._meshes[index].is_hit(point, direction) for direction in clear):
                continue
            self._pose_all(generator)
            R, p = self._pose(self._frames[index])
            point, directions = R @ point + p, [R @ direction for direction in clear]
            if not any(self._is_hit(point, direction) for direction in directions):
                size = generator.uniform(*FORCE_N)
                found.append(self._seen(self.limb.links[index], point, size * (R @ force)))
        return found

    def _pose_all(self, generator: np.random.Generator) -> None:
        low, high = self._model.lowerPositionLimit, self._model.upperPositionLimit
        pin.computeJointJacobians(self._model, self._data, generator.uniform(low, high))
        pin.updateFramePlacements(self._model, self._data)

    def _is_hit(self, point: Vector, direction: Vector) -> bool:
        """Whether a ray meets a link of the limb."""
        for mesh, frame in zip(self._meshes, self._frames, strict=True):
            R, p = self._pose(frame)
            if mesh.is_hit(R.T @ (point - p), R.T @ direction):
                return True
        return False

    def _seen(self, link: str, point: Vector, force: Vector) -> Contact:
        poses = [self._pose(frame) for frame in self._frames]
        return Contact(
            link=link,
            point_m=point,
            force_n=force,
            sensor_m=self._pose(self._sensor)[1],
            rotations=np.array([R for R, _ in poses]),
            positions_m=np.array([p for _, p in poses]),
            axes=tuple(self._axis(name) for name in self.limb.wrist),
        )

    def _axis(self, name: str) -> Axis:
        joint = self._model.getJointId(name)
        place = self._data.oMi[joint]
        J = pin.getJointJacobian(
            self._model, self._data, joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        beyond = [
            link
            for link, frame in zip(self.limb.links, self._frames, strict=True)
            if joint in list(self._model.supports[self._model.frames[frame].parentJoint])
        ]
        column = self._model.idx_vs[joint]
        return Axis(J[3:, column].copy(), place.translation.copy(), frozenset(beyond))

    def _pose(self, frame: int) -> tuple[Matrix, Vector]:
        place = self._data.oMf[frame]
        return place.rotation.copy(), place.translation.copy()


def _within_cone(middle: Vector, generator: np.random.Generator) -> Vector:
    """A direction evenly spread over the cone about a unit vector."""
    cosine, turn = generator.uniform(math.cos(CONE_RAD), 1.0), generator.uniform(0, 2 * math.pi)
    side = np.cross(middle, np.eye(3)[int(np.abs(middle).argmin())])
    side /= np.linalg.norm(side)
    across = math.cos(turn) * side + math.sin(turn) * np.cross(middle, side)
    direction: Vector = cosine * middle + math.sqrt(1.0 - cosine * cosine) * across
    return direction


def _push(mesh: Mesh, generator: np.random.Generator) -> tuple[Vector, Vector, Vector]:
    """A point of the mesh, one of its normals, and a unit force from about there."""
    points, normals = mesh.random_points(1, generator)
    outwards = normals[0] * generator.choice((-1.0, 1.0))
    return points[0], outwards, _within_cone(-outwards, generator)


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What was made of one contact."""

    contact: Contact
    location: Location
    torque_nm: float  # mean error of the wrist's joints with this answer; unsure = at the hand
    assumed_nm: float  # the same, always assumed at the hand

    @property
    def sure(self) -> bool:
        """Whether the answer claims to know."""
        return self.location.certainty == "sure"

    @property
    def right(self) -> bool:
        """Whether the likeliest link is the one."""
        return self.location.link == self.contact.link


def answers(
    contacts: Sequence[Contact], limb: Limb, shapes: LinkShapes, noise: WrenchNoise
) -> list[Answer]:
    """Locate every contact from its noisy wrench."""
    generator = np.random.default_rng(SEED + 1)
    found = []
    for contact in contacts:
        exact = np.cross(contact.point_m - contact.sensor_m, contact.force_n)
        force = contact.force_n + noise.force_n * generator.standard_normal(3)
        moment = exact + noise.moment_nm * generator.standard_normal(3)
        posed = shapes.posed(contact.rotations, contact.positions_m)
        location = locate(force, moment, contact.sensor_m, posed, noise)
        link = location.link if location.certainty == "sure" else limb.hand
        found.append(
            Answer(
                contact,
                location,
                _torque_error(contact, force, moment, link),
                _torque_error(contact, force, moment, limb.hand),
            )
        )
    return found


def _torque_error(contact: Contact, force: Vector, moment: Vector, link: str) -> float:
    """Mean over the wrist's joints when the measured wrench is taken to act on `link`."""
    errors = []
    for joint in contact.axes:
        true = taken = 0.0
        if contact.link in joint.beyond:
            lever = contact.point_m - joint.origin_m
            true = float(joint.axis @ np.cross(lever, contact.force_n))
        if link in joint.beyond:
            lever = contact.sensor_m - joint.origin_m
            taken = float(joint.axis @ (moment + np.cross(lever, force)))
        errors.append(abs(taken - true))
    return sum(errors) / len(errors)


def location_rows(contacts: int = CONTACTS) -> list[Row]:
    """Right arm and left leg of the iCub, with the sensor's noise and with the model's errors."""
    robot = load_robot("icub")
    rows = []
    for limb in (ARM, LEG):
        scene = Scene(urdf_path(robot.robot.urdf), limb)
        all_shapes = link_shapes(robot)
        ordered = [c for link in limb.links for c in all_shapes.only([link]).capsules]
        shapes = LinkShapes(ordered)  # in the order of the poses
        pushes = scene.contacts(contacts, np.random.default_rng(SEED))
        rows += _rows(limb, answers(pushes, limb, shapes, SENSOR), "sensor noise", bars=True)
        for label, noise in (("learned model", LEARNED), ("CAD", DRAWN)):
            rows += _rows(limb, answers(pushes, limb, shapes, noise), f"error of {label}")
    return rows


def _rows(limb: Limb, found: Sequence[Answer], label: str, *, bars: bool = False) -> list[Row]:
    name = f"location, {limb.name}, {label}"
    total = len(found)
    sure = [answer for answer in found if answer.sure]
    right = [answer for answer in sure if answer.right]
    share, of_sure = len(right) / total, len(right) / max(len(sure), 1)
    elsewhere = [answer for answer in found if answer.contact.link != limb.hand]
    known_elsewhere = [answer for answer in right if answer.contact.link != limb.hand]
    share_elsewhere = len(known_elsewhere) / len(elsewhere)
    torque = float(np.mean([answer.torque_nm for answer in found]))
    assumed = float(np.mean([answer.assumed_nm for answer in found]))
    apart = [float(np.linalg.norm(a.location.point_m - a.contact.point_m)) for a in right]
    shares = [
        at_least(f"{name}: right link, of all", share, "", 0.9)
        if bars
        else Row(f"{name}: right link, of all", share),
        at_least(f"{name}: right link, of those not on {limb.hand}", share_elsewhere, "", 0.9)
        if bars
        else Row(f"{name}: right link, of those not on {limb.hand}", share_elsewhere),
        at_least(f"{name}: right link, of the answered", of_sure, "", 0.9)
        if bars
        else Row(f"{name}: right link, of the answered", of_sure),
        Row(f"{name}: wrong link, of all", (len(sure) - len(right)) / total),
        Row(f"{name}: unsure, of all", (total - len(sure)) / total),
    ]
    each = []
    for link in limb.links if bars else ():
        own = [answer for answer in found if answer.contact.link == link]
        known = sum(answer.sure and answer.right for answer in own) / max(len(own), 1)
        each.append(Row(f"{name}: right, of {len(own)} on {link}", known))
    return [
        *shares,
        *each,
        Row(f"{name}: distance to the point, median", float(np.median(apart)) * 1e3, "mm"),
        at_most(f"{name}: wrist torque error, mean", torque, "Nm", 0.2)
        if bars
        else Row(f"{name}: wrist torque error, mean", torque, "Nm"),
        Row(f"{name}: the same, assumed at the hand", assumed, "Nm"),
    ]
