"""CALIBRATE_ENCODER: types 3 (digital absolute) and 0 (hard stop) (can-protocol 10.5).

DELIBERATE: coupled axes (waist, wrist) are calibrated, powered and faulted one by one, because
couplings are the identity on these boards; a real board treats such a pair as one.
"""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.enabling import may_run
from firmware_sim.boards.law import clamp, saturate_i16
from firmware_sim.boards.modes import CALIB_HARD_STOP, HW_FAULT, POSITION
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
        _begin_hard_stop(axis, p1, p2)
    else:
        _digital_absolute(axis, p1, p2, p3)


def creep_to_hard_stop(axis: Axis) -> int:
    """One millisecond of type 0: push the reference on until the axis stands; that point is 0."""
    axis.creep_ms += 1
    if axis.creep_ms % HARD_STOP_SAMPLE_MS == 0:
        stands = axis.position == axis.creep_position
        axis.creep_position = axis.position
        if stands and axis.creep_ms > HARD_STOP_MIN_MS:
            axis.encoder_offset += axis.position
            axis.rebase()
            axis.enter(POSITION)
            axis.calibrated = True
            return 0
    axis.reference.ticks += axis.creep
    error = saturate_i16(axis.reference.ticks - axis.position)
    return clamp(axis.position_pid.step_limited(error), axis.creep_pwm)


def _begin_hard_stop(axis: Axis, pwm: int, creep: int) -> None:
    axis.calibrated = False
    if not may_run(axis, calibrated=True):
        return
    axis.set_compliant(False)
    axis.enter(CALIB_HARD_STOP)
    axis.creep_pwm = abs(pwm)
    axis.creep = creep or 1
    axis.creep_ms = 0
    axis.creep_position = axis.position


def _digital_absolute(axis: Axis, target: int, speed: int, offset: int) -> None:
    if speed <= 0:
        axis.node.printer.say(f"calib failed: speed 0, axis {axis.index}")
        axis.fault()
        return
    if not may_run(axis, calibrated=True):
        return
    if 0 <= offset < ENCODER_TICKS and not axis.wiring.holds_here:
        axis.encoder_offset = offset
        axis.rebase()
    axis.set_compliant(False)
    axis.enter(POSITION)
    axis.clear()
    axis.calibrated = True
    if not axis.wiring.holds_here:
        axis.reference.start_move(target, speed)
