"""One line of text for any frame, by name: fault reports, candump-like listings."""

from hal.wire import analog, management, motor, motor_periodic
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    class_of,
    low_of,
    source_of,
)
from hal.wire.message import PolledMessage


def describe(can_id: int, data: bytes) -> str:
    """Sender, receiver, name and values of a frame; its bytes when no table knows it."""
    can_class, source, low = class_of(can_id), source_of(can_id), low_of(can_id)
    if can_class in (CLASS_MOTOR_PERIODIC, CLASS_ANALOG_PERIODIC):
        return f"{_name(source)}: {_periodic_text(can_class, low, data)}"
    is_reply = low == HOST and source != HOST
    if can_class == CLASS_MOTOR_POLLING:
        text = _motor_text(data, is_reply)
    elif can_class == CLASS_ANALOG_POLLING:
        text = _analog_text(data, is_reply)
    elif can_class == CLASS_MANAGEMENT:
        text = _management_text(data, is_reply)
    else:
        return f"{_name(source)}: class {can_class} type {low}: {_hex(data)}"
    return f"{_name(source)} to {_name(low)}: {text}"


def _name(address: int) -> str:
    if address == HOST:
        return "host"
    return "everybody" if address == EVERYBODY else f"board {address}"


def _hex(data: bytes) -> str:
    return data.hex(" ") or "empty"


def _periodic_text(can_class: int, kind: int, data: bytes) -> str:
    table = motor_periodic.MESSAGES if can_class == CLASS_MOTOR_PERIODIC else analog.MESSAGES
    message = table.get(kind)
    if message is None:
        return f"class {can_class} type {kind}: {_hex(data)}"
    values = message.parse(data)
    if values is None:
        return f"{message.name} of wrong length: {_hex(data)}"
    if isinstance(message, analog.TripleMessage):
        layout = message.layout if len(data) == message.layout.dlc else message.saturated_layout
        return f"{message.name} {layout.text(values)}"
    return f"{message.name} {message.layout.text(values)}".rstrip()


def _polled_text(message: PolledMessage, data: bytes, is_reply: bool, where: str = "") -> str:
    layout = message.reply_layout if is_reply else message.request_layout
    values = message.parse_reply(data) if is_reply else message.parse_request(data)
    if layout is None or values is None:
        return f"{message.name}{where} of wrong length: {_hex(data)}"
    return f"{message.name}{where} {layout.text(values)}".rstrip()


def _motor_text(data: bytes, is_reply: bool) -> str:
    command = motor.command_of(data)
    if command is None:
        return f"motor command unknown: {_hex(data)}"
    return _polled_text(command, data, is_reply, f" axis {motor.axis_of(data)}")


def _analog_text(data: bytes, is_reply: bool) -> str:
    if is_reply and not data:
        return "acknowledged"
    if is_reply and analog.is_unknown_command(data):
        return f"command 0x{data[0]:02X} unknown to the sensor"
    command = analog.COMMANDS.get(data[0]) if data else None
    if is_reply and (command is None or command.reply_layout is None):
        flags = analog.parse_reset_cause(data)
        if flags is not None:
            return f"sensor restarted, {analog.RESET_CAUSE.text(flags)}"
    if command is None:
        return f"sensor command unknown: {_hex(data)}"
    return _polled_text(command, data, is_reply)


def _management_text(data: bytes, is_reply: bool) -> str:
    command = management.COMMANDS.get(data[0]) if data else None
    if command is None:
        return f"management command unknown: {_hex(data)}"
    if is_reply and command is management.DISCOVER and len(data) == 4:
        command = management.DISCOVER_BOOTLOADER
    return _polled_text(command, data, is_reply)
