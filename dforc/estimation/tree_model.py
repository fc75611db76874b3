"""The whole robot as flat arrays: a tree of bodies that is cut at the force-torque sensors.

A body is what moves as one: the links between two moving joints, cut in two at a sensor. Body 0 is
the base (root_link of the iCub); each other body turns about one joint, or, beyond a sensor, stands
still on the body before it. Parents come before children. Everything is given in the body's own
frame, whose origin lies on its joint. SI units and radians.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector, constant
from dforc.robot_model import ModelError, joint_columns, load_model

Indices = NDArray[np.int64]
Places = NDArray[np.int64]  # a table of them


class FramePlace(NamedTuple):
    """Where a frame sits on its body."""

    body: int
    R: Matrix  # (3, 3), the frame's axes in the body's
    p: Vector  # (3,), m


class TreeModel:
    """Geometry and inertias of a whole robot.

    `sensors` maps each sensor's name to the fixed joint of the URDF that carries it; the sensor
    frame is that joint's child link frame. Joints that are not named are locked at zero.
    """

    def __init__(
        self, model: "pin.Model", joints: Sequence[str], sensors: Mapping[str, str]
    ) -> None:
        self.pin_model = model
        self.joints = tuple(joints)
        self.n = len(self.joints)
        self.sensors = tuple(sensors)
        self.m = len(self.sensors)
        self.bodies: int = model.njoints
        self.sensor_body = tuple(model.getJointId(joint) for joint in sensors.values())
        self.columns = joint_columns(model, self.joints)  # of pinocchio's joint vector
        self.parent: Indices = np.array([max(0, int(i)) for i in model.parents], dtype=np.int64)
        self.joint: Indices = np.full(self.bodies, -1, dtype=np.int64)  # of each body
        self.body_of_joint = np.array([model.getJointId(name) for name in self.joints], np.int64)
        self.joint[self.body_of_joint] = np.arange(self.n)
        places = list(model.jointPlacements)
        self.R: Matrix = constant(np.array([place.rotation for place in places]))
        self.p: Matrix = constant(np.array([place.translation for place in places]))
        self.axis: Matrix = constant(np.array([_axis(model, i) for i in range(self.bodies)]))
        inertias = list(model.inertias)
        self.mass: Vector = constant([body.mass for body in inertias])
        self.centre: Matrix = constant(np.array([body.lever for body in inertias]))
        self.inertia: Matrix = constant(np.array([body.inertia for body in inertias]))
        self._frames = _frames(model)
        self.links = tuple(f.name for f in model.frames if f.type == pin.FrameType.BODY)
        self.carries: Matrix = constant(_carries(model, self.joint, self.n))

    @classmethod
    def from_urdf(
        cls, urdf_path: str, joints: Sequence[str], sensors: Mapping[str, str]
    ) -> "TreeModel":
        """Load a model.

        Raises:
            ModelError: the file is unreadable, or lacks a joint (the known ones are listed), or a
                joint is no hinge.
        """
        if len(set(joints)) != len(joints) or len(set(sensors.values())) != len(sensors):
            raise ModelError(f"{urdf_path}: a joint or sensor is named twice")
        return cls(load_model(str(urdf_path), joints, tuple(sensors.values())), joints, sensors)

    def has_frame(self, name: str) -> bool:
        """Whether a link or frame bears this name."""
        return name in self._frames

    def frame(self, name: str) -> FramePlace:
        """Where a link or frame of the URDF sits."""
        if name not in self._frames:
            known = ", ".join(link for link in self.links if "skin" not in link)
            raise ModelError(f"the robot model has no frame {name!r}; its links are {known}")
        return self._frames[name]

    def body_of(self, link: str) -> int:
        """The body that a link belongs to."""
        return self.frame(link).body

    def links_of_body(self, body: int) -> tuple[str, ...]:
        """Names of the links that move as this body."""
        return tuple(link for link in self.links if self._frames[link].body == body)

    def link_of_sensor(self, name: str) -> str:
        """The first link beyond a sensor."""
        links = self.links_of_body(self.sensor_body[self.sensors.index(name)])
        return links[0] if links else ""


def _axis(model: "pin.Model", body: int) -> Vector:
    """Unit axis of a body's joint, which is not moved by turning about it."""
    joint = model.joints[body]
    if body == 0 or joint.nv == 0:
        return np.zeros(3)
    data = joint.createData()
    joint.calc(data, np.zeros(joint.nq))
    axis: Vector = np.ravel(data.S)[3:]
    if joint.nv != 1 or joint.nq != 1 or not axis.any():
        raise ModelError(f"joint {model.names[body]!r} does not turn about one axis")
    return axis / np.linalg.norm(axis)


def _carries(model: "pin.Model", joint: Indices, n: int) -> Matrix:
    """(n, bodies): 1 where turning a joint moves a body."""
    found = np.zeros((n, model.njoints))
    for body, path in enumerate(model.supports):
        for above in path:
            if joint[above] >= 0:
                found[joint[above], body] = 1.0
    return found


def _frames(model: "pin.Model") -> dict[str, FramePlace]:
    """Every frame by name; where a link and a joint share one, the link's."""
    found: dict[str, FramePlace] = {}
    for frame in model.frames:
        if frame.name not in found or frame.type == pin.FrameType.BODY:
            place = frame.placement
            found[frame.name] = FramePlace(
                int(frame.parentJoint), constant(place.rotation), constant(place.translation)
            )
    return found
