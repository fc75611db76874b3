"""A set-up of a limb, put into the problem of its inverse kinematics."""

import numpy as np

from dforc import rotation
from dforc.errors import DforcError
from dforc.ik.problem import IkProblem, Priority, Tip
from dforc.limits import JointLimits
from services.core.errors import ConfigError
from services.reaching.messages import LimbSetup

FARTHEST_M = 10.0  # no tool is longer
PER_JOINT = ("free", "rest_rad", "rest_weights", "lower_rad", "upper_rad")


def apply_setup(problem: IkProblem, setup: LimbSetup) -> IkProblem:
    """A limb's own problem (of the robot file), changed as a set-up says.

    Raises:
        ConfigError: the set-up does not fit the limb; the text says what.
    """
    for name in PER_JOINT:
        values = getattr(setup, name)
        if values and len(values) != problem.n:
            raise ConfigError(f"{name} has {len(values)} values; the limb has {problem.n} joints")
    if setup.tip_offsets and len(setup.tip_offsets) != len(problem.tips):
        given = len(setup.tip_offsets)
        raise ConfigError(f"{given} tip offsets; the limb has {len(problem.tips)} tips")
    if any(not abs(x) <= FARTHEST_M for offset in setup.tip_offsets for x in offset.position_m):
        raise ConfigError(f"a tip offset of more than {FARTHEST_M:g} m")
    if setup.priority not in ("", *Priority):
        known = ", ".join(Priority)
        raise ConfigError(f"unknown priority {setup.priority!r}; known: {known}")
    try:
        return problem.changed(**_changes(problem, setup))
    except DforcError as error:
        raise ConfigError(str(error)) from error


def _changes(problem: IkProblem, setup: LimbSetup) -> dict[str, object]:
    """The fields that differ from the robot file's."""
    changes: dict[str, object] = {}
    for name in ("free", "rest_rad", "rest_weights"):
        if getattr(setup, name):
            changes[name] = np.array(getattr(setup, name))
    for name in ("priority", "position_tolerance_m", "orientation_tolerance_rad"):
        if getattr(setup, name):
            changes[name] = getattr(setup, name)
    if setup.rest_beta is not None:
        changes["beta"] = setup.rest_beta
    if setup.lower_rad or setup.upper_rad:
        changes["limits"] = _narrowed(problem.limits, setup)
    if setup.tip_offsets:
        changes["tips"] = _moved(problem.tips, setup)
    return changes


def _narrowed(limits: JointLimits, setup: LimbSetup) -> JointLimits:
    """Limits inside the robot's own, whatever the set-up says."""
    n = limits.n
    lower = np.maximum(limits.lower_rad, setup.lower_rad or -np.inf)
    upper = np.minimum(limits.upper_rad, setup.upper_rad or np.inf)
    return JointLimits.make(lower, upper, limits.rows, limits.lower[n:], limits.upper[n:])


def _moved(tips: tuple[Tip, ...], setup: LimbSetup) -> tuple[Tip, ...]:
    return tuple(
        tip.attached(rotation.matrix(offset.rotation_rad), offset.position_m)
        for tip, offset in zip(tips, setup.tip_offsets, strict=True)
    )
