"""Every form of every frame in one list: what names, decodes, documents and exports them.

A form is one payload under one name: the request of a command, its reply, or a broadcast. The rows
of the frame tables are its only source.
"""

from collections.abc import Iterable, Iterator
from enum import IntEnum
from typing import NamedTuple

from hal.wire import (
    analog,
    battery,
    inertial,
    mais,
    management,
    motor,
    motor_foc,
    motor_periodic,
    skin,
)
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    CLASS_SKIN_PERIODIC,
    HOST,
    class_of,
    low_of,
    source_of,
)
from hal.wire.layout import Layout, pad, u8
from hal.wire.message import CODE_MASK, PeriodicMessage, PolledMessage

POLLED_CLASSES = (CLASS_MOTOR_POLLING, CLASS_ANALOG_POLLING, CLASS_MANAGEMENT)


Row = PolledMessage | PeriodicMessage | analog.TripleMessage | skin.TriangleMessage


class Direction(IntEnum):
    """Who sends a form."""

    REQUEST = 0
    REPLY = 1
    BROADCAST = 2


class Form(NamedTuple):
    """One payload under one name.

    `code` is byte 0 of a polled or of a skin frame, else the message type.
    """

    can_class: int
    code: int
    name: str
    direction: Direction
    layout: Layout
    row: Row | None = None
    family: str = ""  # whose form it is, where boards of several types share a code

    @property
    def is_axis(self) -> bool:
        """Whether bit 7 of byte 0 selects an axis."""
        return self.can_class == CLASS_MOTOR_POLLING


class Decoded(NamedTuple):
    """A frame taken apart. Without values, `cause` says why it could not be read."""

    form: Form | None
    values: tuple[int, ...]
    axis: int | None
    cause: str


ACKNOWLEDGE = Form(CLASS_ANALOG_POLLING, -1, "ACKNOWLEDGE", Direction.REPLY, Layout(()))
UNKNOWN_COMMAND = Form(
    CLASS_ANALOG_POLLING, -1, "UNKNOWN_COMMAND", Direction.REPLY, Layout((u8("command"), pad(3)))
)
RESET_CAUSE = Form(CLASS_ANALOG_POLLING, -1, "RESET_CAUSE", Direction.REPLY, analog.RESET_CAUSE)
"""The three answers of a sensor that begin with no command (can-protocol 5.1)."""


def _polled(can_class: int, rows: Iterable[PolledMessage], family: str = "") -> Iterator[Form]:
    for row in rows:
        head = can_class, row.code, row.name
        if row is not management.DISCOVER_BOOTLOADER:  # the question of DISCOVER
            yield Form(*head, Direction.REQUEST, row.request_layout, row, family)
        if row.reply_layout is not None:
            yield Form(*head, Direction.REPLY, row.reply_layout, row, family)


def _broadcast(
    can_class: int, rows: Iterable[PeriodicMessage | analog.TripleMessage], family: str = ""
) -> Iterator[Form]:
    for row in rows:
        head = can_class, row.type, row.name, Direction.BROADCAST
        if isinstance(row, analog.TripleMessage):
            yield Form(*head, row.saturated_layout, row, family)
        yield Form(*head, row.layout, row, family)


def _skin(can_class: int) -> Iterator[Form]:
    for row in skin.MESSAGES.values():
        yield Form(can_class, row.code, row.name, Direction.BROADCAST, row.layout, row, "skin")


FORMS: tuple[Form, ...] = (
    *_polled(0, motor.LONGER_FORMS),
    *_polled(0, motor.COMMANDS.values()),
    *_polled(0, motor_foc.COMMANDS.values(), family="foc"),
    *_broadcast(1, motor_periodic.MESSAGES.values()),
    *_broadcast(1, (analog.RECEIVE_OVERFLOW,), family="strain"),
    *_broadcast(1, (analog.RECEIVE_OVERFLOW,), family="mais"),
    *_polled(2, analog.COMMANDS.values()),
    ACKNOWLEDGE,
    UNKNOWN_COMMAND,
    RESET_CAUSE,
    *_broadcast(3, analog.MESSAGES.values()),
    *_broadcast(3, mais.MESSAGES.values(), family="mais"),
    *_broadcast(3, mais.WORD_MESSAGES.values(), family="mais of 16 bits"),
    *_skin(CLASS_ANALOG_PERIODIC),
    *_skin(CLASS_SKIN_PERIODIC),
    *_broadcast(5, inertial.MESSAGES.values()),
    *_broadcast(6, battery.MESSAGES.values()),
    *_polled(7, management.ROWS),
    *_broadcast(7, (skin.RECEIVE_OVERFLOW,), family="skin"),
)
"""Every form, by class; of one code the longest payload comes first."""

