"""Poses of messages, checked, as the numerics take them."""

import math

from dforc import rotation
from dforc.arrays import Matrix
from dforc.errors import DforcError
from dforc.ik.problem import TipTarget
from services.core.errors import ConfigError
from services.messages import Floats, VirtualPoint
from services.reaching.messages import PoseTarget, TipPose

FARTHEST_M = 1000.0  # no robot's hand goes there, and squares of it are numbers
SMALLEST_AXIS = 1e-9  # below it an axis has no direction

Targets = tuple[TipTarget | None, ...]


def pose_targets(pose: PoseTarget, tips: int) -> Targets:
    """One target per tip; tips that the pose leaves out are free.

    Raises:
        ConfigError: more tips than the limb has, none that is asked for, or no pose.
    """
    if len(pose.tips) > tips:
        raise ConfigError(f"{len(pose.tips)} tips; the limb has {tips}")
    given = tuple(_target(tip) for tip in pose.tips)
    if not any(given):
        raise ConfigError("neither position nor orientation is given for any tip")
    return given + (None,) * (tips - len(given))


def point_targets(point: VirtualPoint, tips: int) -> Targets:
    """The same for a virtual point.

    Raises:
        ConfigError: it has two tips and the limb one, or is no pose.
    """
    turned = None if point.position_only else point.rotation_rad
    first = TipPose(position_m=point.position_m, rotation_rad=turned)
    if point.second_position_m is None and point.second_rotation_rad is None:
        return pose_targets(PoseTarget(tips=(first,)), tips)
    second = TipPose(position_m=point.second_position_m, rotation_rad=point.second_rotation_rad)
    return pose_targets(PoseTarget(tips=(first, second)), tips)


def rotation_of(values: Floats) -> Matrix:
    """Rotation matrix of a rotation vector (3 numbers), or of an axis and an angle (4).

    Raises:
        ConfigError: another number of them, or an axis without direction.
        NotFiniteError: NaN or infinity.
    """
    if len(values) == 3:
        return rotation.matrix(values)
    if len(values) != 4:
        raise ConfigError(
            f"a rotation is a vector of 3 numbers or axis and angle, 4; not {len(values)}"
        )
    *axis, angle_rad = values
    length = math.hypot(*axis)
    if length >= SMALLEST_AXIS:
        return rotation.matrix([angle_rad * part / length for part in axis])
    if angle_rad != 0.0:
        raise ConfigError(f"rotation by {angle_rad:g} rad about an axis of length {length:g}")
    return rotation.matrix((0.0, 0.0, 0.0))


def _target(pose: TipPose | None) -> TipTarget | None:
    if pose is None or (pose.position_m is None and pose.rotation_rad is None):
        return None
    if pose.position_m is not None and max(map(abs, pose.position_m)) > FARTHEST_M:
        raise ConfigError(f"target position {pose.position_m} is more than {FARTHEST_M:g} m away")
    try:
        turned = None if pose.rotation_rad is None else rotation_of(pose.rotation_rad)
        return TipTarget.checked(pose.position_m, turned)
    except DforcError as error:
        raise ConfigError(str(error)) from error
