"""How a limb is used, and how requests change that.

What inverse kinematics has to know is in a LimbSetup with every value filled in; the rest is the
controller's. Limits may only narrow those of the robot file. A rest weight is taken as it is: half
a weight pulls half as much, and none pulls nowhere.
"""

import math
from collections.abc import Sequence
from typing import TypeVar

import msgspec
import numpy as np

from dforc.cartesian.params import Law
from services.core.errors import ConfigError, ServiceError
from services.reaching.cartesian_messages import CartesianSettings
from services.reaching.limb_setup import apply_setup
from services.reaching.limb_shape import LimbShape
from services.reaching.messages import LimbSetup, TipOffset

ValueT = TypeVar("ValueT")

SHORTEST_TRAJECTORY_S = 0.1  # ten periods
LONGEST_TRAJECTORY_S = 60.0
TRAJECTORY_S = 2.0  # of requests, as the iCub's controller has it
IN_TARGET_M = 0.003
IN_TARGET_RAD = math.radians(1.5)
LARGEST_TOLERANCE_M = 0.1
LARGEST_TOLERANCE_RAD = 1.0
SAME_LIMIT_RAD = 1e-9


class SettingsError(ServiceError):
    """A change does not fit the limb; nothing of it is taken over."""


class LimbSettings(msgspec.Struct, frozen=True, kw_only=True):
    """All that a context stores of a limb."""

    setup: LimbSetup
    trajectory_time_s: float = TRAJECTORY_S
    in_target_m: float = IN_TARGET_M
    in_target_rad: float = IN_TARGET_RAD
    tracking: bool = False
    reference_mode: bool = False
    law: str = str(Law.TIME_TO_GO)
    straightness: float | None = None  # the law's own


def initial_settings(shape: LimbShape) -> LimbSettings:
    """As the robot file has it."""
    problem = shape.problem
    setup = LimbSetup(
        limb=shape.name,
        free=(True,) * shape.n,
        rest_rad=_floats(problem.rest_rad),
        rest_weights=_floats(problem.rest_weights),
        lower_rad=_floats(problem.limits.lower_rad),
        upper_rad=_floats(problem.limits.upper_rad),
        priority=str(problem.priority),
    )
    return LimbSettings(setup=setup)


def changed_settings(
    shape: LimbShape, settings: LimbSettings, change: CartesianSettings
) -> LimbSettings:
    """Settings after a change.

    Raises:
        SettingsError: it does not fit the limb; the text says what.
    """
    setup = _changed_setup(shape, settings.setup, change)
    try:
        apply_setup(shape.problem, setup)
    except ConfigError as error:
        raise SettingsError(str(error)) from error
    wanted = {
        name: value
        for name in (
            "trajectory_time_s",
            "in_target_m",
            "in_target_rad",
            "tracking",
            "reference_mode",
            "law",
            "straightness",
        )
        if (value := getattr(change, name)) is not None
    }
    changed = msgspec.structs.replace(settings, setup=setup, **wanted)
    _check_numbers(changed)
    if changed.law not in tuple(Law):
        raise SettingsError(f"no law {changed.law!r}; there are {', '.join(Law)}")
    return changed


def told(shape: LimbShape, settings: LimbSettings) -> CartesianSettings:
    """Settings as a reply carries them."""
    setup = settings.setup
    names = shape.joints
    return CartesianSettings(
        free=tuple(zip(names, setup.free, strict=True)),
        rest_rad=tuple(zip(names, setup.rest_rad, strict=True)),
        rest_weights=tuple(zip(names, setup.rest_weights, strict=True)),
        limits_rad=tuple(zip(names, setup.lower_rad, setup.upper_rad, strict=True)),
        tip_offsets=setup.tip_offsets or (TipOffset(),) * len(shape.tips),
        priority=setup.priority,
        position_tolerance_m=setup.position_tolerance_m,
        orientation_tolerance_rad=setup.orientation_tolerance_rad,
        rest_beta=shape.problem.beta if setup.rest_beta is None else setup.rest_beta,
        iterations=setup.iterations,
        solver=setup.solver,
        trajectory_time_s=settings.trajectory_time_s,
        in_target_m=settings.in_target_m,
        in_target_rad=settings.in_target_rad,
        tracking=settings.tracking,
        reference_mode=settings.reference_mode,
        law=settings.law,
        straightness=settings.straightness,
    )


