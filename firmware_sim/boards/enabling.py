"""SET_CONTROL_MODE and the gate in front of the bridge (can-protocol 2.3 and 10.2)."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.modes import HW_FAULT, IDLE, RUNNING
from hal.wire.modes import CALIBRATING, ControlMode

EVERY_GAIN = 0x7F  # kp, kd, ki, kr, ko, ilim, tlim received since boot
_FORCE_IDLE = int(ControlMode.FORCE_IDLE)
_UNKNOWN = int(ControlMode.UNKNOWN_ERROR)


def set_mode(axis: Axis, mode: int) -> None:
    """Do what command 9 asks for, as far as the present mode allows."""
    if axis.mode == HW_FAULT:
        if mode == _FORCE_IDLE:
            axis.idle()
        else:
            axis.node.dropped["mode"] += 1
    elif mode in (IDLE, _FORCE_IDLE):
        if axis.mode != IDLE:
            axis.idle()
    elif axis.mode != IDLE or may_run(axis, calibrated=axis.calibrated):
        axis.enter(_as_entered(mode))


def may_run(axis: Axis, *, calibrated: bool) -> bool:
    """Check what a real board checks before it closes the bridge; else HW_FAULT and a print.

    DELIBERATE: an uncalibrated single axis of a real BLL board faults, prints, and is enabled
    nevertheless; here it is refused, as coupled axes are.
    """
    if not axis.node.accepted:
        reason = "protocol not acknowledged"
    elif axis.pid_flags != EVERY_GAIN:
        reason = f"PIDs not received 0x{axis.pid_flags:02X}"
    elif axis.hardware.needs_calibration and not calibrated:
        reason = "calib failed"
    else:
        return True
    axis.node.printer.say(f"{reason}, axis {axis.index}")
    axis.fault()
    return False


def _as_entered(mode: int) -> int:
    """Mode code that the axis shows; a code of the board's own states has no law from outside."""
    if mode not in RUNNING and (mode in CALIBRATING or mode == HW_FAULT):
        return _UNKNOWN
    return mode