_BY_KEY: dict[tuple[int, Direction, int], list[Form]] = {}
_SKIN: dict[tuple[int, int], Form] = {}
for _form in FORMS:
    if isinstance(_form.row, skin.TriangleMessage):
        _SKIN[_form.can_class, _form.code] = _form
    else:
        _BY_KEY.setdefault((_form.can_class, _form.direction, _form.code), []).append(_form)


def direction_of(can_id: int) -> Direction:
    """Who sends a frame of this identifier."""
    if class_of(can_id) not in POLLED_CLASSES:
        return Direction.BROADCAST
    is_reply = low_of(can_id) == HOST and source_of(can_id) != HOST
    return Direction.REPLY if is_reply else Direction.REQUEST


def decode(can_id: int, data: bytes) -> Decoded:
    """Form and values of any frame; a cause where no table knows it or its length is wrong."""
    can_class, direction = class_of(can_id), direction_of(can_id)
    if direction == Direction.BROADCAST:
        decoded = _chosen(_BY_KEY.get((can_class, direction, low_of(can_id)), ()), data, None)
        # DELIBERATE: eight bytes of class 3 that a MAIS could have sent are not taken for skin of
        # the old style, whatever their first byte: the two never share a bus of a real robot.
        if decoded.cause and can_class in skin.CLASSES and data:
            form = _SKIN.get((can_class, data[0]))
            return decoded if form is None else _chosen((form,), data, None)
        return decoded
    if can_class == CLASS_ANALOG_POLLING and direction == Direction.REPLY:
        special = _sensor_answer(data)
        if special is not None:
            return special
    if not data:
        key = can_class, Direction.BROADCAST, low_of(can_id)
        return _chosen(_BY_KEY.get(key, ()) if source_of(can_id) else (), data, None)
    if can_class == CLASS_MOTOR_POLLING:
        forms = _BY_KEY.get((can_class, direction, data[0] & CODE_MASK), ())
        return _chosen(forms, data, data[0] >> 7)
    return _chosen(_BY_KEY.get((can_class, direction, data[0]), ()), data, None)


def _sensor_answer(data: bytes) -> Decoded | None:
    if not data:
        return Decoded(ACKNOWLEDGE, (), None, "")
    if analog.is_unknown_command(data):
        return Decoded(UNKNOWN_COMMAND, (data[0],), None, "")
    if (CLASS_ANALOG_POLLING, Direction.REPLY, data[0]) not in _BY_KEY:
        flags = analog.parse_reset_cause(data)
        if flags is not None:
            return Decoded(RESET_CAUSE, flags, None, "")
    return None


def _chosen(forms: Iterable[Form], data: bytes, axis: int | None) -> Decoded:
    """The form whose length it is, else one that takes any length, else none of them."""
    first = lenient = None
    for form in forms:
        values = form.layout.parse(data)
        if values is not None:
            return Decoded(form, values, axis, "")
        first = first or form
        if form.direction == Direction.REQUEST and isinstance(form.row, PolledMessage):
            lenient = lenient or (form if form.row.lenient else None)
    if first is None:
        return Decoded(None, (), axis, "unknown")
    if lenient is not None:
        return Decoded(lenient, lenient.layout.parse_lenient(data), axis, "")
    return Decoded(first, (), axis, "length")


def named(name: str) -> list[Form]:
    """Forms of a name, written in any case; `2:GET_FW_VERSION` asks for those of one class."""
    head, _, tail = name.rpartition(":")
    wanted = tail.upper()
    return [
        form for form in FORMS if form.name == wanted and (not head or str(form.can_class) == head)
    ]
