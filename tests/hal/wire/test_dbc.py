"""The DBC file: cantools loads it strictly and reads every frame as our own codec does."""

import re
from functools import cache

import pytest
from cantools.database import Database, load_string
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.wire import analog, skin
from hal.wire.can import HOST, Frame, class_of
from hal.wire.catalogue import (
    ACKNOWLEDGE,
    FORMS,
    POLLED_CLASSES,
    RESET_CAUSE,
    UNKNOWN_COMMAND,
    Direction,
    Form,
    decode,
)
from hal.wire.dbc import Node, dbc_text
from hal.wire.dbc_boards import BOARDS
from hal.wire.layout import VALUE_RANGES, OpenLayout
from hal.wire.message import AxisCommand, Command, PeriodicMessage

# Every frame of the worked examples, can-protocol 12; the boards are those that they speak of.
EXAMPLES = """
1  70F [1] FF
1  7E0 [5] FF 06 02 03 06
1  730 [5] FF 03 01 11 17
2  703 [1] 0C
2  730 [6] 0C 02 61 62 63 64
3  20E [1] 1A
3  2E0 [8] 1A 53 4E 30 32 33 00 00
4  70D [2] 00 00
4  7D0 [2] 00 01
4  70F [7] 01 10 00 02 00 00 00
4  70F [7] 03 CF BB 20 00 80 F0
4  70F [7] 03 20 00 00 01 88 00
4  70F [5] 03 00 00 00 00
4  7D0 [2] 03 01
5  001 [3] 5B 01 06
5  010 [8] 5B 04 02 50 57 01 06 01
6  001 [5] 49 37 00 00 00
7  001 [8] 04 03 55 09 0A 00 09 0C
8  001 [3] 1E 00 7D
9  001 [8] 4E B4 FF 00 00 00 00 0E
10 001 [5] 40 C7 07 00 00
10 001 [5] 42 77 0C 00 00
11 001 [5] 48 58 1B 00 00
12 001 [3] 4A 08 00
12 001 [3] 56 64 00
13 002 [2] 89 01
14 123 [8] 00 00 00 01 00 00 00 00
15 111 [8] 38 08 00 00 C6 0D 00 00
16 001 [7] 1B 38 08 00 00 0B 00
17 002 [5] BE 60 05 00 00
18 006 [5] 1C 1D 00 01 00
19 002 [2] F4 01
19 12C [1] 10
20 001 [8] 57 90 00 33 2A 00 00 00
21 001 [5] 2C 00 10 00 00
22 001 [2] 09 50
22 001 [3] 72 50 00
23 3CA [6] FF BF 01 60 00 80
23 3CB [6] FF 87 00 80 00 80
24 20D [2] 18 00
24 2D0 [4] 18 00 05 F1
25 20D [2] 08 01
25 2D0 [0]
25 20D [2] 07 00
26 3DA [6] 00 80 3A 7F 41 83
27 3DB [6] C4 83 2C 7E 2A 81
28 3DA [7] 00 80 3A 7F 41 83 05
29 2D0 [6] 00 00 00 01 00 00
30 113 [8] 04 00 04 00 00 00 00 00
31 113 [8] 08 A0 00 00 00 00 00 00
32 114 [8] 5E 01 88 FF 00 00 00 00
33 112 [8] 78 00 D3 FF 76 00 D4 FF
34 20E [3] 4F 0C 0A
34 5E1 [6] 00 00 00 00 00 40
35 4E3 [8] 40 F0 F0 F0 F0 F0 F0 F0
35 4E3 [8] C0 F0 F0 F0 F0 F0 00 00
36 3EC [7] 10 FF FF F0 FF FF F8
37 10F [8] FA 00 06 FF 00 00 00 00
37 110 [8] F4 01 0C 00 00 40 00 00
38 001 [2] 09 09
""".strip().splitlines()

NODES = (
    Node(1, "bll_ie", "board1"),
    Node(2, "bll_ie", "board2"),
    Node(3, "dc4", "board3"),
    Node(4, "dc4 second", "board3_second"),
    Node(6, "bll_ie", "board6"),
    Node(12, "virtual", "virtual"),
    Node(13, "strain", "strain"),
    Node(14, "mais", "mais"),
    Node(14, "mtb", "mtb"),
)
FOC_NODES = (Node(1, "foc", "foc1"), Node(2, "foc", "foc2"))


