"""Newton and Euler by the book, link by link of a URDF: the truth that estimates are held against.

Nothing is lumped or cut, nothing is shared with dforc: the file is read here a second time. Vectors
are in base axes, moments about the base's origin, the base is the URDF's root link. Slow.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 9.81])


@dataclass(frozen=True, eq=False)
class Push:
    """A wrench of the world on a link, given in that link's axes."""

    link: str
    point_m: Array
    force_n: Array
    moment_nm: Array


@dataclass(frozen=True, eq=False)
class BaseState:
    """Motion of the base in base axes; the acceleration is the proper one."""

    omega: Array
    domega: Array
    acceleration: Array


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the URDF, fixed or revolute."""

    name: str
    parent: str
    child: str
    R: Array
    p: Array
    axis: Array | None


@dataclass(frozen=True, eq=False)
class Body:
    """A link's inertia, about its centre of mass, in link axes."""

    mass: float
    centre: Array
    inertia: Array


@dataclass(eq=False)
class State:
    """Pose and motion of one link."""

    R: Array
    p: Array
    omega: Array
    domega: Array
    acceleration: Array


class Truth:
    """One posture and motion, with pushes: poses, torques, wrenches inside."""

    def __init__(
        self, robot: "NewtonEuler", states: dict[str, State], needs: dict[str, Array]
    ) -> None:
        self._robot, self.states, self._needs = robot, states, needs

    def torque(self, joint_name: str) -> float:
        """What the drive of a joint exerts."""
        joint = self._robot.joints[joint_name]
        assert joint.axis is not None
        state, need = self.states[joint.child], self._needs[joint.child]
        moment = need[3:] - cross(state.p, need[:3])
        return float(moment @ (state.R @ joint.axis))

    def reading(self, joint_name: str) -> Array:
        """What a sensor in a joint reads: the limb beyond on the near side, child axes."""
        child = self._robot.joints[joint_name].child
        state, need = self.states[child], self._needs[child]
        moment = need[3:] - cross(state.p, need[:3])
        return -np.concatenate([state.R.T @ need[:3], state.R.T @ moment])

    def base_need(self) -> Array:
        """What has to hold the base, about its origin."""
        return self._needs[self._robot.root]

    def inertial(self, link: str) -> tuple[Array, Array, Array]:
        """What an inertial sensor on a link feels, in its axes: omega, domega, acceleration."""
        state = self.states[link]
        return state.R.T @ state.omega, state.R.T @ state.domega, state.R.T @ state.acceleration


class NewtonEuler:
    """One robot."""

    def __init__(self, urdf: Path | str) -> None:
        root = ElementTree.parse(urdf).getroot()
        joints = [_joint(node) for node in root.findall("joint")]
        self.joints = {joint.name: joint for joint in joints}
        self.bodies = {str(node.get("name")): _body(node) for node in root.findall("link")}
        (self.root,) = set(self.bodies) - {joint.child for joint in joints}
        self.order = self._outwards(joints)
        self.revolute = [joint.name for joint in joints if joint.axis is not None]

    def _outwards(self, joints: list[Joint]) -> list[Joint]:
        order: list[Joint] = []
        reached, left = {self.root}, list(joints)
        while left:
            ready = [joint for joint in left if joint.parent in reached]
            order += ready
            reached |= {joint.child for joint in ready}
            left = [joint for joint in left if joint.child not in reached]
        return order

    def links_beyond(self, joint_name: str) -> set[str]:
        """All links that hang on a joint."""
        beyond = {self.joints[joint_name].child}
        for joint in self.order:
            if joint.parent in beyond:
                beyond.add(joint.child)
        return beyond

    def move(
        self,
        motion: Mapping[str, tuple[float, float, float]],
        pushes: Sequence[Push] = (),
        base: BaseState | None = None,
    ) -> Truth:
        """Angle, velocity and acceleration of each joint by name; those left out stay at zero."""
        still = np.zeros(3)
        start = base or BaseState(still, still, UP)
        zero = State(np.eye(3), still, start.omega, start.domega, start.acceleration)
        states = {self.root: zero}
        for joint in self.order:
            q, dq, ddq = motion.get(joint.name, (0.0, 0.0, 0.0))
            states[joint.child] = _beyond(states[joint.parent], joint, q, dq, ddq)
        needs = {link: _need(self.bodies[link], state) for link, state in states.items()}
        for push in pushes:
            state = states[push.link]
            force = state.R @ push.force_n
            point = state.p + state.R @ push.point_m
            moment = state.R @ push.moment_nm + cross(point, force)
            needs[push.link] = needs[push.link] - np.concatenate([force, moment])
        for joint in reversed(self.order):
            needs[joint.parent] = needs[joint.parent] + needs[joint.child]
        return Truth(self, states, needs)


