"""One line of text for any frame, by name: fault reports, candump-like listings."""

from hal.wire.can import CLASS_ANALOG_POLLING, EVERYBODY, HOST, class_of, low_of, source_of
from hal.wire.catalogue import (
    ACKNOWLEDGE,
    POLLED_CLASSES,
    RESET_CAUSE,
    UNKNOWN_COMMAND,
    Decoded,
    Direction,
    decode,
)
from hal.wire.layout import OpenLayout

_KIND = {0: "motor", CLASS_ANALOG_POLLING: "sensor", 7: "management"}


def describe(can_id: int, data: bytes) -> str:
    """Sender, receiver, name and values of a frame; its bytes when no table knows it."""
    can_class, low = class_of(can_id), low_of(can_id)
    decoded = decode(can_id, data)
    is_broadcast = decoded.form is not None and decoded.form.direction == Direction.BROADCAST
    if can_class in POLLED_CLASSES and not is_broadcast:
        text = _polled_text(can_class, decoded, data)
        return f"{_name(source_of(can_id))} to {_name(low)}: {text}"
    if decoded.form is None:
        text = f"class {can_class} type {low}: {_hex(data)}"
    else:
        text = form_text(decoded, data)
    return f"{_name(source_of(can_id))}: {text}"


def form_text(decoded: Decoded, data: bytes) -> str:
    """Name, axis and values of a frame that a table knows."""
    form = decoded.form
    if form is None:
        return _hex(data)
    where = "" if decoded.axis is None else f" axis {decoded.axis}"
    if decoded.cause:
        return f"{form.name}{where} of wrong length: {_hex(data)}"
    if isinstance(form.layout, OpenLayout) and form.layout.is_opaque:
        return f"{form.name}{where} {bytes(decoded.values).hex(' ')}".rstrip()
    return f"{form.name}{where} {form.layout.text(decoded.values)}".rstrip()


def _name(address: int) -> str:
    if address == HOST:
        return "host"
    return "everybody" if address == EVERYBODY else f"board {address}"


def _hex(data: bytes) -> str:
    return data.hex(" ") or "empty"


def _polled_text(can_class: int, decoded: Decoded, data: bytes) -> str:
    form = decoded.form
    if form is None:
        return f"{_KIND[can_class]} command unknown: {_hex(data)}"
    if form is ACKNOWLEDGE:
        return "acknowledged"
    if form is UNKNOWN_COMMAND:
        return f"command 0x{data[0]:02X} unknown to the sensor"
    if form is RESET_CAUSE:
        return f"sensor restarted, {form.layout.text(decoded.values)}"
    return form_text(decoded, data)
