"""Polled motor commands that do more than store a value (can-protocol 2.2), by code."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.calibration import ENCODER_TICKS, calibrate
from firmware_sim.boards.enabling import set_mode
from firmware_sim.boards.modes import COMPLIANT, DIRECT, OPENLOOP, STIFF, WITH_MOVES, WITH_VELOCITY
from firmware_sim.boards.settings import Handler, Values
from hal.wire import motor

_WITH_TRAJECTORY = WITH_MOVES | WITH_VELOCITY
_MAX_VELOCITY_SHIFT = 16
_ADDRESSES = range(1, 15)
_DAMPING = 7  # debug parameter
_MAX_PRESET_TICKS = 0x3FFF_FFFF  # leaves room to count in 32 bits


def _drop(axis: Axis, cause: str) -> None:
    axis.node.dropped[cause] += 1


def _ignore(_axis: Axis, _values: Values) -> None:
    """Accepted by the boards; nothing that an emulated board shows depends on it."""


def _calibrate(axis: Axis, values: Values) -> None:
    kind, p1, p2, p3 = values
    calibrate(axis, kind, p1, p2, p3)


def _set_control_mode(axis: Axis, values: Values) -> None:
    set_mode(axis, values[0])


def _set_interaction_mode(axis: Axis, values: Values) -> None:
    if values[0] in (STIFF, COMPLIANT):
        axis.set_compliant(values[0] == COMPLIANT)
    else:
        _drop(axis, "value")


def _position_move(axis: Axis, values: Values) -> None:
    if axis.mode not in WITH_MOVES:
        _drop(axis, "mode")
        return
    axis.reference.start_move(*values)


def _velocity_move(axis: Axis, values: Values) -> None:
    if axis.mode not in WITH_VELOCITY:
        _drop(axis, "mode")
        return
    axis.velocity_setting, axis.acceleration_setting = values
    axis.reference.start_velocity(*values)


def _set_command_position(axis: Axis, values: Values) -> None:
    if axis.mode != DIRECT:
        _drop(axis, "mode")
        return
    axis.reference.set_direct(values[0])


def _set_openloop(axis: Axis, values: Values) -> None:
    if axis.mode != OPENLOOP:
        _drop(axis, "mode")
        return
    axis.openloop_pwm = values[0]


def _stop_trajectory(axis: Axis, _values: Values) -> None:
    if axis.mode in _WITH_TRAJECTORY:
        axis.reference.hold(axis.position)


def _set_impedance(axis: Axis, values: Values) -> None:
    axis.impedance.stiffness, axis.impedance.damping = values


def _set_current_limit(axis: Axis, values: Values) -> None:
    most_ma = axis.hardware.max_current_limit_ma
    if 0 < values[0] <= most_ma:
        axis.current_limit_ma = values[0]
        return
    _drop(axis, "value")
    axis.node.printer.say(f"current limit refused, axis {axis.index}")


def _set_broadcast(axis: Axis, values: Values) -> None:
    axis.pair.mask = values[0]


def _set_velocity_shift(axis: Axis, values: Values) -> None:
    if 0 <= values[0] <= _MAX_VELOCITY_SHIFT:
        axis.reference.set_velocity_shift(values[0])
    else:
        _drop(axis, "value")


def _set_velocity_timeout(axis: Axis, values: Values) -> None:
    axis.reference.velocity_timeout_ms = values[0]


def _set_speed_shift(axis: Axis, values: Values) -> None:
    axis.speed_shift = values[0]
    unit = axis.node.unit
    unit.rotor_shifts[axis.number] = values[2]


def _set_encoder_offset(axis: Axis, values: Values) -> None:
    if not 0 <= values[0] < ENCODER_TICKS:
        _drop(axis, "value")
        return
    axis.encoder_offset = values[0]
    axis.rebase()


def _preset_encoder(axis: Axis, values: Values) -> None:
    preset = max(-_MAX_PRESET_TICKS, min(_MAX_PRESET_TICKS, values[0]))
    axis.encoder_offset = axis.port.raw_encoder - preset
    axis.rebase()


def _set_torque_source(axis: Axis, values: Values) -> None:
    source, channel = values
    axis.set_torque_source((source, channel) if channel < 6 else None)


def _set_debug(axis: Axis, values: Values) -> None:
    index, value = values
    if index == _DAMPING:
        # DELIBERATE: the sheet calls this more damping in torque mode and gives no formula; here it
        # multiplies the speed estimate and is shifted as the torque loop is.
        axis.extra_damping = value
    if not axis.node.unit.set_decoupling(index, value):
        axis.debug[index] = value


def _set_motor_low(axis: Axis, values: Values) -> None:
    tendon = axis.node.unit.tendon(axis)
    if tendon is None:
        _drop(axis, "unknown")
    else:
        tendon.set_low(values[0])


def _set_motor_high(axis: Axis, values: Values) -> None:
    tendon = axis.node.unit.tendon(axis)
    if tendon is None:
        _drop(axis, "unknown")
    else:
        tendon.set_high(values[0])


def _set_board_id(axis: Axis, values: Values) -> None:
    """A refused address is not taken; the flash is written and CAN starts afresh all the same."""
    unit = axis.node.unit
    if values[0] in _ADDRESSES:
        unit.move_to(values[0])
    else:
        _drop(axis, "value")
        unit.move_to(axis.node.address)
    unit.flash_writes += 1


def _write_flash(axis: Axis, _values: Values) -> None:
    axis.node.unit.flash_writes += 1


def _set_label(axis: Axis, values: Values) -> None:
    index, *characters = values
    axis.node.set_label_piece(index, characters)


HANDLERS: dict[int, Handler] = {
    command.code: handler
    for command, handler in (
        (motor.NO_MESSAGE, _ignore),
        (motor.TOGGLE_VERBOSE, _ignore),
        (motor.CALIBRATE_ENCODER, _calibrate),
        (motor.SET_CONTROL_MODE, _set_control_mode),
        (motor.WRITE_FLASH_MEM, _write_flash),
        (motor.READ_FLASH_MEM, _ignore),
        (motor.SET_ADDITIONAL_INFO, _set_label),
        (motor.SET_SPEED_ESTIM_SHIFT, _set_speed_shift),
        (motor.SET_MAX_MOTOR_POS, _set_motor_high),
        (motor.SET_MIN_MOTOR_POS, _set_motor_low),
        (motor.SET_DEBUG_PARAM, _set_debug),
        (motor.SET_DESIRED_POSITION, _ignore),
        (motor.POSITION_MOVE, _position_move),
        (motor.VELOCITY_MOVE, _velocity_move),
        (motor.SET_ENCODER_POSITION, _preset_encoder),
        (motor.STOP_TRAJECTORY, _stop_trajectory),
        (motor.SET_BOARD_ID, _set_board_id),
        (motor.SET_TORQUE_SOURCE, _set_torque_source),
        (motor.SET_COMMAND_POSITION, _set_command_position),
        (motor.SET_CURRENT_LIMIT, _set_current_limit),
        (motor.SET_BCAST_POLICY, _set_broadcast),
        (motor.SET_VEL_SHIFT, _set_velocity_shift),
        (motor.SET_OFFSET_ABS_ENCODER, _set_encoder_offset),
        (motor.SET_VEL_TIMEOUT, _set_velocity_timeout),
        (motor.SET_IMPEDANCE_PARAMS, _set_impedance),
        (motor.SET_OPTICAL_ENC_RATIO, _ignore),
        (motor.SET_OPENLOOP_PARAMS, _set_openloop),
        (motor.SET_INTERACTION_MODE, _set_interaction_mode),
    )
}
"""Handlers by code.

READ_FLASH_MEM finds what is in use already: address and label are written when they change.
"""
