"""The list of every form: complete, without doubles, and decoding by class, sender and length."""

from collections import Counter

import pytest

from hal.wire import analog, management, motor, motor_foc, motor_periodic
from hal.wire.catalogue import (
    ACKNOWLEDGE,
    FORMS,
    RESET_CAUSE,
    Direction,
    decode,
    named,
)
from hal.wire.layout import WireError
from hal.wire.message import AxisCommand


def test_no_two_forms_share_a_code_and_a_length() -> None:
    places = Counter(
        (form.can_class, form.direction, form.code, form.family, form.layout.dlc)
        for form in FORMS
        if form.code >= 0
    )
    assert [place for place, count in places.items() if count > 1] == []


def test_every_polled_row_has_its_forms() -> None:
    for form_class, commands in ((0, motor.COMMANDS), (2, analog.COMMANDS)):
        requests = {
            form.code
            for form in FORMS
            if (form.can_class, form.direction, form.family) == (form_class, Direction.REQUEST, "")
            and form.code >= 0
        }
        assert requests == set(commands)


def test_all_eight_classes_are_there() -> None:
    assert {form.can_class for form in FORMS} == set(range(8))


# can-protocol 2.1: the codes that DSP boards ignore
FOC_CODES = {1, 2, 5, 6, 70, 71, 77, *range(101, 114), 119, 121, 122, 123, 124, 125, 126}


def test_codes_that_dsp_boards_ignore_have_a_row_of_their_own() -> None:
    assert set(motor_foc.COMMANDS) == FOC_CODES | {72}
    assert not FOC_CODES & set(motor.COMMANDS)


@pytest.mark.parametrize(
    ("code", "values", "payload"),
    [
        (101, (-76, 3, 258, 10), "65 B4 FF 03 00 02 01 0A"),
        (105, (12, 13, 14, 5), "69 0C 00 0D 00 0E 00 05"),
        (109, (-250,), "6D 06 FF FF FF"),
        (112, (668, 12000), "70 9C 02 E0 2E"),
        (119, (1, -8192, 90, 8, 7), "77 01 00 E0 5A 00 08 07"),
        (72, (2000, 5000, 7000), "48 00 D0 07 88 13 58 1B"),
        (111, (1, 2, 3, 4), "6F 01 02 03 04"),
    ],
)
def test_foc_payload(code: int, values: tuple[int, ...], payload: str) -> None:
    command = motor_foc.COMMANDS[code]
    assert command.request(1, 0, *values) == (0x001, bytes.fromhex(payload))
    assert command.parse_request(bytes.fromhex(payload)) == values


def test_length_tells_the_current_limits_apart() -> None:
    dsp = decode(0x001, bytes.fromhex("48581B0000"))
    assert dsp.form is not None
    assert (dsp.form.name, dsp.values) == ("SET_CURRENT_LIMIT", (7000,))
    foc = decode(0x001, bytes.fromhex("4800D0078813581B"))
    assert foc.form is not None
    assert (foc.form.name, foc.values) == ("SET_CURRENT_LIMITS", (2000, 5000, 7000))


def test_micro_saccade_parameters_are_three_words() -> None:
    # can-protocol 2.2: index 20 has i16 at [2], [4] and [6]
    assert decode(0x002, bytes.fromhex("121401000200FDFF")).values == (20, 1, 2, -3)
    assert decode(0x002, bytes.fromhex("120A18FC")).values == (10, -1000)
    assert decode(0x002, bytes.fromhex("120A18FC00")).values == (10, -1000)


def test_cause_tells_unknown_codes_from_wrong_lengths() -> None:
    assert decode(0x001, b"\x7f").cause == "unknown"
    assert decode(0x001, b"").cause == "unknown"
    assert decode(0x001, b"\x1b\x38").cause == "length"
    assert decode(0x3DA, b"\x00").cause == "length"
    assert decode(0x3DA, b"\x00\x80\x3a\x7f\x41\x83") == (
        named("FORCE")[1],
        (0x8000, 0x7F3A, 0x8341),
        None,
        "",
    )


def test_answers_of_a_sensor_that_begin_with_no_command() -> None:
    assert decode(0x2D0, b"").form is ACKNOWLEDGE
    assert decode(0x2D0, b"\x00\x00\x00\x01\x00\x00").form is RESET_CAUSE
    assert decode(0x20D, b"").form is None


def test_name_finds_its_forms() -> None:
    assert [form.direction for form in named("get_p_gain")] == [Direction.REQUEST, Direction.REPLY]
    assert {form.can_class for form in named("GET_ADDITIONAL_INFO")} == {0, 7}
    assert {form.can_class for form in named("7:GET_ADDITIONAL_INFO")} == {7}
    assert named("NO_SUCH_THING") == []


def test_firmware_line_of_the_sheet() -> None:
    # Example 4: 16 bytes at 0x0200, upper address 0, then 6 + 6 + 4 bytes.
    line = bytes.fromhex("CFBB200080F020000001880000000000")
    address = management.ADDRESS_EXTENDED.request(15, 16, 0x0200, 0, 0)
    assert address == (0x70F, bytes.fromhex("01100002000000"))
    frames = [management.DATA.request(15, *line[i : i + 6]) for i in (0, 6, 12)]
    assert frames == [
        (0x70F, bytes.fromhex("03CFBB200080F0")),
        (0x70F, bytes.fromhex("03200000018800")),
        (0x70F, bytes.fromhex("0300000000")),
    ]
    assert management.DATA.parse_request(frames[2][1]) == (0, 0, 0, 0)
    assert management.DATA.parse_reply(bytes.fromhex("0301")) == (1,)


def test_bytes_that_do_not_fit_are_named() -> None:
    with pytest.raises(WireError, match="DATA carries 0 to 6 bytes; got 7"):
        management.DATA.request(1, *range(7))
    with pytest.raises(WireError, match="DATA: byte1 = 256 does not fit u8"):
        management.DATA.request(1, 0, 256)
    with pytest.raises(WireError, match="PRINT carries 2 to 8 bytes; got 1"):
        motor_periodic.PRINT.frame(1, 6)


def test_every_axis_command_may_be_asked_for_both_axes() -> None:
    for form in FORMS:
        if isinstance(form.row, AxisCommand) and form.direction == Direction.REQUEST:
            payload = bytes((form.code | 0x80,)) + bytes(form.layout.dlc - 1)
            decoded = decode(0x003, payload)
            assert decoded.form is not None
            assert (decoded.form.code, decoded.axis) == (form.code, 1)
