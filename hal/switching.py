"""Control and interaction modes: ask the board, wait until it confirms, say why it does not."""

from hal.axis import Axis
from hal.boards.status import fault_cause
from hal.tasks import Sequence
from hal.wire import motor
from hal.wire.modes import ControlMode, InteractionMode
from hal.wire.motor_periodic import AxisFault

CONFIRM_NS = 200_000_000
POLL_NS = 50_000_000  # STATUS comes by itself within 5 ms; ask when it was lost

MODES = {
    "idle": ControlMode.IDLE,
    "position": ControlMode.POSITION,
    "direct": ControlMode.DIRECT,
    "velocity": ControlMode.VELOCITY,
    "torque": ControlMode.TORQUE,
}
INTERACTIONS = {"stiff": InteractionMode.STIFF, "compliant": InteractionMode.COMPLIANT}


def switch_mode(axis: Axis, mode: ControlMode) -> Sequence:
    """Bring one axis into a control mode."""
    if axis.mode == mode:
        axis.wanted_mode = mode
        return ""
    if mode != ControlMode.IDLE and axis.mode == ControlMode.HW_FAULT:
        return f"{axis.name} is in hardware fault ({fault_cause(axis)}): request mode idle first"
    axis.switching = True
    axis.wanted_mode = mode
    try:
        axis.switch(motor.SET_CONTROL_MODE, _command_code(mode))
        reason = yield from _confirmed(axis, mode)
    finally:
        axis.switching = False
    return reason


def _command_code(mode: ControlMode) -> int:
    """Force idle is idle that also leaves a hardware fault."""
    return ControlMode.FORCE_IDLE if mode == ControlMode.IDLE else mode


def _confirmed(axis: Axis, mode: ControlMode) -> Sequence:
    line = axis.line
    deadline_ns = line.now_ns + CONFIRM_NS
    poll_ns = line.now_ns + POLL_NS
    while line.now_ns < deadline_ns:
        yield
        if axis.mode == mode and not (axis.is_powered and is_stopped(axis)):
            return ""
        if axis.mode == ControlMode.HW_FAULT and mode != ControlMode.IDLE:
            return f"{axis.name} went into hardware fault: {_refusal(axis)}"
        if line.now_ns >= poll_ns:
            poll_ns += POLL_NS
            axis.command(motor.GET_CONTROL_MODE)
    return f"{axis.name} did not enter {mode.name.lower()} mode: {_refusal(axis)}"


def is_stopped(axis: Axis) -> bool:
    """Whether the emergency button is pressed.

    The board then enters the mode asked for, and is idle again one millisecond later.
    """
    return bool(axis.fault_bits & AxisFault.EXTERNAL)


def _refusal(axis: Axis) -> str:
    """Why a board does not enter a mode (can-protocol 10.2), most certain first."""
    if axis.address in axis.line.muted:
        return "its board is silent"
    if is_stopped(axis):
        return "emergency button pressed"
    if axis.fault_bits:
        return fault_cause(axis)
    if not axis.is_calibrated:
        return "not calibrated"
    return "no answer, or settings missing on the board (position gains, protocol handshake)"


def switch_interaction(axis: Axis, interaction: InteractionMode) -> Sequence:
    """Make one axis stiff or compliant; its mode stays, its reference becomes where it is."""
    if axis.interaction == interaction:
        return ""
    line = axis.line
    axis.switching = True
    try:
        axis.switch(motor.SET_INTERACTION_MODE, interaction)
        deadline_ns = line.now_ns + CONFIRM_NS
        poll_ns = line.now_ns + POLL_NS
        while axis.interaction != interaction:
            yield
            if line.now_ns >= deadline_ns:
                return f"{axis.name} did not become {interaction.name.lower()}: {_refusal(axis)}"
            if line.now_ns >= poll_ns:
                poll_ns += POLL_NS
                axis.command(motor.GET_INTERACTION_MODE)
    finally:
        axis.switching = False
    return ""
