"""Poses as messages carry them, and as the numerics want them."""

from collections.abc import Sequence

import numpy as np

from dforc import rotation
from dforc.arrays import Matrix, Vector
from dforc.cartesian.targets import PoseTarget
from dforc.ik.problem import Tip, TipTarget
from services.core.errors import ServiceError
from services.messages import Vector3
from services.reaching.cartesian_messages import TipVelocity
from services.reaching.messages import TipPose


class PoseError(ServiceError):
    """Numbers that are no pose."""


def tip_pose(pose: tuple[Matrix, Vector]) -> TipPose:
    """Rotation and position as a message carries them, the orientation as a rotation vector."""
    turned, place = pose
    return TipPose(
        position_m=vector3(place), rotation_rad=vector3(rotation.rotation_vector(turned))
    )


def tip_velocity(velocity: Vector) -> TipVelocity:
    """A velocity (6,), linear then angular, as a message carries it."""
    return TipVelocity(linear_m_s=vector3(velocity[:3]), angular_rad_s=vector3(velocity[3:]))


def joint_pose(tip: Tip, q_rad: Vector, joint: int) -> tuple[Matrix, Vector]:
    """Rotation and position of the link that a joint moves, at the joint's own frame."""
    placed: list[tuple[Matrix, Vector]] = []
    for element in tip.model.chain_description():
        turned, place = (np.eye(3), np.zeros(3)) if element.parent < 0 else placed[element.parent]
        here = turned @ element.R
        if element.joint >= 0:
            here = here @ rotation.matrix(element.axis * q_rad[element.joint])
        placed.append((here, place + turned @ element.p))
        if element.joint == joint:
            return placed[-1]
    raise PoseError(f"tip {tip.name} does not hang on joint {joint}")


def reached_poses(
    tips: Sequence[Tip], asked: Sequence[TipTarget | None], q_rad: Vector
) -> tuple[PoseTarget | None, ...]:
    """Where a posture puts the tips that are asked for; what was left free stays free."""
    poses: list[PoseTarget | None] = []
    for tip, target in zip(tips, asked, strict=True):
        if target is None:
            poses.append(None)
            continue
        turned, place = tip.pose(q_rad)
        kept = None if target.rotation is None else turned
        poses.append(PoseTarget(position_m=place, rotation=kept))
    return tuple(poses)


def vector3(values: Vector) -> Vector3:
    """A vector (3,) as a message carries it."""
    x, y, z = values.tolist()
    return (x, y, z)
