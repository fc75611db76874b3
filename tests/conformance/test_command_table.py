"""Every command of class 0 (can-protocol 2.1 and 2.2): who knows it, its lengths, its answer."""

import pytest

from hal.wire.can import Frame
from tests.firmware_sim.boards.bench import Bench

# Exact length of the commands that store, drive or save.
SET_LENGTHS = {
    0: 1,
    3: 1,
    9: 2,
    10: 1,
    11: 1,
    13: 6,
    15: 5,
    16: 5,
    21: 5,
    23: 3,
    25: 3,
    27: 7,
    28: 5,
    29: 5,
    **dict.fromkeys((30, 32, 34, 36, 38, 40, 42), 3),
    44: 5,
    47: 3,
    50: 2,
    52: 8,
    62: 5,
    64: 5,
    66: 5,
    68: 3,
    72: 5,
    73: 5,
    74: 3,
    75: 5,
    78: 8,
    80: 8,
    82: 8,
    84: 8,
    86: 3,
    87: 8,
    89: 3,
    92: 3,
    93: 5,
    95: 5,
    97: 8,
    99: 8,
    114: 3,
    118: 2,
}
# CALIBRATE_ENCODER, SET_SPEED_ESTIM_SHIFT, SET_DEBUG_PARAM, STOP_TRAJECTORY, SET_INTERACTION_MODE.
UNCHECKED = (4, 14, 18, 46, 116)
# Length of the answer of the commands that ask.
REPLY_LENGTHS = {
    7: 3,
    8: 3,
    12: 6,  # eight times
    19: 3,
    20: 7,
    22: 5,
    24: 3,
    26: 3,
    **dict.fromkeys((31, 33, 35, 37, 39, 41, 43), 3),
    45: 5,
    48: 3,
    51: 2,
    55: 3,
    56: 4,
    57: 5,
    58: 3,
    60: 3,
    61: 3,
    63: 3,
    65: 5,
    67: 5,
    69: 3,
    76: 5,
    79: 8,
    81: 8,
    83: 8,
    85: 8,
    88: 8,
    90: 3,
    91: 8,
    94: 5,
    96: 5,
    98: 8,
    100: 8,
    115: 3,
    117: 3,
    120: 2,
}
KNOWN = {*SET_LENGTHS, *UNCHECKED, *REPLY_LENGTHS}
# Defined in the table, ignored by the DSP boards.
FOREIGN = {1, 2, 5, 6, 70, 71, 77, *range(101, 114), 119, *range(121, 127)}
CODES = range(128)
PRESET = 29  # SET_ENCODER_POSITION, which only the 4DC has


def heard(bench: Bench, code: int, length: int) -> tuple[list[Frame], dict[str, int]]:
    """Answers to a command of some length, bytes 0 behind its code, and drops it was counted in."""
    before = bench.board.dropped.copy()
    bench.give((bench.address, bytes((code,)).ljust(length, b"\0")))
    frames = bench.tick()
    return frames, dict(bench.board.dropped - before)


def test_the_table_is_complete() -> None:
    assert len(KNOWN) == len(SET_LENGTHS) + len(UNCHECKED) + len(REPLY_LENGTHS)
    assert not KNOWN & FOREIGN
    undefined = set(CODES) - KNOWN - FOREIGN
    assert undefined == {17, 49, 53, 54, 59, 127}


def test_wrong_lengths_of_a_set_are_silently_ignored(every: Bench) -> None:
    is_4dc = every.axis().hardware.axes == 4
    for code, right in SET_LENGTHS.items():
        for length in range(1, 9):
            if length != right and (is_4dc or code != PRESET):
                assert heard(every, code, length) == ([], {"length": 1}), (code, length)


@pytest.mark.parametrize("axis_bit", [0x00, 0x80])
def test_a_set_of_the_right_length_has_no_reply(every: Bench, axis_bit: int) -> None:
    for code, right in SET_LENGTHS.items():
        frames, dropped = heard(every, code | axis_bit, right)
        assert frames == []
        assert "length" not in dropped


def test_five_commands_are_taken_at_any_length(every: Bench) -> None:
    for code in UNCHECKED:
        for length in range(1, 9):
            frames, dropped = heard(every, code, length)
            assert frames == []
            assert "length" not in dropped


@pytest.mark.parametrize("axis_bit", [0x00, 0x80])
def test_a_get_repeats_byte_0_in_an_answer_of_its_length(every: Bench, axis_bit: int) -> None:
    for code, length in REPLY_LENGTHS.items():
        frames, dropped = heard(every, code | axis_bit, 3)
        assert len(frames) == (8 if code == 12 else 1)
        for can_id, data in frames:
            assert can_id == every.address << 4
            assert data[0] == code | axis_bit
            assert len(data) == length
        assert dropped == {}


def test_foreign_and_undefined_commands_are_unknown(every: Bench) -> None:
    for code in set(CODES) - KNOWN:
        for length in (1, 5, 8):
            assert heard(every, code, length) == ([], {"unknown": 1})


def test_an_unknown_command_leaves_the_rest_for_the_next_millisecond(every: Bench) -> None:
    for data in (b"\x07", b"\x7f", b"\x07", b"\x01", b"\x07"):
        every.give((every.address, data))
    assert [len(every.tick()) for _ in range(4)] == [1, 1, 1, 0]


def test_commands_that_only_some_boards_have(every: Bench) -> None:
    is_4dc = every.axis().hardware.axes == 4
    for length in (1, 5):
        dropped = heard(every, PRESET, length)[1]
        assert dropped == ({"unknown": 1} if not is_4dc else {} if length == 5 else {"length": 1})
    every.give((every.address, bytes((PRESET, 0, 0, 0, 0))))
    every.give((every.address, b"\x07"))
    assert len(every.tick()) == is_4dc  # an unknown command makes the rest wait
    every.tick()
    is_finger = bool(every.axis(0).wiring.hall)
    for code in (15, 16):
        assert heard(every, code, 5)[1] == ({} if is_finger else {"unknown": 1})


def test_get_error_status_knows_no_error(every: Bench) -> None:
    every.configure()
    every.axis(0).fault()
    assert heard(every, 60, 1)[0][0][1] == b"\x3c\x00\x00"
