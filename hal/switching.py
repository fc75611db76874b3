"""Control and interaction modes: ask the board, wait until it confirms, say why it does not."""

from collections.abc import Generator

from hal.axis import Axis
from hal.boards.status import fault_cause
from hal.tasks import Sequence
from hal.wire import motor
from hal.wire.modes import ControlMode, InteractionMode
from hal.wire.motor_periodic import AxisFault

CONFIRM_NS = 200_000_000
NOTHING_SAID = "no answer, or settings missing on the board (position gains, protocol handshake)"
PRINTS_NS = 20_000_000
POLL_NS = 50_000_000  # STATUS comes by itself within 5 ms; ask when it was lost

MODES = {
    "idle": ControlMode.IDLE,
    "position": ControlMode.POSITION,
    "direct": ControlMode.DIRECT,
    "velocity": ControlMode.VELOCITY,
    "torque": ControlMode.TORQUE,
    "pwm": ControlMode.OPENLOOP,
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
    for partner in axis.partners:  # the firmware takes it along
        partner.wanted_mode = mode
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
    began_ns = line.now_ns
    deadline_ns = began_ns + CONFIRM_NS
    poll_ns = began_ns + POLL_NS
    while line.now_ns < deadline_ns:
        yield
        if axis.mode == mode and not (axis.is_powered and is_stopped(axis)):
            return ""
        if axis.mode == ControlMode.HW_FAULT and mode != ControlMode.IDLE:
            yield from _listened(axis)
            return f"{axis.name} went into hardware fault: {_refusal(axis, began_ns)}"
        if line.now_ns >= poll_ns:
            poll_ns += POLL_NS
            axis.command(motor.GET_CONTROL_MODE)
    return f"{axis.name} did not enter {_name(mode)} mode: {_refusal(axis, began_ns)}"


def _listened(axis: Axis) -> Generator[None, None, None]:
    """What the board prints about a fault may arrive just behind it."""
    end_ns = axis.line.now_ns + PRINTS_NS
    while axis.line.now_ns < end_ns:
        yield


def _name(mode: ControlMode) -> str:
    return next((name for name, code in MODES.items() if code == mode), mode.name.lower())


def is_stopped(axis: Axis) -> bool:
    """Whether the emergency button is pressed.

    The board then enters the mode asked for, and is idle again one millisecond later.
    """
    return bool(axis.fault_bits & AxisFault.EXTERNAL)


def _refusal(axis: Axis, since_ns: int) -> str:
    """Why a board does not enter a mode (can-protocol 10.2), most certain first."""
    cause = _cause(axis)
    if not axis.said or axis.said_ns < since_ns:
        return cause or NOTHING_SAID
    return f'{cause}{"; " if cause else ""}its board says "{axis.said}"'


def _cause(axis: Axis) -> str:
    """What the host knows by itself, empty when it knows nothing."""
    if not axis.is_available:
        return "its board is silent"
    if axis.line.is_off:
        return f"bus {axis.line.number} is off"
    if is_stopped(axis):
        return "emergency button pressed"
    if axis.fault_bits:
        return fault_cause(axis)
    if not axis.is_calibrated:
        return "not calibrated"
    for partner in axis.partners:
        if partner.mode == ControlMode.HW_FAULT:
            return f"its coupled partner {partner.name} is in hardware fault"
        if not partner.is_calibrated:
            return f"its coupled partner {partner.name} is not calibrated"
    causes = [suspect(axis.line.now_ns) for suspect in axis.suspects]
    return "; ".join(cause for cause in causes if cause)


def switch_interaction(axis: Axis, interaction: InteractionMode) -> Sequence:
    """Make one axis stiff or compliant; its mode stays, its reference becomes where it is."""
    if axis.interaction == interaction:
        return ""
    line = axis.line
    axis.switching = True
    try:
        axis.switch(motor.SET_INTERACTION_MODE, interaction)
        began_ns = line.now_ns
        deadline_ns = began_ns + CONFIRM_NS
        poll_ns = began_ns + POLL_NS
        while axis.interaction != interaction:
            yield
            if line.now_ns >= deadline_ns:
                reason = _refusal(axis, began_ns)
                return f"{axis.name} did not become {interaction.name.lower()}: {reason}"
            if line.now_ns >= poll_ns:
                poll_ns += POLL_NS
                axis.command(motor.GET_INTERACTION_MODE)
    finally:
        axis.switching = False
    return ""
