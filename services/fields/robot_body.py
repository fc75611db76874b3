"""The robot's body for distances, from collision.toml beside the robot file.

    urdf = "<model>"        the model that the capsules were made for
    always_near             pairs of names that touch by construction: not kept apart
    [[capsules]]            name, link, start_m, end_m, radius_m in the link's frame

A robot without such a file, or with another model, gets one capsule from each joint to the next.
"""

from pathlib import Path

import msgspec
import numpy as np

from dforc.collision.body import Body, BodyCapsule
from dforc.collision.kernel_body import place_body
from dforc.collision.kernel_nearness import apart
from dforc.collision.obstacles import Triple
from dforc.errors import DforcError
from services.core.errors import ConfigError
from services.robotfile.limbs import BOTH_ARMS
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile, Strict
from services.robotfile.shape_tables import DEFAULT_RADIUS_M, child_origins

FILE = "collision.toml"


class CapsuleTable(Strict, frozen=True, kw_only=True):
    """[[capsules]]: one capsule."""

    name: str
    link: str
    start_m: Triple
    end_m: Triple
    radius_m: float


class CollisionFile(Strict, frozen=True, kw_only=True):
    """The whole file."""

    urdf: str
    capsules: tuple[CapsuleTable, ...]
    always_near: tuple[tuple[str, str], ...] = ()


def robot_body(robot: RobotFile) -> Body:
    """Body of all limbs in use, torso first; its tips are their hands. Other joints stay at zero.

    Only the arms are kept from the body and from each other: no posture of the torso brings chest
    or head to pelvis or legs. An arm that is not in use hangs at zero, in the way of the other.

    Raises:
        ConfigError: the file is wrong.
    """
    limbs = [limb for limb in robot.limbs.values() if limb.name != BOTH_ARMS]
    parts = dict.fromkeys(part for limb in limbs for part in limb.parts)
    joints = tuple(joint for part in parts for joint in robot.parts[part])
    tips = tuple(tip.frame for limb in limbs for tip in limb.tips)
    body = _whole_body(robot, joints, tips)
    arms = [joint for limb in limbs for joint in robot.parts[list(limb.parts)[-1]]]
    return body.keeping(body.moved_by(arms))


def _whole_body(robot: RobotFile, joints: tuple[str, ...], tips: tuple[str, ...]) -> Body:
    urdf = urdf_path(robot.robot.urdf)
    path = robot.path.with_name(FILE)
    file = read_collision_file(path)
    if file is None or file.urdf != robot.robot.urdf:
        capsules = _between_joints(urdf)
        return Body.make(str(urdf), joints, capsules, tips, _touching(urdf, joints, capsules))
    try:
        capsules = [
            BodyCapsule(
                name=row.name,
                link=row.link,
                start_m=row.start_m,
                end_m=row.end_m,
                radius_m=row.radius_m,
            )
            for row in file.capsules
        ]
        return Body.make(str(urdf), joints, capsules, tips, file.always_near)
    except DforcError as error:
        raise ConfigError(f"{path}: {error}") from error


def read_collision_file(path: Path) -> CollisionFile | None:
    """The file, or None where there is none.

    Raises:
        ConfigError: it is no TOML, or has an unknown or missing key.
    """
    if not path.is_file():
        return None
    try:
        return msgspec.toml.decode(path.read_bytes(), type=CollisionFile)
    except msgspec.DecodeError as error:  # a ValidationError is one, too
        raise ConfigError(f"{path}: {error}") from error


def _between_joints(urdf: Path) -> list[BodyCapsule]:
    """From the origin of each link with a mass to each of its child joints."""
    return [
        BodyCapsule(
            name=f"{link} {number}",
            link=link,
            start_m=(0.0, 0.0, 0.0),
            end_m=end,
            radius_m=DEFAULT_RADIUS_M,
        )
        for link, ends in child_origins(urdf).items()
        for number, end in enumerate(ends or [(0.0, 0.0, 0.0)])
    ]


def _touching(
    urdf: Path, joints: tuple[str, ...], capsules: list[BodyCapsule]
) -> list[tuple[str, str]]:
    """Pairs that overlap with all joints at zero."""
    body = Body.make(str(urdf), joints, capsules, ())
    arrays = body.arrays
    frames, segments = np.zeros((len(joints), 12)), np.zeros((len(capsules), 6))
    place_body(np.zeros(len(joints)), arrays, frames, segments)
    return [
        (body.capsules[i], body.capsules[j])
        for i, j in arrays.pairs.tolist()
        if apart(segments, i, j)[0] <= arrays.radii[i] + arrays.radii[j]
    ]
