"""Calibration of the encoders by the boards (can-protocol 10.5), in groups, with reduced PWM."""

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


def calibrate(axes: Values[Axis]) -> Sequence:
    """All axes, group by group; a group that fails ends it, its failed axes switched off."""
    ordered = sorted(axes, key=_order)
    for _, group in groupby(ordered, key=_order):
        reason = yield from together(_calibrate_axis(axis) for axis in list(group))
        if reason:
            return reason
    return ""


def _order(axis: Axis) -> int:
    return axis.joint.calibration.order


def _calibrate_axis(axis: Axis) -> Sequence:
    calibration = axis.joint.calibration
    if axis.mode == ControlMode.HW_FAULT:
        reason = yield from switch_mode(axis, ControlMode.IDLE)
        if reason:
            return reason
    axis.set_moving(True)
    axis.switching = True
    try:
        axis.wanted_mode = ControlMode.POSITION
        axis.set_calibrated(False)
        axis.command(motor.SET_PWM_LIMIT, min(calibration.startup_pwm, axis.joint.pwm_limit))
        # Without power a joint may still fall: caught in motion, it would overshoot its limit.
        yield from settled(axis)
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
        axis.switching = False
        axis.set_moving(False)
        axis.command(motor.SET_PWM_LIMIT, axis.joint.pwm_limit)
    if not reason:
        reason = yield from switch_mode(axis, ControlMode.POSITION)
    if not reason:
        reason = yield from switch_interaction(axis, InteractionMode.STIFF)
    if reason:
        axis.set_calibrated(False)
        yield from idle([axis])
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
        if axis.address in line.muted:
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