@cache
def database(nodes: tuple[Node, ...]) -> Database:
    loaded = load_string(dbc_text(nodes), "dbc", strict=True)
    assert isinstance(loaded, Database)
    return loaded


def ours(can_id: int, data: bytes) -> dict[str, int]:
    """Values of our codec, under the names of the DBC file."""
    decoded = decode(can_id, data)
    form = decoded.form
    assert form is not None
    assert decoded.cause == ""
    if form is ACKNOWLEDGE:
        return {}
    names = [field.name for field in form.layout.fields]
    if form is RESET_CAUSE:  # its first flag lies where other replies have the command
        names = ["command", *(f"RESET_CAUSE_{name}" for name in names[1:])]
        return dict(zip(names, decoded.values, strict=True))
    if form.can_class not in POLLED_CLASSES:
        values = dict(zip(names, decoded.values, strict=False))
        if isinstance(form.row, skin.TriangleMessage):
            values["half"] = data[0]
        return values
    values = {f"{form.name}_{name}": v for name, v in zip(names, decoded.values, strict=False)}
    values["command"] = form.code
    if decoded.axis is not None:
        values["axis"] = decoded.axis
    return values


def theirs(nodes: tuple[Node, ...], can_id: int, data: bytes) -> dict[str, int]:
    values = database(nodes).decode_message(
        can_id, data, decode_choices=False, allow_truncated=True
    )
    assert isinstance(values, dict)
    return {name: value for name, value in values.items() if isinstance(value, int)}


def test_all_38_examples_are_here() -> None:
    assert {int(line.split()[0]) for line in EXAMPLES} == set(range(1, 39))


@pytest.mark.parametrize("line", EXAMPLES)
def test_cantools_reads_the_worked_examples_as_we_do(line: str) -> None:
    number, head, dlc, *digits = line.split()
    can_id, data = int(head, 16), bytes.fromhex("".join(digits))
    assert dlc == f"[{len(data)}]", "the sheet's line was typed wrongly"
    nodes = FOC_NODES if number == "37" else NODES
    assert theirs(nodes, can_id, data) == ours(can_id, data)


def test_values_of_the_examples_by_hand() -> None:
    # Examples 7, 24, 32: ours and cantools could agree on something wrong.
    assert theirs(NODES, 0x001, bytes.fromhex("040355090A00090C")) == {
        "command": 4,
        "axis": 0,
        "CALIBRATE_ENCODER_type": 3,
        "CALIBRATE_ENCODER_p1": 2389,
        "CALIBRATE_ENCODER_p2": 10,
        "CALIBRATE_ENCODER_p3": 3081,
    }
    assert theirs(NODES, 0x2D0, bytes.fromhex("180005F1")) == {
        "command": 0x18,
        "GET_FULL_SCALES_channel": 0,
        "GET_FULL_SCALES_full_scale": 1521,
    }
    assert theirs(NODES, 0x114, bytes.fromhex("5E0188FF00000000")) == {
        "current0": 350,
        "current1": -120,
    }


ADDRESS = 7


def kind_for(form: Form) -> str:
    """A type of board whose part of the file has this form."""
    if form.family == "skin":
        return "mtb" if form.can_class == 4 else "mtb of old style"
    if form.family:
        return form.family
    if form.can_class == 1:
        return "foc" if form.code in (0, 15) else "bll"
    if form.can_class == 5:
        return "imu" if form.code >= 3 else "mtb"
    if form.can_class == 6:
        return "battery"
    return "strain2" if form.can_class in (2, 3) else "bll"


EVERY_FORM = [form for form in FORMS if form not in (ACKNOWLEDGE, UNKNOWN_COMMAND, RESET_CAUSE)]


