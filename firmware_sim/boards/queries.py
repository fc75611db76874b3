"""Polled motor commands that answer (can-protocol 2.2), by code."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.law import saturate_i16, saturate_i32
from firmware_sim.boards.modes import DIRECT, WITH_MOVES, WITH_VELOCITY
from firmware_sim.boards.node import BUILD, PROTOCOL
from firmware_sim.boards.settings import Handler, Values
from firmware_sim.boards.unit import MICRO_SACCADE
from hal.wire import motor
from hal.wire.modes import reported_mode

_WITH_TRAJECTORY = WITH_MOVES | WITH_VELOCITY


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


def _get_openloop(axis: Axis, _values: Values) -> Values:
    return (axis.openloop_pwm,)


def _get_impedance(axis: Axis, _values: Values) -> Values:
    impedance = axis.impedance
    return impedance.stiffness, impedance.damping, impedance.offset


def _get_debug(axis: Axis, values: Values) -> Values:
    index = values[0]
    unit = axis.node.unit
    if index == MICRO_SACCADE:
        return (unit.micro_saccade[0],)
    return (unit.decoupling.get(index, axis.debug.get(index, 0)),)


HANDLERS: dict[int, Handler] = {
    command.code: handler
    for command, handler in (
        (motor.GET_CONTROL_MODE, _get_mode),
        (motor.MOTION_DONE, _motion_done),
        (motor.GET_DEBUG_PARAM, _get_debug),
        (motor.GET_ENCODER_POSITION, _get_encoder),
        (motor.GET_DESIRED_POSITION, _get_reference),
        (motor.GET_BOARD_ID, _get_address),
        (motor.GET_PID_ERROR, _get_error),
        (motor.GET_CALIBRATION_STATUS, _get_calibration),
        (motor.GET_POSITION_MOVE_REF, _get_reference),
        (motor.GET_VELOCITY_MOVE_REF, _get_velocity_reference),
        (motor.GET_ERROR_STATUS, _get_error_status),
        (motor.GET_ENCODER_VELOCITY, _get_speed),
        (motor.GET_PID_OUTPUT, _get_output),
        (motor.GET_OFFSET_ABS_ENCODER, _get_encoder_offset),
        (motor.GET_IMPEDANCE_PARAMS, _get_impedance),
        (motor.GET_FIRMWARE_VERSION, _handshake),
        (motor.GET_OPENLOOP_PARAMS, _get_openloop),
        (motor.GET_INTERACTION_MODE, _get_interaction),
    )
}
"""Handlers by code."""