def cross(a: Array, b: Array) -> Array:
    """Of two vectors; numpy's own takes ten times as long."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _beyond(before: State, joint: Joint, q: float, dq: float, ddq: float) -> State:
    """Equation 8 of the paper, for one joint."""
    R = before.R @ joint.R
    p = before.p + before.R @ joint.p
    lever = p - before.p
    swing = cross(before.omega, cross(before.omega, lever))
    acceleration = before.acceleration + cross(before.domega, lever) + swing
    if joint.axis is None:
        return State(R, p, before.omega, before.domega, acceleration)
    axis = R @ joint.axis
    omega = before.omega + dq * axis
    domega = before.domega + ddq * axis + cross(before.omega, dq * axis)
    return State(R @ _turn(joint.axis, q), p, omega, domega, acceleration)


def _need(body: Body, state: State) -> Array:
    """Equations 9 and 10 for one link: the wrench that it needs, about the base's origin."""
    if body.mass == 0.0 and not body.inertia.any():
        return np.zeros(6)
    lever = state.R @ body.centre
    swing = cross(state.omega, cross(state.omega, lever))
    force = body.mass * (state.acceleration + cross(state.domega, lever) + swing)
    inertia = state.R @ body.inertia @ state.R.T
    moment = inertia @ state.domega + cross(state.omega, inertia @ state.omega)
    return np.concatenate([force, moment + cross(state.p + lever, force)])


def _turn(axis: Array, angle: float) -> Array:
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Array = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    return turn


def _numbers(text: str | None, otherwise: str) -> Array:
    return np.array([float(part) for part in (text or otherwise).split()])


def _origin(node: ElementTree.Element) -> tuple[Array, Array]:
    origin = node.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    roll, pitch, yaw = _numbers(origin.get("rpy"), "0 0 0")
    x, y, z = np.eye(3)
    R = _turn(z, yaw) @ _turn(y, pitch) @ _turn(x, roll)
    return R, _numbers(origin.get("xyz"), "0 0 0")


def _joint(node: ElementTree.Element) -> Joint:
    ends = [
        str(end.get("link")) for end in (node.find("parent"), node.find("child")) if end is not None
    ]
    axis = None
    if node.get("type") in ("revolute", "continuous"):
        found = node.find("axis")
        axis = _numbers(None if found is None else found.get("xyz"), "1 0 0")
        axis = axis / np.linalg.norm(axis)
    return Joint(str(node.get("name")), ends[0], ends[1], *_origin(node), axis)


def _body(node: ElementTree.Element) -> Body:
    inertial = node.find("inertial")
    if inertial is None:
        return Body(0.0, np.zeros(3), np.zeros((3, 3)))
    mass, values = inertial.find("mass"), inertial.find("inertia")
    assert mass is not None
    assert values is not None
    R, p = _origin(inertial)
    names = ("ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz")
    I = np.array([float(values.get(name, "0")) for name in names]).reshape(3, 3)  # noqa: E741
    return Body(float(mass.get("value", "0")), p, R @ I @ R.T)
