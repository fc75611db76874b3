"""Polled motor commands that do more than store a value (can-protocol 2.2), by code."""

from firmware_sim.boards.axis_state import (
    COMPLIANT,
    DIRECT,
    OPENLOOP,
    WITH_MOVES,
    WITH_VELOCITY,
    Axis,
)
from firmware_sim.boards.calibration import ENCODER_TICKS, calibrate
from firmware_sim.boards.enabling import set_mode
from firmware_sim.boards.law import saturate_i16, saturate_i32
from firmware_sim.boards.node import BUILD, LABEL_PIECES, PROTOCOL
from firmware_sim.boards.settings import Handler, Values
from hal.wire import motor
from hal.wire.modes import reported_mode

_WITH_TRAJECTORY = WITH_MOVES | WITH_VELOCITY
_MAX_VELOCITY_SHIFT = 16
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
    axis.set_compliant(values[0] == COMPLIANT)


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


def _get_openloop(axis: Axis, _values: Values) -> Values:
    return (axis.openloop_pwm,)


def _stop_trajectory(axis: Axis, _values: Values) -> None:
    if axis.mode in _WITH_TRAJECTORY:
        axis.reference.hold(axis.position)


def _set_impedance(axis: Axis, values: Values) -> None:
    axis.impedance.stiffness, axis.impedance.damping = values


def _get_impedance(axis: Axis, _values: Values) -> Values:
    impedance = axis.impedance
    return impedance.stiffness, impedance.damping, impedance.offset


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


def _set_encoder_offset(axis: Axis, values: Values) -> None:
    if not 0 <= values[0] < ENCODER_TICKS:
        _drop(axis, "value")
        return
    axis.encoder_offset = values[0]
    axis.rebase()


def _preset_encoder(axis: Axis, values: Values) -> None:
    if not axis.hardware.presets_encoder:
        _drop(axis, "unknown")
        return
    preset = max(-_MAX_PRESET_TICKS, min(_MAX_PRESET_TICKS, values[0]))
    axis.encoder_offset = axis.port.raw_encoder - preset
    axis.rebase()


def _set_torque_source(axis: Axis, values: Values) -> None:
    source, channel = values
    axis.set_torque_source((source, channel) if channel < 6 else None)


def _set_debug(axis: Axis, values: Values) -> None:
    axis.debug[values[0]] = values[1]


def _get_debug(axis: Axis, values: Values) -> Values:
    return (axis.debug.get(values[0], 0),)


def _set_label(axis: Axis, values: Values) -> None:
    index, *characters = values
    if index < LABEL_PIECES:
        axis.node.label[4 * index : 4 * index + 4] = bytes(characters)


def _get_mode(axis: Axis, _values: Values) -> Values:
    return (int(reported_mode(axis.mode)),)


def _get_interaction(axis: Axis, _values: Values) -> Values:
    return (int(axis.compliant),)


def _get_calibration(axis: Axis, _values: Values) -> Values:
    return int(axis.calibrated), axis.mode, int(axis.compliant)


def _motion_done(axis: Axis, _values: Values) -> Values:
    ended = axis.mode in _WITH_TRAJECTORY and not axis.reference.active
    return (int(ended or axis.mode == DIRECT),)


def _get_encoder(axis: Axis, _values: Values) -> Values:
    return saturate_i32(axis.position), axis.speed()


def _get_speed(axis: Axis, _values: Values) -> Values:
    return (axis.speed(),)


def _get_reference(axis: Axis, _values: Values) -> Values:
    return (saturate_i32(axis.reference.ticks),)


def _get_velocity_reference(axis: Axis, _values: Values) -> Values:
    return (axis.reference.velocity_target,)


def _get_error(axis: Axis, _values: Values) -> Values:
    return (axis.position_pid.error if axis.enabled else 0,)


def _get_output(axis: Axis, _values: Values) -> Values:
    return (saturate_i16(axis.pwm),)


def _get_error_status(_axis: Axis, _values: Values) -> Values:
    return 0, 0


