"""Requests to tune one joint: names and numbers as they come, one of the HAL's changes out."""

import msgspec

from hal.description import Impedance, PositionPid, TorquePid
from hal.tuning import CurrentLimit, Tuning, VelocityLimit
from services.core.errors import ServiceError
from services.robot_messages import RobotRequest

KINDS: dict[str, type[Tuning]] = {
    "position_pid": PositionPid,
    "torque_pid": TorquePid,
    "impedance": Impedance,
    "current_limit": CurrentLimit,
    "velocity_limit": VelocityLimit,
}


class TuningError(ServiceError):
    """A request to tune that names no joint, no kind or no complete settings."""


def tuning_of(request: RobotRequest) -> tuple[str, Tuning]:
    """The joint, and what is to be changed of it: the kind is the request's value.

    Raises:
        TuningError: with what is known, or which setting is wrong or missing.
    """
    if len(request.joints) != 1:
        raise TuningError(f"tune takes one joint, not {len(request.joints)}")
    kind = KINDS.get(request.value)
    if kind is None:
        raise TuningError(f"cannot tune {request.value!r}; known: {', '.join(KINDS)}")
    try:
        return request.joints[0], msgspec.convert(dict(request.settings), kind)
    except msgspec.ValidationError as error:
        raise TuningError(f"{request.value}: {error}") from None
