"""Goals as messages carry them, checked, and as the modes take them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec
import numpy as np

from dforc import rotation
from dforc.arrays import Matrix
from services.core.errors import ConfigError
from services.fields.limbs import FieldLimb
from services.fields.mode import Goals, HandGoal
from services.fields.object_checks import FARTHEST_M, FASTEST_M_S
from services.fields.seen import SeenObject
from services.fields.sources import find_object, names_of
from services.fields.standstill import ARRIVED_M
from services.messages import Goal, Vector3


@dataclass(frozen=True, slots=True, kw_only=True)
class ActiveGoal:
    """A goal that has passed the checks."""

    number: int
    limb: str
    message: Goal  # its stamp is 0

    def hands(self, limb: FieldLimb, seen: tuple[SeenObject, ...]) -> tuple[Goals | None, str]:
        """What the hands are to do now; None with the reason where that is not known."""
        asked = self.message
        position_m, velocity_m_s = asked.position_m, asked.velocity_m_s
        if asked.follow:
            followed = find_object(seen, asked.follow)
            if followed is None:
                return None, no_object(asked.follow, seen)
            if followed.lost:
                return None, f"object {followed.name!r} is lost: {followed.lost}"
            position_m, velocity_m_s = followed.place_m, followed.velocity_m_s
        turned = None if asked.position_only else rotation.matrix(asked.rotation_rad)
        first = _hand_goal(position_m, turned, velocity_m_s)
        if limb.hands == 1:
            return (first,), ""
        if asked.second_position_m is None:
            return (first, None), ""
        second = asked.second_rotation_rad
        turned = None if second is None else rotation.matrix(second)
        return (first, _hand_goal(asked.second_position_m, turned, asked.second_velocity_m_s)), ""


def checked_goal(
    message: Goal, limbs: Mapping[str, FieldLimb], main: str, number: int
) -> ActiveGoal:
    """A goal, if it is one.

    Raises:
        ConfigError: it is none; the text says why.
    """
    limb = message.limb or main
    if limb not in limbs:
        raise ConfigError(f"unknown limb {limb!r}; there are: {', '.join(limbs)}")
    for name, values, most in (
        ("position_m", message.position_m, FARTHEST_M),
        ("rotation_rad", message.rotation_rad, math.inf),
        ("velocity_m_s", message.velocity_m_s, FASTEST_M_S),
        ("second_position_m", message.second_position_m or (), FARTHEST_M),
        ("second_rotation_rad", message.second_rotation_rad or (), math.inf),
        ("second_velocity_m_s", message.second_velocity_m_s, FASTEST_M_S),
    ):
        for value in values:
            if not math.isfinite(value):
                raise ConfigError(f"a goal whose {name} is not finite: {value}")
            if abs(value) > most:
                raise ConfigError(f"a goal whose {name} of {value:g} is beyond {most:g}")
    second = message.second_position_m is not None or message.second_rotation_rad is not None
    if second and limbs[limb].hands == 1:
        raise ConfigError(f"a second pose is for a limb with two hands; {limb} has one")
    if message.second_rotation_rad is not None and message.second_position_m is None:
        raise ConfigError("a second orientation needs a second position")
    return ActiveGoal(
        number=number, limb=limb, message=msgspec.structs.replace(message, stamp_ns=0, limb=limb)
    )


def no_object(name: str, seen: tuple[SeenObject, ...]) -> str:
    """Why an object cannot be followed that is not there."""
    return f"no object {name!r} to follow; there are: {names_of(seen)}"


def out_of_reach(limb: FieldLimb, goals: Goals) -> str:
    """Why no posture at all has the hands there; empty where one may, or is near enough."""
    beyond_m, hand = max(
        (
            (reach.beyond_m(goal.position_m), hand)
            for reach, hand, goal in zip(limb.reaches, limb.shape.tips, goals, strict=True)
            if goal is not None
        ),
        default=(-math.inf, ""),
    )
    if beyond_m <= ARRIVED_M:
        return ""
    return (
        f"at least {1e3 * beyond_m:.0f} mm beyond the reach of {hand}, which goes as near as it can"
    )


def _hand_goal(position_m: Vector3, turned: Matrix | None, velocity_m_s: Vector3) -> HandGoal:
    return HandGoal(
        position_m=np.array(position_m), rotation=turned, velocity_m_s=np.array(velocity_m_s)
    )
