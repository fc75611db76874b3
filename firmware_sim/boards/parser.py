"""Takes received frames apart: commands, virtual torques, discovery (can-protocol 1, 2, 6, 8)."""

from firmware_sim.boards import commands, queries, settings
from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.hardware import Firmware
from firmware_sim.boards.node import LABEL_PIECES, Node
from firmware_sim.boards.settings import Handler
from firmware_sim.boards.unit import MICRO_SACCADE
from hal.wire import management, motor
from hal.wire.analog import FORCE, TORQUE
from hal.wire.can import EVERYBODY, Frame, low_of, source_of
from hal.wire.layout import Layout, i16, pad
from hal.wire.message import CODE_MASK, AxisCommand

_TORQUE_TYPES = frozenset({FORCE.type, TORQUE.type})
_SWITCH_OFF = tuple(bytes((command.code,)) for command in (management.DISCOVER, management.BOARD))
_PRESET = motor.SET_ENCODER_POSITION.code
_MICRO_SACCADE = bytes((MICRO_SACCADE,))
_THREE_WORDS = Layout((pad(2), i16("first"), i16("second"), i16("third")))
_COMMANDS: dict[int, tuple[AxisCommand, Handler]] = {
    code: (motor.COMMANDS[code], handler)
    for code, handler in (
        *commands.HANDLERS.items(),
        *queries.HANDLERS.items(),
        *settings.handlers(),
    )
}


def command(axis: Axis, data: bytes, requester: int, sent: list[Frame]) -> bool:
    """Act on a class 0 payload for `axis`; replies go to `sent`.

    Returns False for an unknown command, after which the board leaves its queue for this
    millisecond.
    """
    code = data[0] & CODE_MASK
    known = _COMMANDS.get(code)
    if known is None or (code == _PRESET and not axis.hardware.presets_encoder):
        axis.node.dropped["unknown"] += 1
        return False
    row, handler = known
    if row is motor.SET_DEBUG_PARAM and data[1:2] == _MICRO_SACCADE:
        axis.node.unit.micro_saccade = _THREE_WORDS.parse_lenient(data)
        return True
    request = row.parse_request(data)
    if request is None:
        axis.node.dropped["length"] += 1
        return True
    reply = handler(axis, request)
    if reply is not None:
        can_id, payload = row.reply(axis.pair.address, axis.index, *reply)
        sent.append((can_id | requester, payload))
    return True


def send_label(axis: Axis, requester: int, sent: list[Frame]) -> None:
    """The board's label in eight replies."""
    for index in range(LABEL_PIECES):
        values = axis.node.label_piece(index)
        can_id, payload = motor.GET_ADDITIONAL_INFO.reply(axis.pair.address, axis.index, *values)
        sent.append((can_id | requester, payload))


def virtual_torque(node: Node, firmware: Firmware, can_id: int, data: bytes) -> None:
    """Take in a class 3 frame: torques of a sensor that an axis listens to re-arm its watchdog.

    Any other type but the tolerated ones makes the boards of arms and legs complain in a print.
    """
    place = node.torque_frames.get(can_id)
    if place is None:
        kind = can_id & 0xF
        if firmware.complains and kind not in _TORQUE_TYPES | firmware.tolerated_types:
            node.printer.say("unknown strain msg")
        return
    words = FORCE.parse(data)  # TORQUE has the same three words
    if words is None:
        node.dropped["length"] += 1
        return
    sensor, half = place
    sensor.hear(half, words)


def switches_off(address: int, can_id: int, data: bytes) -> bool:
    """True for a discovery, and for the jump to the boot loader."""
    return low_of(can_id) in (address, EVERYBODY) and data[:1] in _SWITCH_OFF


def manage(node: Node, can_id: int, data: bytes, board_type: int, build: int) -> list[Frame]:
    """Answers of the application to a class 7 frame."""
    if low_of(can_id) not in (node.address, EVERYBODY) or source_of(can_id):
        return []
    if not data:
        node.dropped["length"] += 1
        return []
    code = data[0]
    if code == management.DISCOVER.code:
        return [management.DISCOVER.reply(node.address, board_type, *node.version, build)]
    if code == management.END.code:  # a running application takes it as a ping
        return [management.END.reply(node.address, 1)]
    if code == management.GET_ADDITIONAL_INFO.code:
        return [
            management.GET_ADDITIONAL_INFO.reply(node.address, *node.label_piece(index))
            for index in range(LABEL_PIECES)
        ]
    if code == management.BOARD.code:
        return node.unit.loader.enter()
    if code == management.SET_ADDITIONAL_INFO.code:
        index, *characters = management.SET_ADDITIONAL_INFO.parse_request(data) or (LABEL_PIECES,)
        node.set_label_piece(index, characters)
        return []
    node.dropped["management"] += 1
    return []
