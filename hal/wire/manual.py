"""The frame tables as a page for people: docs/protocol.md is exactly this text."""

from collections.abc import Iterator

from hal.wire.catalogue import FORMS, POLLED_CLASSES, Direction, Form
from hal.wire.layout import Choices, Layout, OpenLayout
from hal.wire.message import PeriodicMessage, PolledMessage

_INTRODUCTION = """\
# The frames on the wire

Written by `ulna can docs` from the tables in `hal/wire`, which codec, DBC file (`ulna can dbc`)
and this page share. Do not edit it by hand.

`identifier = class << 8 | source << 4 | (destination or type)`, 11 bits, 1 Mbit/s, data frames
only. Address 0 is the host, 15 in class 7 is everybody. In the polled classes 0, 2 and 7 byte 0
is the code of the command; in class 0 its bit 7 is the axis (0 or 1) of the address. A reply has
the code of its request. In the other classes the low nibble is the message type, in the skin
class the triangle.

A payload reads `byte:name type [unit]`. Values are raw numbers. Words are little-endian where
nothing else is said; `BE` marks big-endian ones. A board takes a request of any length where the
column *length* says `any`; otherwise one of the wrong length is dropped without a word.
"""

_TITLES = {
    0: "Class 0: polled motor commands",
    1: "Class 1: broadcasts of motor boards",
    2: "Class 2: commands of sensor boards",
    3: "Class 3: force, torque and Hall sensors",
    4: "Class 4: skin",
    5: "Class 5: inertial sensors",
    6: "Class 6: battery",
    7: "Class 7: discovery, labels, firmware",
}
_FAMILIES = {
    "foc": "2FOC and AMC boards only",
    "strain": "STRAIN",
    "mais": "MAIS",
    "mais of 16 bits": "MAIS in 16-bit resolution",
    "skin": "skin board",
}


def manual_text() -> str:
    """The whole page."""
    lines = [_INTRODUCTION]
    for can_class, title in _TITLES.items():
        forms = [form for form in FORMS if form.can_class == can_class]
        lines += [f"## {title}", ""]
        table = _polled_table if can_class in POLLED_CLASSES else _broadcast_table
        lines += [*table(forms), ""]
    lines += ["## Names of codes and bits", "", *_choice_table()]
    return "\n".join(lines) + "\n"


def _polled_table(forms: list[Form]) -> Iterator[str]:
    yield "| code | name | length | request | reply | |"
    yield "|---|---|---|---|---|---|"
    replies = {id(f.row): f for f in forms if f.direction == Direction.REPLY and f.row is not None}
    asked: set[int] = set()
    for form in forms:
        if form.direction == Direction.REQUEST and isinstance(form.row, PolledMessage):
            reply = replies.get(id(form.row))
            asked.add(id(form.row))
            length = "any" if form.row.lenient else _length(form.layout)
            yield _line(
                f"{form.code} 0x{form.code:02X}",
                f"`{form.name}`",
                length,
                _payload(form.layout),
                "no reply" if reply is None else _payload(reply.layout),
                _FAMILIES.get(form.family, ""),
            )
    for form in forms:
        if form.direction == Direction.REPLY and id(form.row) not in asked:
            code = "" if form.code < 0 else f"{form.code} 0x{form.code:02X}"
            payload = _payload(form.layout)
            yield _line(code, f"`{form.name}`", _length(form.layout), "", payload, "answer only")
        if form.direction == Direction.BROADCAST:
            note = f"sent by itself, to address {form.code}: {_FAMILIES[form.family]}"
            payload = _payload(form.layout)
            yield _line("", f"`{form.name}`", _length(form.layout), "", payload, note)


def _broadcast_table(forms: list[Form]) -> Iterator[str]:
    yield "| type | name | length | payload | |"
    yield "|---|---|---|---|---|"
    for form in forms:
        row, note = form.row, _FAMILIES.get(form.family, "")
        if isinstance(row, PeriodicMessage) and row.mask_bit:
            note = f"mask bit 0x{row.mask_bit:03X}"
        kind = f"byte 0 = 0x{form.code:02X}" if form.family == "skin" else f"0x{form.code:X}"
        yield _line(kind, f"`{form.name}`", _length(form.layout), _payload(form.layout), note)


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _length(layout: Layout) -> str:
    if isinstance(layout, OpenLayout):
        return f"{layout.dlc - len(layout.fields) + layout.least}..{layout.dlc}"
    return str(layout.dlc)


def _payload(layout: Layout) -> str:
    if isinstance(layout, OpenLayout) and layout.is_opaque:
        return "bytes"
    if not layout.fields:
        return "nothing"
    mark = " BE" if layout.order == ">" else ""
    texts = []
    for field, start, bits in layout.bits():
        half = "" if bits >= 8 else " low half" if start % 8 == 0 else " high half"
        unit = f" [{field.unit}]" if field.unit else ""
        order = mark if bits > 8 else ""
        choices = f" {field.choices.__name__}" if field.choices is not None else ""
        texts.append(f"{start // 8}:{field.name} {field.kind}{order}{half}{unit}{choices}")
    return ", ".join(texts)


def _choice_table() -> Iterator[str]:
    yield "| name | values |"
    yield "|---|---|"
    for choices in _choices():
        values = ", ".join(f"0x{item.value:02X} {item.name}" for item in choices)
        yield _line(f"`{choices.__name__}`", values)


def _choices() -> list[Choices]:
    named: dict[str, Choices] = {}
    for form in FORMS:
        for field in form.layout.fields:
            if field.choices is not None:
                named.setdefault(field.choices.__name__, field.choices)
    return [named[name] for name in sorted(named)]
