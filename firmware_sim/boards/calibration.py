"""CALIBRATE_ENCODER (can-protocol 10.5): each axis knows the types that its firmware gives it."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.enabling import enable_together, may_run
from firmware_sim.boards.law import clamp, saturate_i16
from firmware_sim.boards.modes import CALIB_HARD_STOP, CALIB_INCREMENTAL, HW_FAULT, IDLE, POSITION
from hal.wire.modes import CalibrationType

ENCODER_TICKS = 4096
HARD_STOP_MIN_MS = 1200
HARD_STOP_SAMPLE_MS = 20


def calibrate(axis: Axis, kind: int, p1: int, p2: int, p3: int) -> None:
    """Begin a calibration; ignored in HW_FAULT, and when the firmware does not have the type."""
    if axis.mode == HW_FAULT or kind not in axis.wiring.calibrations:
        axis.node.dropped["calibration"] += 1
        return
    if kind == CalibrationType.HARD_STOP:
        _begin_hard_stop(axis, (axis,), p1, p2)
    elif kind == CalibrationType.HARD_STOP_DIFFERENTIAL:
        _begin_hard_stop(axis, (axis, *axis.peers), p1, p2)
    elif kind in (CalibrationType.ABSOLUTE_INCREMENTAL, CalibrationType.MAIS):
        _begin_absolute_incremental(axis, p1, p2, p3)
    elif axis.wiring.holds_here:
        _hold_here(axis, kind, p2)
    else:
        _digital_absolute(axis, p1, p2, p3)


def creep_to_hard_stop(axis: Axis) -> int:
    """One millisecond of types 0 and 2: push the reference on until the axis stands; that is 0."""
    axis.creep_ms += 1
    if axis.creep_ms % HARD_STOP_SAMPLE_MS == 0:
        stands = axis.position == axis.creep_position
        axis.creep_position = axis.position
        axis.node.unit.standing.discard(id(axis))
        if stands and axis.creep_ms > HARD_STOP_MIN_MS:
            _end_hard_stop(axis)
            if axis.mode != CALIB_HARD_STOP:
                return 0
    axis.reference.ticks += axis.creep
    error = saturate_i16(axis.reference.ticks - axis.position)
    return clamp(axis.position_pid.step_limited(error), axis.creep_pwm)


def _begin_hard_stop(axis: Axis, creeping: tuple[Axis, ...], pwm: int, creep: int) -> None:
    """Axes that creep, and coupled ones that hold meanwhile, are powered together."""
    peers = axis.peers
    if any(peer.mode == HW_FAULT for peer in peers):
        axis.node.dropped["calibration"] += 1
        return
    for one in creeping:
        one.calibrated = False
    waking = [peer for peer in peers if peer.mode == IDLE]
    if not all(may_run(one) for one in (axis, *waking)):
        return
    for one in waking:
        one.enter(POSITION)
    for one in creeping:
        one.set_compliant(False)
        one.enter(CALIB_HARD_STOP)
        one.clear()
        one.creep_pwm = abs(pwm)
        one.creep = creep or 1
        one.creep_ms = 0
        one.creep_position = one.position
        one.node.unit.standing.discard(id(one))


def _end_hard_stop(axis: Axis) -> None:
    """Joint zero is here. Differential axes end together, or not yet."""
    unit = axis.node.unit
    unit.standing.add(id(axis))
    axes = [axis]
    if CalibrationType.HARD_STOP_DIFFERENTIAL in axis.wiring.calibrations:
        axes += [one for one in axis.peers if one.mode == CALIB_HARD_STOP]
        if any(id(one) not in unit.standing for one in axes):
            return
    unit.set_joint_zero(axes)
    for one in axes:
        one.enter(POSITION)
        one.calibrated = True


def _begin_absolute_incremental(axis: Axis, target: int, speed: int, counts: int) -> None:
    tendon = axis.node.unit.tendon(axis)
    if tendon is None or not _has_speed(axis, speed) or not may_run(axis):
        return
    tendon.begin_calibration(counts)
    axis.calibrated = False
    axis.set_compliant(False)
    axis.enter(CALIB_INCREMENTAL)
    axis.clear()
    axis.reference.start_move(target, speed)


def _hold_here(axis: Axis, kind: int, speed: int) -> None:
    if kind == CalibrationType.DIGITAL_ABSOLUTE and not _has_speed(axis, speed):
        return
    if not may_run(axis):
        return
    _start(axis)
    axis.calibrated = True


def _digital_absolute(axis: Axis, target: int, speed: int, offset: int) -> None:
    if not _has_speed(axis, speed):
        return
    unit = axis.node.unit
    peers = axis.peers
    if 0 <= offset < ENCODER_TICKS:
        axis.encoder_offset = offset
        axis.rebase()
    if not peers:
        if not _may_move(axis):
            return
        _start(axis)
        axis.calibrated = True
        axis.reference.start_move(target, speed)
        return
    axis.calibrated = True
    unit.moves[id(axis)] = (target, speed)
    pair = (axis, *peers)
    if not all(one.calibrated for one in pair):
        return  # powered when both are
    if axis.mode == IDLE and not enable_together(axis, POSITION):
        return
    for one in pair:
        move = unit.moves.pop(id(one), None)
        if move is not None:
            _start(one)
            one.reference.start_move(*move)


def _may_move(axis: Axis) -> bool:
    """A single axis is enabled before it is marked calibrated; a strict board marks it first."""
    if not axis.node.unit.firmware.faithful:
        axis.calibrated = True
    return may_run(axis)


def _has_speed(axis: Axis, speed: int) -> bool:
    if speed > 0:
        return True
    axis.node.printer.say(f"calib failed: speed 0, axis {axis.index}")
    axis.fault()
    return False


def _start(axis: Axis) -> None:
    """Run in POSITION from where the axis is, stiff."""
    axis.set_compliant(False)
    axis.enter(POSITION)
    axis.clear()
