"""Movements that the boards make by themselves: a minimum-jerk move, and bringing a limb down."""

import math
from collections.abc import Sequence as Values

from hal.axis import Axis
from hal.switching import switch_interaction, switch_mode
from hal.tasks import Sequence, together
from hal.units import PEAK_OVER_MEAN, move_duration_ns, move_speed_counts
from hal.wire import motor
from hal.wire.modes import ControlMode, InteractionMode

STILL_NS = 100_000_000
STILL_TICKS = 1
SETTLE_NS = 2_000_000_000
STIFF_ERROR_RAD = 0.035  # 2 deg: a move that ends farther off has been stopped by something
NEAR_RAD = STIFF_ERROR_RAD / 2.0  # an axis that stands farther off may still be on its way
COMPLIANT_ERROR_RAD = 0.09  # 5 deg: a spring sags

STOP_NS = 3_000_000_000
IDLE_RESERVE_NS = 400_000_000  # of STOP_NS, for switching off and for an axis that answers late


def move_duration_s(axes: Values[Axis], q_rad: Values[float], duration_s: float) -> float:
    """Duration of a move of several axes: as asked, longer where an axis would be too fast."""
    longest_s = duration_s
    for axis, target_rad in zip(axes, q_rad, strict=True):
        units = axis.units
        distance_rad = abs(units.limited_ticks(target_rad) - axis.ticks) * abs(units.rad_per_tick)
        longest_s = max(longest_s, distance_rad * PEAK_OVER_MEAN / units.max_velocity_rad_s)
    return longest_s


def move(axes: Values[Axis], q_rad: Values[float], duration_s: float) -> Sequence:
    """Move axes together; ends when all have settled."""
    reason = yield from together(switch_mode(axis, ControlMode.POSITION) for axis in axes)
    if reason:
        return reason
    together_s = move_duration_s(axes, q_rad, duration_s)
    reason = yield from together(
        _move_axis(axis, axis.units.limited_ticks(target_rad), together_s)
        for axis, target_rad in zip(axes, q_rad, strict=True)
    )
    return reason


def _move_axis(axis: Axis, target_ticks: int, duration_s: float) -> Sequence:
    axis.set_moving(True)
    try:
        delta = target_ticks - axis.ticks
        speed = min(move_speed_counts(delta, duration_s), axis.units.max_move_speed_counts)
        axis.command(motor.POSITION_MOVE, target_ticks, speed)
        end_ns = axis.line.now_ns + move_duration_ns(delta, speed)
        while axis.line.now_ns < end_ns:
            yield
            if axis.mode != ControlMode.POSITION:
                cause = f": {axis.fault_text}" if axis.fault_text else ""
                return f"{axis.name} left position mode during the move{cause}"
        near_rad = COMPLIANT_ERROR_RAD if axis.is_compliant else NEAR_RAD
        yield from settled(axis, target_ticks, near_rad * abs(axis.units.ticks_per_rad))
        error_rad = abs(target_ticks - axis.ticks) * abs(axis.units.rad_per_tick)
        if error_rad > (COMPLIANT_ERROR_RAD if axis.is_compliant else STIFF_ERROR_RAD):
            return f"{axis.name} stopped {error_rad:.3f} rad short of its target"
    finally:
        axis.set_moving(False)
    return ""


def settled(axis: Axis, target_ticks: int = 0, near_ticks: float = math.inf) -> Sequence:
    """Wait until an axis stands still near a target, 2 s at most; the caller looks where it is."""
    line = axis.line
    deadline_ns = line.now_ns + SETTLE_NS
    ticks, since_ns = axis.ticks, line.now_ns
    while line.now_ns < deadline_ns and line.now_ns - since_ns < STILL_NS:
        yield
        # Far off it sticks, and goes on when the board's integral has grown.
        is_far = abs(axis.ticks - target_ticks) > near_ticks
        if is_far or abs(axis.ticks - ticks) > STILL_TICKS:
            ticks, since_ns = axis.ticks, line.now_ns
    return ""


def stop(axes: Values[Axis], q_rad: Values[float], limit_ns: int = STOP_NS) -> Sequence:
    """Stiff, position mode, move to `q_rad` (empty = stay), idle: in time whatever boards do."""
    if not axes:
        return ""
    deadline_ns = axes[0].line.now_ns + limit_ns - IDLE_RESERVE_NS
    bringing_down = _bring_down(axes, q_rad)
    reason = ""
    while axes[0].line.now_ns < deadline_ns:
        try:
            next(bringing_down)
        except StopIteration as stopped:
            reason = stopped.value
            break
        yield
    else:
        reason = "the limb was still moving when its time was up"
    bringing_down.close()
    idle_reason = yield from idle(axes)
    return "; ".join(text for text in (reason, idle_reason) if text)


def _bring_down(axes: Values[Axis], q_rad: Values[float]) -> Sequence:
    """Every axis for itself, so that one that fails keeps no other from its place."""
    running = [i for i, axis in enumerate(axes) if axis.is_powered and axis.is_calibrated]
    moved = [axes[i] for i in running]
    targets_rad = [q_rad[i] for i in running] if q_rad else []
    duration_s = move_duration_s(moved, targets_rad, 0.0) if q_rad else 0.0
    reason = yield from together(
        [
            _bring_down_axis(axis, targets_rad[i] if q_rad else None, duration_s)
            for i, axis in enumerate(moved)
        ]
    )
    return reason


def _bring_down_axis(axis: Axis, target_rad: float | None, duration_s: float) -> Sequence:
    reason = yield from switch_interaction(axis, InteractionMode.STIFF)
    if not reason:
        reason = yield from switch_mode(axis, ControlMode.POSITION)
    if not reason and target_rad is not None:
        reason = yield from _move_axis(axis, axis.units.limited_ticks(target_rad), duration_s)
    return reason


def idle(axes: Values[Axis]) -> Sequence:
    """Bridges off, also out of a hardware fault."""
    reason = yield from together(switch_mode(axis, ControlMode.IDLE) for axis in axes)
    return reason
