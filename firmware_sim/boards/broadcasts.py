"""What a motor board sends by itself, slot by slot (can-protocol 3.2 and 3.3).

DELIBERATE: the emulated drives have no rotor counts of their own, so MOTOR_POSITION and MOTOR_SPEED
carry what the encoders show before any offset. DEBUG carries scratch parameters 0 and 1 of both
axes; the sheet does not say what the boards put there.
"""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.law import divide, saturate_i16, saturate_i32
from firmware_sim.boards.node import Node, Pair
from hal.wire import motor_periodic as wire
from hal.wire.can import Frame
from hal.wire.modes import reported_mode

HEARTBEAT_MS = 5000
_MAX_SHIFT = 31
_POSITION = wire.POSITION.mask_bit
_PID_VAL = wire.PID_VAL.mask_bit
_STATUS = wire.STATUS.mask_bit
_PRINT = wire.PRINT.mask_bit
_CURRENT = wire.CURRENT.mask_bit
_PID_ERROR = wire.PID_ERROR.mask_bit
_VELOCITY = wire.VELOCITY.mask_bit
_DEBUG = wire.DEBUG.mask_bit
_MOTOR_POSITION = wire.MOTOR_POSITION.mask_bit
_MOTOR_SPEED = wire.MOTOR_SPEED.mask_bit
_REST = _CURRENT | _PID_ERROR | _VELOCITY | _DEBUG | _MOTOR_POSITION | _MOTOR_SPEED
_EXTERNAL = int(wire.AxisFault.EXTERNAL)
_ENCODER = int(wire.AxisFault.ENCODER)
_BOARD_BITS_SENT_AT_ONCE = 0x07
_BUS_OFF = int(wire.CanStatus.BUS_OFF)
_RX_ERRORS = int(
    wire.CanStatus.RX_ERROR_PASSIVE | wire.CanStatus.RX_WARNING | wire.CanStatus.RX_OVERRUN
)

USED_SLOTS = 4
POSITION_SLOT, PID_SLOT, STATUS_SLOT, REST_SLOT = range(USED_SLOTS)


def broadcast(
    pair: Pair, axes: tuple[Axis, Axis], slot: int, now_ms: int, sent: list[Frame]
) -> None:
    """Append the frames of one address in one slot."""
    mask = pair.mask
    first, second = axes
    if slot == POSITION_SLOT:
        if mask & _POSITION:
            sent.append(wire.POSITION.frame(pair.address, first.position, second.position))
    elif slot == PID_SLOT:
        if mask & _PID_VAL:
            duties = (first.duty, second.duty) if first.hardware.reports_duty else (0, 0)
            sent.append(wire.PID_VAL.frame(pair.address, first.pwm, second.pwm, *duties))
    elif slot == STATUS_SLOT:
        if mask & _STATUS:
            _status(pair, axes, now_ms, sent)
    elif mask & _REST:
        _rest(pair, axes, sent)


def print_piece(node: Node, mask: int, sent: list[Frame]) -> None:
    """Append the next piece of text, or forget it all when the board's first mask lets none out."""
    if mask & _PRINT:
        sent.append(node.printer.next_frame())
    else:
        node.printer.clear()


def _status(pair: Pair, axes: tuple[Axis, Axis], now_ms: int, sent: list[Frame]) -> None:
    first, second = axes
    heartbeat = now_ms - pair.heartbeat_ms >= HEARTBEAT_MS
    modes = first.mode, second.mode
    if heartbeat or modes != pair.reported_modes or _is_urgent(pair, first, second):
        rx_error = int(heartbeat and pair.can_status & _RX_ERRORS != 0)
        tx_error = int(heartbeat and pair.can_status & ~_RX_ERRORS != 0)
        sent.append(
            wire.STATUS.frame(
                pair.address,
                *(_fault_byte(first), int(reported_mode(first.mode))),
                *(_fault_byte(second), int(reported_mode(second.mode))),
                *(pair.can_status, pair.board_status, tx_error, rx_error),
            )
        )
        pair.reported_modes = modes
        pair.can_status = 0
        pair.board_status = 0
        first.faults_once = second.faults_once = 0
    interactions = first.compliant, second.compliant
    if heartbeat or interactions != pair.reported_interactions:
        sent.append(wire.ADDITIONAL_STATUS.frame(pair.address, *map(int, interactions)))
        pair.reported_interactions = interactions
    if heartbeat:
        pair.heartbeat_ms = now_ms


def _is_urgent(pair: Pair, first: Axis, second: Axis) -> bool:
    """Something of this cycle that is worth a STATUS; for axes 0 and 1 bus-off alone is not."""
    if first.faults_once or second.faults_once:
        return True
    one, other = first.port, second.port
    if one.external_fault or other.external_fault or one.encoder_fault or other.encoder_fault:
        return True
    unheeded = 0 if first.number else _BUS_OFF
    return bool(pair.can_status & ~unheeded or pair.board_status & _BOARD_BITS_SENT_AT_ONCE)


def _fault_byte(axis: Axis) -> int:
    port = axis.port
    bits = axis.faults_once
    if port.external_fault:
        bits |= _EXTERNAL
    if port.encoder_fault:
        bits |= _ENCODER
    return bits


def _rest(pair: Pair, axes: tuple[Axis, Axis], sent: list[Frame]) -> None:
    first, second = axes
    address = pair.address
    if pair.mask & _CURRENT:
        currents = saturate_i16(first.port.current_ma), saturate_i16(second.port.current_ma)
        sent.append(wire.CURRENT.frame(address, *currents))
    if pair.mask & _PID_ERROR:
        sent.append(wire.PID_ERROR.frame(address, *_errors(axes)))
    if pair.mask & _VELOCITY:
        sent.append(wire.VELOCITY.frame(address, first.speed(), second.speed(), 0, 0))
    if pair.mask & _DEBUG:
        words = [axis.debug.get(index, 0) for axis in axes for index in (0, 1)]
        sent.append(wire.DEBUG.frame(address, *words))
    if pair.mask & _MOTOR_POSITION:
        # A bug of the 4DC: at its second address it tells the rotors of the first.
        told = first.node.unit.axes[:2]
        counts = [saturate_i32(axis.port.raw_encoder) for axis in told]
        sent.append(wire.MOTOR_POSITION.frame(address, *counts))
    if pair.mask & _MOTOR_SPEED:
        speeds = [_rotor_speed(axis) for axis in axes]
        sent.append(wire.MOTOR_SPEED.frame(address, *speeds))


def _rotor_speed(axis: Axis) -> int:
    """Counts of a millisecond, in the scale of the joint's speed, over one round of slots."""
    unit = axis.node.unit
    number = axis.number
    counts = axis.port.raw_encoder
    moved = counts - unit.rotor_before[number]
    unit.rotor_before[number] = counts
    if axis.hardware.scales_speed:
        moved <<= min(unit.rotor_shifts[number], _MAX_SHIFT)
    return saturate_i16(divide(moved, axis.hardware.slots))


def _errors(axes: tuple[Axis, Axis]) -> tuple[int, int, int, int]:
    position = [axis.position_pid.error if axis.enabled else 0 for axis in axes]
    torque = [axis.torque_loop.pid.error if axis.force_controlled else 0 for axis in axes]
    return position[0], position[1], torque[0], torque[1]
