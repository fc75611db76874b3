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
    elif axis.mode == IDLE:
        enable_together(axis, _as_entered(mode))
    else:
        axis.enter(_as_entered(mode))


def enable_together(axis: Axis, mode: int) -> bool:
    """Bridge on, of the axes coupled to it too; False when one of them may not run.

    A coupled axis that is in fault keeps the other from running: the sheet says that they run
    together and that nothing but force idle leads out of a fault.
    """
    if any(peer.mode == HW_FAULT for peer in axis.peers):
        axis.node.dropped["mode"] += 1
        return False
    idle = [peer for peer in axis.peers if peer.mode == IDLE]
    if not all(may_run(one) for one in (axis, *idle)):
        return False
    for one in (axis, *idle):
        one.enter(mode)
    return True


def may_run(axis: Axis) -> bool:
    """Check what a real board checks before it closes the bridge; else HW_FAULT and a print.

    A single uncalibrated BLL axis of a faithful board prints and runs nevertheless: the real one
    faults and is enabled in the same cycle.
    """
    unit = axis.node.unit
    if not axis.node.accepted:
        reason = "protocol not acknowledged"
    elif axis.pid_flags != EVERY_GAIN:
        reason = f"PIDs not received 0x{axis.pid_flags:02X}"
    elif axis.hardware.needs_calibration and not axis.calibrated:
        reason = "calib failed"
        if unit.firmware.faithful and not axis.peers:
            axis.node.printer.say(f"{reason}, axis {axis.index}")
            return True
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
