"""Robots, and random motions with random contacts whose every wrench is known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import icub_models
import numpy as np

from benchmarks.newton_euler import UP, Array, BaseState, NewtonEuler, Push, Truth
from dforc.estimation.assumption import Assumption, BaseMotion, Contact, Kind, Point
from dforc.estimation.tree_model import TreeModel
from services.robotfile.model_file import with_frames

LIMBS = ("l_arm_ft", "r_arm_ft", "l_leg_ft", "r_leg_ft")
FEET = ("l_foot_ft", "r_foot_ft")
URDFS = ("iCubLisboa01", "iCubGenova03", "iCubGazeboV2_5")
SOURCE = "imu_frame"
FORCE_N, MOMENT_NM = 20.0, 3.0

Motion = Mapping[str, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Robot:
    """One model, as the estimator and as the truth have it."""

    path: str
    tree: TreeModel
    truth: NewtonEuler


@dataclass(frozen=True, eq=False)
class Scene:
    """One motion with contacts."""

    q: Array
    dq: Array
    ddq: Array
    readings: Array  # (m, 6)
    imu: BaseMotion
    tau: Array
    wrenches: Array  # (k, 6), base axes, about the points
    points: Array
    base: Array
    internal: Array


def robot(urdf: str, sensors: Sequence[str]) -> Robot:
    """A model of icub-models with some of the six sensors; missing foot frames are put in."""
    path = Path(str(icub_models.get_model_file(urdf)))
    truth = NewtonEuler(path)
    missing = [f for f in FEET if f in sensors and f"{f}_sensor" not in truth.joints]
    if missing:
        path = with_frames(path, tuple((f"{f}_sensor", f"{f[0]}_ankle_roll") for f in missing))
        truth = NewtonEuler(path)
    names = {sensor: f"{sensor}_sensor" for sensor in sensors}
    return Robot(str(path), TreeModel.from_urdf(str(path), truth.revolute, names), truth)


def sub_models(robot: Robot, sensors: Sequence[str] | None = None) -> list[list[str]]:
    """Links between the sensors, found by walking the URDF: the base's first."""
    cuts = robot.tree.sensors if sensors is None else sensors
    beyond = [robot.truth.links_beyond(f"{sensor}_sensor") for sensor in cuts]
    groups = []
    for own in [set(robot.truth.bodies), *beyond]:
        inner = [other for other in beyond if other < own]
        groups.append(sorted(own.difference(*inner)))
    return groups


def random_contact(rng: np.random.Generator, links: Sequence[str], kind: Kind) -> Contact:
    """Anywhere on one of the links, within 20 cm of its origin."""
    x, y, z = rng.uniform(-0.2, 0.2, 3).tolist()
    direction = None
    if kind == "direction":
        n = rng.normal(size=3)
        direction = _point(n / np.linalg.norm(n))
    return Contact(
        frame=str(rng.choice(list(links))), point_m=(x, y, z), kind=kind, direction=direction
    )


def scene(rng: np.random.Generator, robot: Robot, assumption: Assumption) -> Scene:
    """A random motion in which every contact of the assumption carries a random wrench.

    Without mainstay the base accelerates as these wrenches make it.
    """
    n = robot.tree.n
    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, n))
    motion = dict(zip(robot.tree.joints, zip(q, dq, ddq, strict=True), strict=True))
    pushes = [_random_push(rng, contact) for contact in assumption.contacts]
    for known in assumption.known:
        wrench = np.array(known.wrench)
        pushes.append(Push(known.frame, np.array(known.point_m), wrench[:3], wrench[3:]))
    base = None
    if assumption.source:
        omega, domega = rng.uniform(-1.5, 1.5, (2, 3))
        base = BaseState(omega, domega, rng.uniform(-4.0, 4.0, 3) + UP)
    if not assumption.mainstay:
        base = _free(robot.truth, motion, pushes, base)
    truth = robot.truth.move(motion, pushes, base)
    return _scene(robot, truth, (q, dq, ddq), pushes[: len(assumption.contacts)], motion, base)


def _scene(
    robot: Robot,
    truth: Truth,
    motion: tuple[Array, Array, Array],
    contacts: Sequence[Push],
    by_name: Motion,
    base: BaseState | None,
) -> Scene:
    joints = [f"{sensor}_sensor" for sensor in robot.tree.sensors]
    alone = robot.truth.move(by_name, (), base)
    states = [truth.states[push.link] for push in contacts]
    pairs = list(zip(contacts, states, strict=True))
    wrenches = [np.concatenate([s.R @ c.force_n, s.R @ c.moment_nm]) for c, s in pairs]
    omega, domega, acceleration = truth.inertial(SOURCE)
    return Scene(
        *motion,
        readings=np.array([truth.reading(joint) for joint in joints]).reshape(-1, 6),
        imu=BaseMotion(
            omega_rad_s=_point(omega),
            domega_rad_s2=_point(domega),
            acceleration_m_s2=_point(acceleration),
        ),
        tau=np.array([truth.torque(joint) for joint in robot.tree.joints]),
        wrenches=np.array(wrenches).reshape(-1, 6),
        points=np.array([s.p + s.R @ c.point_m for c, s in pairs]).reshape(-1, 3),
        base=truth.base_need(),
        internal=np.array([alone.reading(joint) for joint in joints]).reshape(-1, 6),
    )


def _random_push(rng: np.random.Generator, contact: Contact) -> Push:
    force, moment = rng.uniform(-FORCE_N, FORCE_N, 3), rng.uniform(-MOMENT_NM, MOMENT_NM, 3)
    if contact.kind != "wrench":
        moment = np.zeros(3)
    if contact.direction is not None:
        force = rng.uniform(-FORCE_N, FORCE_N) * np.array(contact.direction)
    return Push(contact.frame, np.array(contact.point_m), force, moment)


def _free(
    robot: NewtonEuler, motion: Motion, pushes: Sequence[Push], base: BaseState | None
) -> BaseState:
    """The base's acceleration at which nothing has to hold it."""
    start = base or BaseState(np.zeros(3), np.zeros(3), UP)

    def need(x: Array) -> Array:
        return robot.move(motion, pushes, BaseState(start.omega, x[3:], x[:3])).base_need()

    rest = need(np.zeros(6))
    columns = np.array([need(x) - rest for x in np.eye(6)]).T
    x = -np.linalg.solve(columns, rest)
    return BaseState(start.omega, x[3:], x[:3])


def _point(values: Array) -> Point:
    x, y, z = values.tolist()
    return (x, y, z)
