"""Changing a joint's settings while the robot runs: checked, written, read back, or taken back.

What is accepted replaces the robot file's value until the robot is opened again, also when a board
restarts or another host meddles.
"""

import math
from collections.abc import Sequence as Values

import msgspec

from hal.axis import Axis
from hal.boards.board import sent
from hal.boards.settings import (
    Setting,
    current_limit_setting,
    impedance_setting,
    position_settings,
    torque_settings,
    velocity_limit_setting,
)
from hal.boards.verify import verify
from hal.description import Impedance, Joint, PositionPid, TorquePid
from hal.tasks import Sequence
from hal.wire.layout import WireError

MAX_SHIFT = 15  # of a 16-bit product
Gains = PositionPid | TorquePid


class CurrentLimit(msgspec.Struct, frozen=True):
    """Current at which the board's I2T watch begins."""

    limit_ma: int


class VelocityLimit(msgspec.Struct, frozen=True):
    """Speed that no set-point and no move exceeds; never above the robot file's."""

    limit_deg_s: float


Tuning = PositionPid | TorquePid | Impedance | CurrentLimit | VelocityLimit


def tune(axis: Axis, change: Tuning, robot_file: Joint, highest_ma: int) -> Sequence | str:
    """The work, or why it is refused. `highest_ma` is the most that the board accepts."""
    replace = msgspec.structs.replace
    joint = axis.joint
    if isinstance(change, PositionPid):
        reason = _wrong_gains(axis, change, robot_file.position_pid)
        joint = replace(joint, position_pid=change)
    elif isinstance(change, TorquePid):
        reason = f"{axis.name} has no torque gains in the robot file, so their sign is not known"
        if robot_file.torque_pid is not None:
            reason = _wrong_gains(axis, change, robot_file.torque_pid)
        joint = replace(joint, torque_pid=change)
    elif isinstance(change, Impedance):
        reason = _wrong_impedance(axis, change)
        joint = replace(joint, impedance=change)
    elif isinstance(change, CurrentLimit):
        reason = _outside(axis, "current limit", change.limit_ma, highest_ma, "mA")
        joint = replace(joint, current_limit_ma=change.limit_ma)
    else:
        fastest = robot_file.max_velocity_deg_s
        reason = _outside(axis, "velocity limit", change.limit_deg_s, fastest, "deg/s")
        joint = replace(joint, max_velocity_deg_s=change.limit_deg_s)
    return reason or _change(axis, joint)


def _outside(axis: Axis, what: str, value: float, highest: float, unit: str) -> str:
    if 0 < value <= highest:
        return ""
    return f"{axis.name}: {what} {value:g} {unit} is not above 0 and at most {highest:g}"


def _wrong_impedance(axis: Axis, impedance: Impedance) -> str:
    if not axis.can_be_compliant:
        return f"{axis.name} cannot be compliant"
    for what, value in (
        ("stiffness", impedance.stiffness_nm_deg),
        ("damping", impedance.damping_nms_deg),
    ):
        if not 0.0 <= value < math.inf:
            return f"{axis.name}: {what} {value} is negative or not finite"
    return ""


def _wrong_gains(axis: Axis, pid: Gains, known: Gains) -> str:
    """Why gains are not taken: a sign against the robot file's drives the joint away."""
    for gain in ("kp", "ki", "kd"):
        if getattr(pid, gain) * known.kp < 0:
            return (
                f"{axis.name}: {gain} {getattr(pid, gain)} has the opposite sign of the robot "
                f"file's kp {known.kp}: positive feedback"
            )
    if not 0 <= pid.shift <= MAX_SHIFT:
        return f"{axis.name}: shift {pid.shift} is not within 0 and {MAX_SHIFT}"
    for limit in ("output_limit", "integral_limit"):
        if not 0 <= getattr(pid, limit) <= axis.full_pwm:
            return f"{axis.name}: {limit} {getattr(pid, limit)} is not within 0 and {axis.full_pwm}"
    return ""


def _settings(axis: Axis) -> list[Setting]:
    """Everything that can be tuned, as the axis's joint now has it."""
    settings = [*position_settings(axis), *torque_settings(axis)]
    if axis.can_be_compliant:
        settings.append(impedance_setting(axis))
    return [*settings, current_limit_setting(axis), velocity_limit_setting(axis)]


def _apply(axis: Axis, joint: Joint) -> list[Setting]:
    """Make `joint` the axis's; the settings that differ from before."""
    before = _settings(axis)
    axis.joint = joint
    axis.units.limit_velocity(joint.max_velocity_deg_s)
    return [setting for setting in _settings(axis) if setting not in before]


def _change(axis: Axis, joint: Joint) -> Sequence | str:
    """Write what differs, unless no frame can carry it."""
    old = axis.joint
    changed = _apply(axis, joint)
    try:
        for row, values in changed:
            row.request(axis.address, axis.number, *values)
    except WireError as error:
        _apply(axis, old)
        return f"{axis.name}: {error}"
    return _write(axis, changed, old)


def _write(axis: Axis, changed: Values[Setting], old: Joint) -> Sequence:
    for row, values in changed:
        axis.command(row, *values)
    yield from sent(axis.line, axis.address)
    reason = yield from verify(axis, changed)
    if reason:
        for row, values in _apply(axis, old):
            axis.command(row, *values)
        reason = f"{reason}; the old settings are written again"
    axis.on_limits()
    return reason