def _changed_setup(shape: LimbShape, setup: LimbSetup, change: CartesianSettings) -> LimbSetup:
    free = _replaced(shape, setup.free, change.free, "free")
    for group in shape.together:
        states = {free[shape.joints.index(joint)] for joint in group}
        if len(states) > 1:
            raise SettingsError(f"{', '.join(group)} are freed and blocked together")
    lower = [(name, low) for name, low, _ in change.limits_rad]
    upper = [(name, high) for name, _, high in change.limits_rad]
    wanted = {
        name: value
        for name in (
            "priority",
            "position_tolerance_m",
            "orientation_tolerance_rad",
            "iterations",
            "solver",
        )
        if (value := getattr(change, name)) is not None
    }
    if change.tip_offsets is not None:
        wanted["tip_offsets"] = _tip_offsets(shape, change.tip_offsets)
    if change.rest_beta is not None:
        wanted["rest_beta"] = change.rest_beta if change.rest_beta >= 0.0 else None
    changed = msgspec.structs.replace(
        setup,
        free=free,
        rest_rad=_replaced(shape, setup.rest_rad, change.rest_rad, "rest_rad"),
        rest_weights=_replaced(shape, setup.rest_weights, change.rest_weights, "rest_weights"),
        lower_rad=_replaced(shape, setup.lower_rad, lower, "limits_rad"),
        upper_rad=_replaced(shape, setup.upper_rad, upper, "limits_rad"),
        **wanted,
    )
    _check_limits(shape, changed)
    return changed


def _replaced(
    shape: LimbShape,
    values: tuple[ValueT, ...],
    changes: Sequence[tuple[str, ValueT]],
    what: str,
) -> tuple[ValueT, ...]:
    """A vector with the values of the named joints exchanged."""
    after = list(values)
    for name, value in changes:
        if name not in shape.joints:
            raise SettingsError(
                f"{what}: {shape.name} has no joint {name!r}; it has {', '.join(shape.joints)}"
            )
        if not math.isfinite(float(value)):  # type: ignore[arg-type]
            raise SettingsError(f"{what}: {name}: {value} is not a number")
        after[shape.joints.index(name)] = value
    return tuple(after)


def _tip_offsets(shape: LimbShape, offsets: tuple[TipOffset, ...]) -> tuple[TipOffset, ...]:
    """Empty where the hands themselves go to the poses: that saves work every period."""
    if len(offsets) != len(shape.tips):
        raise SettingsError(f"{len(offsets)} tip offsets for {len(shape.tips)} tips")
    return () if all(offset == TipOffset() for offset in offsets) else offsets


def _check_limits(shape: LimbShape, setup: LimbSetup) -> None:
    limits = shape.problem.limits
    for i, name in enumerate(shape.joints):
        low, high = setup.lower_rad[i], setup.upper_rad[i]
        widest = (float(limits.lower_rad[i]), float(limits.upper_rad[i]))
        if low < widest[0] - SAME_LIMIT_RAD or high > widest[1] + SAME_LIMIT_RAD or low > high:
            within = f"{math.degrees(widest[0]):.1f} to {math.degrees(widest[1]):.1f} deg"
            raise SettingsError(f"limits_rad: {name}: limits can only be narrowed, within {within}")


def _check_numbers(settings: LimbSettings) -> None:
    straightness = 1.0 if settings.straightness is None else settings.straightness
    for name, value, least, most in (
        (
            "trajectory_time_s",
            settings.trajectory_time_s,
            SHORTEST_TRAJECTORY_S,
            LONGEST_TRAJECTORY_S,
        ),
        ("in_target_m", settings.in_target_m, 1e-5, LARGEST_TOLERANCE_M),
        ("in_target_rad", settings.in_target_rad, 1e-4, LARGEST_TOLERANCE_RAD),
        ("straightness", straightness, 1e-6, 1e6),
    ):
        if not least <= value <= most:
            raise SettingsError(f"{name} must be {least:g} to {most:g}, not {value}")


def _floats(values: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> tuple[float, ...]:
    return tuple(values.tolist())
