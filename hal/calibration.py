"""Calibration of the encoders by the boards (can-protocol 10.5), in groups, with reduced PWM.

It can be broken off and asked for again: what is calibrated stays so and is only switched on.
"""

from collections.abc import Sequence as Values
from itertools import groupby

from hal.axis import Axis
from hal.motion import idle, settled
from hal.switching import is_stopped, switch_interaction, switch_mode
from hal.tasks import Sequence, together
from hal.wire import motor
from hal.wire.modes import ControlMode, InteractionMode
from hal.wire.numbers import saturate_i16

TIMEOUT_NS = 20_000_000_000
FIRST_LOOK_NS = 20_000_000
POLL_NS = 50_000_000
BUSY = 0xF0  # high nibble of the internal mode while calibrating


def with_partners(axes: Values[Axis]) -> list[Axis]:
    """The axes and those coupled with them: boards power a pair when both are calibrated."""
    chosen = list(axes)
    for axis in axes:
        chosen += [partner for partner in axis.partners if partner not in chosen]
    return chosen


def calibrate(axes: Values[Axis], *, again: bool = False) -> Sequence:
    """All axes, group by group; a group that fails ends it, its failed axes switched off.

    Calibrated axes are left as they are and switched on, unless `again`.
    """
    ordered = sorted(axes, key=_order)
    for _, group in groupby(ordered, key=_order):
        reason = yield from together(
            _switch_on(axis) if axis.is_calibrated and not again else _calibrate_axis(axis)
            for axis in list(group)
        )
        if reason:
            return reason
    return ""


def _order(axis: Axis) -> int:
    return min(one.joint.calibration.order for one in (axis, *axis.partners))


def _calibrate_axis(axis: Axis) -> Sequence:
    axis.calibration_failure = ""
    reason = ""
    if axis.mode == ControlMode.HW_FAULT:
        reason = yield from switch_mode(axis, ControlMode.IDLE)
    if not reason:
        reason = yield from _run(axis)
    if not reason:
        reason = yield from _switch_on(axis)
    if reason:
        axis.set_calibrated(False)
        axis.calibration_failure = reason
        yield from idle([axis])
    return reason


def _switch_on(axis: Axis) -> Sequence:
    """Position mode, stiff; also out of a hardware fault."""
    reason = ""
    if axis.mode == ControlMode.HW_FAULT:
        reason = yield from switch_mode(axis, ControlMode.IDLE)
    if not reason:
        reason = yield from switch_mode(axis, ControlMode.POSITION)
    if not reason:
        reason = yield from switch_interaction(axis, InteractionMode.STIFF)
    return reason


def _run(axis: Axis) -> Sequence:
    """What the board does by itself, with the PWM that the robot file allows for it."""
    calibration = axis.joint.calibration
    axis.set_moving(True)
    axis.switching = True
    try:
        axis.wanted_mode = ControlMode.POSITION
        axis.set_calibrated(False)
        axis.command(motor.SET_PWM_LIMIT, min(calibration.startup_pwm, axis.joint.pwm_limit))
        # Without power a joint may still fall: caught in motion, it would overshoot its limit.
        yield from settled(axis)
        axis.calibrating = True
        axis.command(
            motor.CALIBRATE_ENCODER,
            calibration.type,
            saturate_i16(calibration.p1),
            saturate_i16(calibration.p2),
            saturate_i16(calibration.p3),
        )
        reason = yield from _done(axis)
        yield from settled(axis)
    finally:
        axis.switching = axis.calibrating = False
        axis.set_moving(False)
        axis.command(motor.SET_PWM_LIMIT, axis.joint.pwm_limit)
    return reason


def _done(axis: Axis) -> Sequence:
    """Poll until the board says calibrated and its trajectory has ended."""
    line = axis.line
    deadline_ns = line.now_ns + TIMEOUT_NS
    poll_ns = line.now_ns + FIRST_LOOK_NS
    axis.replies.clear()
    while line.now_ns < deadline_ns:
        yield
        if axis.mode == ControlMode.HW_FAULT:
            return f"{axis.name} failed while calibrating: {axis.fault_text}"
        if not axis.is_available:
            return f"{axis.name}: its board fell silent while calibrating"
        if line.now_ns >= poll_ns:
            if axis.mode == ControlMode.IDLE and is_stopped(axis):
                return f"{axis.name} not calibrated: emergency button pressed"
            if _is_done(axis):
                axis.set_calibrated(True)
                return ""
            poll_ns = line.now_ns + POLL_NS
            axis.replies.clear()
            axis.command(motor.GET_CALIBRATION_STATUS)
            axis.command(motor.MOTION_DONE)
    return f"{axis.name} not calibrated after {TIMEOUT_NS / 1e9:.0f} s"


def _is_done(axis: Axis) -> bool:
    status = axis.replies.get(motor.GET_CALIBRATION_STATUS.code)
    motion = axis.replies.get(motor.MOTION_DONE.code)
    if status is None or motion is None:
        return False
    calibrated, internal_mode, _ = status
    return bool(calibrated) and not internal_mode & BUSY and bool(motion[0])
