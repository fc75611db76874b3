from random import Random

from hypothesis import given
from hypothesis import strategies as st

from hal.wire.motor_periodic import PRINT
from hal.wire.texts import PrintReader, label_pieces, label_text, print_frames

ASCII = st.characters(min_codepoint=32, max_codepoint=126)


def test_print_is_cut_into_pieces_of_six_characters() -> None:
    assert print_frames(2, 1, "calib failed") == [
        (0x126, b"\x06\x10calib "),
        (0x126, b"\x86\x11failed"),
    ]


def test_short_print_has_a_short_frame() -> None:
    assert print_frames(2, 0, "no") == [(0x126, b"\x86\x00no")]
    assert print_frames(2, 0, "") == [(0x126, b"\x86\x00")]
    assert PRINT.parse(b"\x86\x00no") == (0x86, 0x00, ord("n"), ord("o"))
    assert PRINT.parse(b"\x86") is None


@given(st.text(ASCII, max_size=96), st.integers(0, 3), st.randoms(use_true_random=False))
def test_print_pieces_arrive_in_any_order(text: str, string_id: int, random: Random) -> None:
    frames = print_frames(2, string_id, text)
    random.shuffle(frames)
    reader = PrintReader()
    results = [reader.add(data) for _, data in frames]
    assert results[:-1] == [None] * (len(frames) - 1)
    assert results[-1] == text


def test_two_prints_may_interleave() -> None:
    reader = PrintReader()
    (_, a0), (_, a1) = print_frames(2, 0, "first one")
    (_, b0), (_, b1) = print_frames(2, 1, "other one")
    assert [reader.add(piece) for piece in (a0, b0, b1, a1)] == [
        None,
        None,
        "other one",
        "first one",
    ]


def test_print_longer_than_sixteen_pieces_is_cut() -> None:
    assert len(print_frames(2, 0, "x" * 200)) == 16


@given(st.binary(max_size=9))
def test_print_reader_takes_any_bytes(data: bytes) -> None:
    PrintReader().add(data)


def test_label_arrives_out_of_order() -> None:
    # Order of example 2 of can-protocol 12: 0, 1, 3, 4, 5, 6, 7, 2.
    pieces = label_pieces("left forearm")
    assert pieces[0] == (0, *b"left")
    assert pieces[3] == (3, 0, 0, 0, 0)
    assert label_text([pieces[i] for i in (0, 1, 3, 4, 5, 6, 7, 2)]) == "left forearm"


def test_label_with_a_missing_piece_is_not_read() -> None:
    assert label_text(label_pieces("left forearm")[:7]) is None
