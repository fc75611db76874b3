"""The frame tables as a DBC file, for candump-like tools, SavvyCAN and cantools.

An identifier contains addresses, so a file speaks of the boards that it is made for. All commands
of one identifier are one multiplexed message: byte 0 selects the signals (bit 7 of a motor command
is a signal of its own, the axis). Values are raw, as everywhere in hal/wire. A DBC message has one
length: read shorter frames with truncation allowed.
"""

from collections.abc import Iterable, Iterator, Sequence
from enum import IntEnum
from typing import NamedTuple

from hal.wire import motor_periodic, skin
from hal.wire.can import (
    CLASS_ANALOG_POLLING,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    frame_id,
)
from hal.wire.catalogue import FORMS, POLLED_CLASSES, RESET_CAUSE, Direction, Form
from hal.wire.dbc_boards import BOARDS
from hal.wire.layout import VALUE_RANGES, Field, Layout

HOST_NAME = "host"
LONGEST_NAME = 32  # of a DBC symbol; longer ones go into the attribute that Vector's tools read


class Node(NamedTuple):
    """One address on a bus. `comment` says what it is for, its joints for instance."""

    address: int
    kind: str
    name: str
    comment: str = ""


class Signal(NamedTuple):
    """One line SG_. `mux` is the selecting value, None for a signal that is always there."""

    name: str
    field: Field
    start: int
    bits: int
    order: str
    mux: int | None = None


class Message(NamedTuple):
    """One line BO_."""

    can_id: int
    name: str
    sender: str
    receivers: str
    length: int
    signals: tuple[Signal, ...]


def dbc_text(nodes: Iterable[Node]) -> str:
    """The file for these boards; of two that share an identifier the first one names it."""
    boards = list(nodes)
    messages: dict[int, Message] = {}
    for message in (*_host_messages(boards), *(m for node in boards for m in _messages(node))):
        messages.setdefault(message.can_id, message)
    ordered = [messages[can_id] for can_id in sorted(messages)]
    names = dict.fromkeys((HOST_NAME, *(node.name for node in boards)))
    comments = {node.name: node.comment for node in boards if node.comment}
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", f"BU_: {' '.join(names)}", ""]
    for message in ordered:
        lines += [*_message_lines(message), ""]
    lines += [f'CM_ BU_ {name} "{comment}";' for name, comment in comments.items()]
    lines += [*_long_names(ordered), ""]
    for message in ordered:
        lines += _value_lines(message)
    return "\n".join(lines) + "\n"


def _host_messages(boards: Sequence[Node]) -> Iterator[Message]:
    everybody = ",".join(dict.fromkeys(node.name for node in boards))
    asked = _polled(CLASS_MANAGEMENT, Direction.REQUEST, EVERYBODY, "everybody", "")
    yield asked._replace(receivers=everybody or HOST_NAME)
    if any(node.kind == "foc" for node in boards):
        row = motor_periodic.EMSTO2FOC_DESIRED_CURRENT
        can_id = frame_id(CLASS_MOTOR_PERIODIC, HOST, row.type)
        signals = tuple(_signals(row.layout, "", None))
        receivers = ",".join(node.name for node in boards if node.kind == "foc")
        yield Message(can_id, row.name, HOST_NAME, receivers, row.layout.dlc, signals)


def _messages(node: Node) -> Iterator[Message]:
    sends = BOARDS[node.kind]
    polled = [sends.polled] if sends.polled is not None else []
    for can_class in (*polled, *([CLASS_MANAGEMENT] if sends.is_managed else [])):
        for direction in (Direction.REQUEST, Direction.REPLY):
            yield _polled(can_class, direction, node.address, node.name, sends.family)
    for can_class, types in sends.broadcasts.items():
        for kind in sorted(types):
            yield _broadcast(node, can_class, kind, sends.family)


_WORDS = {CLASS_MOTOR_POLLING: "motor", CLASS_ANALOG_POLLING: "sensor", CLASS_MANAGEMENT: "manage"}


def _polled(
    can_class: int,
    direction: Direction,
    address: int,
    board: str,
    family: str,
) -> Message:
    """All requests to a board, or all its replies, in one multiplexed message."""
    has_axis = can_class == CLASS_MOTOR_POLLING
    signals = [Signal("command", Field("command", "u8"), 0, 7 if has_axis else 8, "<")]
    if has_axis:
        signals.append(Signal("axis", Field("axis", "u8"), 7, 1, "<"))
    chosen: dict[int, Form] = {}
    for form in FORMS:
        if (form.can_class, form.direction) == (can_class, direction) and form.code >= 0:
            if form.family == family and family:
                chosen[form.code] = form
            elif not form.family:
                chosen.setdefault(form.code, form)
    for code, form in chosen.items():
        signals += _signals(form.layout, f"{form.name}_", code)
    if can_class == CLASS_ANALOG_POLLING and direction == Direction.REPLY:
        # Its first flag, por, lies where the others have the command: 0 or 1, which have no reply.
        signals += list(_signals(RESET_CAUSE.layout, "RESET_CAUSE_", 0))[1:]
    what = f"{_WORDS[can_class]}_{direction.name.lower()}"
    if direction == Direction.REPLY:
        can_id, sender, receivers = frame_id(can_class, address, HOST), board, HOST_NAME
    else:
        can_id, sender, receivers = frame_id(can_class, HOST, address), HOST_NAME, board
    return Message(can_id, f"{board}_{what}", sender, receivers, 8, tuple(signals))