def _get_encoder_offset(axis: Axis, _values: Values) -> Values:
    return (saturate_i32(axis.encoder_offset),)


def _get_address(axis: Axis, _values: Values) -> Values:
    return (axis.pair.address,)


def _handshake(axis: Axis, values: Values) -> Values:
    major, minor = values
    accepted = PROTOCOL[0] == major and PROTOCOL[1] >= minor
    axis.node.accepted = accepted
    hardware = axis.hardware
    return hardware.board_type, *axis.node.version, BUILD, *PROTOCOL, int(accepted)


HANDLERS: dict[int, Handler] = {
    command.code: handler
    for command, handler in (
        (motor.NO_MESSAGE, _ignore),
        (motor.TOGGLE_VERBOSE, _ignore),
        (motor.CALIBRATE_ENCODER, _calibrate),
        (motor.GET_CONTROL_MODE, _get_mode),
        (motor.MOTION_DONE, _motion_done),
        (motor.SET_CONTROL_MODE, _set_control_mode),
        (motor.WRITE_FLASH_MEM, _ignore),
        (motor.READ_FLASH_MEM, _ignore),
        (motor.SET_ADDITIONAL_INFO, _set_label),
        (motor.SET_SPEED_ESTIM_SHIFT, _set_speed_shift),
        (motor.SET_MAX_MOTOR_POS, _ignore),
        (motor.SET_MIN_MOTOR_POS, _ignore),
        (motor.SET_DEBUG_PARAM, _set_debug),
        (motor.GET_DEBUG_PARAM, _get_debug),
        (motor.GET_ENCODER_POSITION, _get_encoder),
        (motor.SET_DESIRED_POSITION, _ignore),
        (motor.GET_DESIRED_POSITION, _get_reference),
        (motor.POSITION_MOVE, _position_move),
        (motor.VELOCITY_MOVE, _velocity_move),
        (motor.SET_ENCODER_POSITION, _preset_encoder),
        (motor.STOP_TRAJECTORY, _stop_trajectory),
        (motor.SET_BOARD_ID, _ignore),
        (motor.GET_BOARD_ID, _get_address),
        (motor.SET_TORQUE_SOURCE, _set_torque_source),
        (motor.GET_PID_ERROR, _get_error),
        (motor.GET_CALIBRATION_STATUS, _get_calibration),
        (motor.GET_POSITION_MOVE_REF, _get_reference),
        (motor.GET_VELOCITY_MOVE_REF, _get_velocity_reference),
        (motor.GET_ERROR_STATUS, _get_error_status),
        (motor.GET_ENCODER_VELOCITY, _get_speed),
        (motor.SET_COMMAND_POSITION, _set_command_position),
        (motor.GET_PID_OUTPUT, _get_output),
        (motor.SET_CURRENT_LIMIT, _set_current_limit),
        (motor.SET_BCAST_POLICY, _set_broadcast),
        (motor.SET_VEL_SHIFT, _set_velocity_shift),
        (motor.SET_OFFSET_ABS_ENCODER, _set_encoder_offset),
        (motor.GET_OFFSET_ABS_ENCODER, _get_encoder_offset),
        (motor.SET_VEL_TIMEOUT, _set_velocity_timeout),
        (motor.SET_IMPEDANCE_PARAMS, _set_impedance),
        (motor.GET_IMPEDANCE_PARAMS, _get_impedance),
        (motor.GET_FIRMWARE_VERSION, _handshake),
        (motor.SET_OPTICAL_ENC_RATIO, _ignore),
        (motor.SET_OPENLOOP_PARAMS, _set_openloop),
        (motor.GET_OPENLOOP_PARAMS, _get_openloop),
        (motor.SET_INTERACTION_MODE, _set_interaction_mode),
        (motor.GET_INTERACTION_MODE, _get_interaction),
    )
}
"""Handlers by code. DELIBERATE: SET_BOARD_ID is taken and ignored; an emulated board keeps its address."""
