"""Frames that nobody should put on a robot's bus by hand without meaning it.

What goes through the HAL is checked; a frame sent beside it is not.
"""

from hal.wire import analog, management, motor
from hal.wire.can import source_of
from hal.wire.catalogue import Direction, decode, direction_of
from hal.wire.modes import ControlMode

VIRTUAL_SENSORS = (11, 12)  # addresses that motor boards take joint torques from (can-protocol 6)

_STOPS = (ControlMode.IDLE, ControlMode.FORCE_IDLE)
_MOVES = "moves a joint, past every limit of the HAL"
_REASONS: dict[tuple[int, int], str] = {
    (7, management.DISCOVER.code): (
        "a discovery switches off all axes of a motor board and stops its broadcasts"
    ),
    (7, management.BOARD.code): "a board that gets it leaves its application for the boot loader",
    (7, management.ADDRESS.code): "writes firmware",
    (7, management.START.code): "writes firmware",
    (7, management.DATA.code): "writes firmware",
    (7, management.SET_CAN_ADDRESS.code): "gives a board another address",
    (2, analog.SET_BOARD_ADX.code): "gives a sensor another address",
    (2, analog.SAVE2EE.code): "overwrites what the sensor keeps without power",
    (0, motor.SET_BOARD_ID.code): "gives a board another address",
    (0, motor.WRITE_FLASH_MEM.code): "overwrites what the board keeps without power",
    (0, motor.CALIBRATE_ENCODER.code): _MOVES,
    (0, motor.POSITION_MOVE.code): _MOVES,
    (0, motor.VELOCITY_MOVE.code): _MOVES,
    (0, motor.SET_COMMAND_POSITION.code): _MOVES,
    (0, motor.SET_DESIRED_TORQUE.code): _MOVES,
    (0, motor.SET_OPENLOOP_PARAMS.code): _MOVES,
}
_MODE = (0, motor.SET_CONTROL_MODE.code)


def danger(can_id: int, data: bytes) -> str:
    """Why a frame is dangerous, empty when it is not."""
    direction = direction_of(can_id)
    if direction == Direction.BROADCAST:
        form = decode(can_id, data).form
        is_torque = form is not None and form.row in (analog.FORCE, analog.TORQUE)
        is_virtual = is_torque and source_of(can_id) in VIRTUAL_SENSORS
        return "compliant joints act on such torques" if is_virtual else ""
    if direction == Direction.REPLY or not data:
        return ""
    can_class = can_id >> 8
    code = data[0] & 0x7F if can_class == 0 else data[0]
    if (can_class, code) == _MODE:
        mode = data[1] if len(data) > 1 else ControlMode.IDLE
        return "" if mode in _STOPS else "switches a motor on"
    return _REASONS.get((can_class, code), "")