@pytest.mark.parametrize("form", EVERY_FORM, ids=lambda form: f"{form.name}-{form.direction.name}")
@settings(max_examples=5, deadline=None)
@given(data=st.data(), axis=st.integers(0, 1))
def test_cantools_reads_every_form_as_we_do(form: Form, data: st.DataObject, axis: int) -> None:
    layout = form.layout
    values = tuple(
        data.draw(st.integers(*VALUE_RANGES[field.kind]), label=field.name)
        for field in layout.fields
    )
    if isinstance(layout, OpenLayout):
        values = values[: data.draw(st.integers(layout.least, len(values)), label="bytes")]
    can_id, payload = sent_by_us(form, axis, values)

    read = theirs((Node(ADDRESS, kind_for(form), "board"),), can_id, payload)

    prefix = f"{form.name}_" if class_of(can_id) in POLLED_CLASSES else ""
    names = [f"{prefix}{field.name}" for field in layout.fields]
    selecting = {"command": form.code, "axis": axis, "half": form.code}
    wanted = dict(zip(names, values, strict=False))
    assert read == wanted | {name: selecting[name] for name in selecting.keys() & read.keys()}


def sent_by_us(form: Form, axis: int, values: tuple[int, ...]) -> Frame:
    row = form.row
    if isinstance(row, AxisCommand):
        make = row.request if form.direction == Direction.REQUEST else row.reply
        return make(ADDRESS, axis, *values)
    if isinstance(row, Command):
        send = row.request if form.direction == Direction.REQUEST else row.reply
        return send(ADDRESS, *values)
    if isinstance(row, skin.TriangleMessage):
        return row.frame(ADDRESS, 3, *values, can_class=form.can_class)
    assert isinstance(row, PeriodicMessage | analog.TripleMessage)
    source = HOST if form.name == "EMSTO2FOC_DESIRED_CURRENT" else ADDRESS
    return row.frame(source, *values)


def test_a_long_name_is_kept_beside_the_short_one() -> None:
    text = dbc_text(NODES)
    symbols = re.findall(r"^ ?(?:BO_|SG_)(?: \d+)? (\w+)", text, flags=re.MULTILINE)
    assert max(map(len, symbols)) <= 32
    message = database(NODES).get_message_by_frame_id(0x001)
    assert "SET_SPEED_ESTIM_SHIFT_joint_velocity" in {signal.name for signal in message.signals}


def test_codes_have_names() -> None:
    read = database(NODES).decode_message(0x113, bytes.fromhex("08A0000000000000"))
    assert isinstance(read, dict)
    assert str(read["mode0"]) == "HW_FAULT"
    sent = database(NODES).decode_message(0x002, bytes.fromhex("8901"), allow_truncated=True)
    assert isinstance(sent, dict)
    assert (str(sent["command"]), str(sent["SET_CONTROL_MODE_mode"])) == (
        "SET_CONTROL_MODE",
        "POSITION",
    )


def test_comment_of_a_board_is_in_the_file() -> None:
    node = Node(1, "bll_ie", "shoulder", "axis 0: right_shoulder_pitch")
    loaded = database((node,)).get_node_by_name("shoulder")
    assert loaded.comment == "axis 0: right_shoulder_pitch"


@pytest.mark.parametrize("kind", sorted(BOARDS))
def test_every_type_of_board_loads_strictly(kind: str) -> None:
    loaded = database((Node(5, kind, "board"),))
    assert loaded.get_message_by_frame_id(0x70F).name == "everybody_manage_request"
    assert {message.frame_id & 0xF for message in loaded.messages} <= set(range(16))


def test_senders_and_receivers_are_the_boards_and_the_host() -> None:
    messages = {message.frame_id: message for message in database(NODES).messages}

    def ends(can_id: int) -> tuple[list[str], set[str]]:
        message = messages[can_id]
        return message.senders, {name for s in message.signals for name in s.receivers}

    assert ends(0x001) == (["host"], {"board1"})
    assert ends(0x010) == (["board1"], {"host"})
    assert ends(0x111) == (["board1"], {"host"})
    assert ends(0x3CA) == (["host"], {"virtual"})
    assert ends(0x70F)[0] == ["host"]
    assert {"board1", "board3", "strain", "mtb"} <= ends(0x70F)[1]


def test_second_address_of_a_4dc_is_never_managed() -> None:
    ids = {message.frame_id for message in database(NODES).messages}
    assert {0x703, 0x730, 0x004, 0x040, 0x141} <= ids
    assert not {0x704, 0x740} & ids