def _broadcast(node: Node, can_class: int, kind: int, family: str) -> Message:
    can_id = frame_id(can_class, node.address, kind)
    ends = (HOST_NAME, node.name) if node.kind == "virtual" else (node.name, HOST_NAME)
    if family == "skin" and can_class in skin.CLASSES:
        signals = [Signal("half", Field("half", "u8"), 0, 8, "<")]
        for row in skin.MESSAGES.values():
            signals += _signals(row.layout, "", row.code)
        name = f"{node.name}_TRIANGLE_{kind}"
        return Message(can_id, name, *ends, 8, tuple(signals))
    forms = {
        form.family: form
        for form in reversed(FORMS)  # of one family the longest form comes first
        if (form.can_class, form.direction, form.code) == (can_class, Direction.BROADCAST, kind)
    }
    form = forms.get(family) or forms[""]
    signals = list(_signals(form.layout, "", None))
    name, length = f"{node.name}_{form.name}", form.layout.dlc
    return Message(can_id, name, *ends, length, tuple(signals))


def _signals(layout: Layout, prefix: str, mux: int | None) -> Iterator[Signal]:
    for field, start, bits in layout.bits():
        # A big-endian signal starts at its most significant bit.
        first = start + 7 if layout.order == ">" else start
        yield Signal(f"{prefix}{field.name}", field, first, bits, layout.order, mux)


def _message_lines(message: Message) -> Iterator[str]:
    short = _short(message.name, f"{message.can_id:03X}")
    yield f"BO_ {message.can_id} {short}: {message.length} {message.sender}"
    muxed = any(signal.mux is not None for signal in message.signals)
    for index, signal in enumerate(message.signals):
        select = "" if signal.mux is None else f" m{signal.mux}"
        if muxed and index == 0:
            select = " M"
        order, sign = ("0" if signal.order == ">" else "1"), "-" if _is_signed(signal) else "+"
        low, high = VALUE_RANGES[signal.field.kind] if signal.bits > 1 else (0, 1)
        if not signal.field.kind.startswith("i"):
            high = (1 << signal.bits) - 1
        yield (
            f" SG_ {_short(signal.name, str(index))}{select} : "
            f"{signal.start}|{signal.bits}@{order}{sign} (1,0) [{low}|{high}] "
            f'"{signal.field.unit}" {message.receivers}'
        )


def _is_signed(signal: Signal) -> bool:
    return signal.field.kind.startswith("i")


def _short(name: str, suffix: str) -> str:
    """A symbol of at most 32 characters; the suffix keeps what was cut apart."""
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 5]}_{suffix}"


def _long_names(messages: Sequence[Message]) -> Iterator[str]:
    for kind, of in (("BO_", "Message"), ("SG_", "Signal")):
        yield f'BA_DEF_ {kind} "System{of}LongSymbol" STRING ;'
    for of in ("Message", "Signal"):
        yield f'BA_DEF_DEF_ "System{of}LongSymbol" "";'
    for message in messages:
        short = _short(message.name, f"{message.can_id:03X}")
        if short != message.name:
            yield f'BA_ "SystemMessageLongSymbol" BO_ {message.can_id} "{message.name}";'
        for index, signal in enumerate(message.signals):
            short = _short(signal.name, str(index))
            if short != signal.name:
                place = f"SG_ {message.can_id} {short}"
                yield f'BA_ "SystemSignalLongSymbol" {place} "{signal.name}";'


def _value_lines(message: Message) -> Iterator[str]:
    for index, signal in enumerate(message.signals):
        name = _short(signal.name, str(index))
        choices = signal.field.choices
        if choices is not None and issubclass(choices, IntEnum):
            codes = " ".join(
                f'{choice.value} "{choice.name}"'
                for choice in choices
                if choice.value < 1 << signal.bits
            )
            yield f"VAL_ {message.can_id} {name} {codes} ;"
        elif signal.name in ("command", "half"):
            codes = " ".join(
                f'{code} "{text}"' for code, text in sorted(_selected(message).items())
            )
            yield f"VAL_ {message.can_id} {name} {codes} ;"
        if signal.name.startswith("RESET_CAUSE_"):
            yield f"SG_MUL_VAL_ {message.can_id} {name} command 0-1;"


def _selected(message: Message) -> dict[int, str]:
    """Names of the values of the selecting signal."""
    can_class, reply = message.can_id >> 8, message.can_id & 0xF == HOST
    if can_class not in POLLED_CLASSES:
        return {code: row.name for code, row in skin.MESSAGES.items()}
    direction = Direction.REPLY if reply else Direction.REQUEST
    names: dict[int, str] = {}
    for form in FORMS:
        if (form.can_class, form.direction) == (can_class, direction) and form.code >= 0:
            names.setdefault(form.code, form.name)
    return names
