"""What the Python client of the Cartesian controller takes and gives."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc import rotation
from dforc.arrays import ArrayLike, Matrix, Vector
from services.core.errors import ServiceError
from services.reaching.cartesian_messages import CartesianSettings, MotionState, TipVelocity
from services.reaching.messages import IkAnswer, TipOffset, TipPose

Rotation = Matrix | Sequence[float]
"""A matrix (3, 3), a rotation vector (3 numbers), or an axis and an angle (4 numbers) [rad]."""


class RequestRefusedError(ServiceError):
    """The Cartesian controller does not do what was asked; the text says why."""

    def __init__(self, reason: str, answer: IkAnswer | None = None) -> None:
        super().__init__(reason)
        self.answer = answer  # of inverse kinematics, where a pose is out of reach


class MotionFailedError(ServiceError):
    """A motion has ended elsewhere than where it led; the text says why."""

    def __init__(self, state: MotionState) -> None:
        super().__init__(f"motion {state.motion} of {state.limb} {state.outcome}: {state.reason}")
        self.state = state


class WaitTimeoutError(ServiceError, TimeoutError):
    """A motion goes on for longer than was to be waited."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where a hand is, or is to be, base frame."""

    position_m: Vector  # (3,)
    rotation: Matrix  # (3, 3)

    @classmethod
    def of(cls, pose: TipPose) -> "Pose":
        """A pose that a reply carries: always whole."""
        if pose.position_m is None or pose.rotation_rad is None:
            raise ServiceError(f"{pose} is half a pose")
        return cls(np.array(pose.position_m), rotation.matrix(pose.rotation_rad))


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """What inverse kinematics finds for poses."""

    angles_rad: dict[str, float]  # by joint
    poses: tuple[Pose, ...]  # that the posture has
    answer: IkAnswer  # status, errors, and what would help where they are not small


@dataclass(frozen=True, slots=True, eq=False)
class PlanSpeeds:
    """How the plan moves now."""

    joints_rad_s: dict[str, float]
    tips: tuple[TipVelocity, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How a limb is used."""

    free: dict[str, bool]  # joints that may move
    rest_rad: dict[str, float]
    rest_weights: dict[str, float]
    limits_rad: dict[str, tuple[float, float]]
    tip_offsets: tuple[TipOffset, ...]
    priority: str
    trajectory_time_s: float
    in_target_m: float
    in_target_rad: float
    tracking: bool
    reference_mode: bool
    law: str
    straightness: float | None  # None: the law's own
    solving: CartesianSettings  # what tunes inverse kinematics, and all of the above as it was told

    @classmethod
    def of(cls, told: CartesianSettings) -> "Settings":
        """As a reply carries them: all of them."""
        return cls(
            free=dict(told.free),
            rest_rad=dict(told.rest_rad),
            rest_weights=dict(told.rest_weights),
            limits_rad={name: (low, high) for name, low, high in told.limits_rad},
            tip_offsets=told.tip_offsets or (),
            priority=told.priority or "",
            trajectory_time_s=told.trajectory_time_s or math.nan,
            in_target_m=told.in_target_m or math.nan,
            in_target_rad=told.in_target_rad or math.nan,
            tracking=bool(told.tracking),
            reference_mode=bool(told.reference_mode),
            law=told.law or "",
            straightness=told.straightness,
            solving=told,
        )


def tip_pose(position_m: ArrayLike | None, turned: Rotation | None) -> TipPose:
    """A pose as a request carries it.

    Raises:
        ServiceError: it has another number of values.
    """
    place = None if position_m is None else [float(x) for x in position_m]
    if place is not None and len(place) != 3:
        raise ServiceError(f"a position has 3 numbers, not {len(place)}")
    return TipPose(
        position_m=None if place is None else (place[0], place[1], place[2]),
        rotation_rad=None if turned is None else rotation_numbers(turned),
    )


def rotation_numbers(turned: Rotation) -> tuple[float, ...]:
    """A rotation as a request carries it: a matrix becomes a rotation vector.

    Raises:
        ServiceError: it is none of the three kinds.
    """
    values: NDArray[np.float64] = np.asarray(turned, dtype=np.float64)
    if values.shape == (3, 3):
        if np.abs(values @ values.T - np.eye(3)).max() > 1e-6 or np.linalg.det(values) < 0.0:
            raise ServiceError(f"no rotation matrix: {values.tolist()}")
        values = rotation.rotation_vector(values)
    if values.shape not in ((3,), (4,)):
        raise ServiceError(
            f"a rotation is a matrix (3, 3), a vector (3) or an axis with an angle (4), "
            f"not {values.shape}"
        )
    return tuple(values.tolist())


def pairs(values: Mapping[str, float] | None) -> tuple[tuple[str, float], ...]:
    """Values by joint as a request carries them."""
    return tuple((name, float(value)) for name, value in (values or {}).items())
