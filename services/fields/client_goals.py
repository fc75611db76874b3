"""A goal as messages carry it, of what a user has in hand."""

from dforc.arrays import ArrayLike
from services.fields.client_objects import STILL, triple
from services.messages import Goal
from services.reaching.client_settings import as_vector
from services.reaching.client_types import Rotation


def make_goal(
    position_m: ArrayLike,
    rotation: Rotation | None = None,
    *,
    limb: str = "",
    velocity_m_s: ArrayLike = STILL,
    second_position_m: ArrayLike | None = None,
    second_rotation: Rotation | None = None,
    follow: str = "",
) -> Goal:
    """For a request; None of a rotation: any.

    Raises:
        ServiceError: another number of values.
    """
    return Goal(
        stamp_ns=0,
        position_m=triple(position_m),
        rotation_rad=STILL if rotation is None else as_vector(rotation),
        limb=limb,
        position_only=rotation is None,
        velocity_m_s=triple(velocity_m_s),
        second_position_m=None if second_position_m is None else triple(second_position_m),
        second_rotation_rad=None if second_rotation is None else as_vector(second_rotation),
        follow=follow,
    )
