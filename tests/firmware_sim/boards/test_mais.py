"""The MAIS board, bytes written by hand from the sheet (can-protocol 5.4 and 12)."""

import pytest

from firmware_sim.boards.mais import Mais
from firmware_sim.description import BoardSpec
from hal.wire.can import Frame

ACK: Frame = (0x2E0, b"")


@pytest.fixture
def mais() -> Mais:
    board = Mais(BoardSpec(bus=5, address=14, type="mais", firmware=(3, 1)))
    board.hall[:] = [16, 255, 255, 240, 255, 255, 248, 7, 8, 9, 10, 11, 12, 13, 14]
    return board


def ask(board: Mais, data: str) -> list[Frame]:
    board.on_frame(0x20E, bytes.fromhex(data))
    return board.tick()


def test_is_silent_until_it_is_started(mais: Mais) -> None:
    assert [mais.tick() for _ in range(200)] == [[]] * 200


def test_sends_fifteen_bytes_in_two_frames_each_millisecond_by_default(mais: Mais) -> None:
    sample = [
        (0x3EC, bytes.fromhex("10FFFFF0FFFFF8")),
        (0x3ED, bytes.fromhex("0708090A0B0C0D0E")),
    ]
    assert ask(mais, "0700") == [ACK, *sample]
    assert [mais.tick() for _ in range(3)] == [sample] * 3


def test_sends_each_ten_milliseconds_when_told_to(mais: Mais) -> None:
    assert ask(mais, "080A") == [ACK]
    ask(mais, "0700")
    assert [bool(mais.tick()) for _ in range(30)] == ([False] * 8 + [True] + [False]) * 3


def test_sixteen_bit_mode_sends_four_frames_of_twelve_bit_words(mais: Mais) -> None:
    ask(mais, "1000")
    assert ask(mais, "0700") == [
        ACK,
        (0x3EC, bytes.fromhex("0001F00FF00F000F")),
        (0x3ED, bytes.fromhex("F00FF00F800F7000")),
        (0x3EE, bytes.fromhex("80009000A000B000")),
        (0x3EF, bytes.fromhex("C000D000E0000000")),
    ]


def test_twelve_bit_mode_sends_test_waves(mais: Mais) -> None:
    ask(mais, "1001")
    first = ask(mais, "0700")[1:]
    assert first == [
        (0x3EC, bytes.fromhex("00050A0F14191E01")),
        (0x3ED, bytes.fromhex("7D82878C91969B01")),
    ]
    assert mais.tick()[0] == (0x3EC, bytes.fromhex("FFFAF5F0EBE6E102"))


def test_handshake_says_fw_3_1_2(mais: Mais) -> None:
    assert ask(mais, "1C0100") == [(0x2E0, bytes.fromhex("1C07030102010001"))]
    assert ask(mais, "1C0101") == [(0x2E0, bytes.fromhex("1C07030102010000"))]


def test_settings_are_acknowledged_and_strain_commands_ignored(mais: Mais) -> None:
    assert ask(mais, "1002") == [ACK]
    assert ask(mais, "09") == [ACK]
    assert ask(mais, "1800") == []
    assert ask(mais, "13010000") == []
    assert mais.dropped["unavailable"] == 2
    assert ask(mais, "EE") == [(0x2E0, b"\xeeBUG")]


def test_reads_one_hall_sensor_in_four_bytes(mais: Mais) -> None:
    assert ask(mais, "0C03") == [(0x2E0, bytes.fromhex("0C030F00"))]


@pytest.mark.parametrize("mode", ["0701", "0705"])
def test_stops_when_told_to(mais: Mais, mode: str) -> None:
    ask(mais, "0700")
    assert ask(mais, mode) == [ACK]
    assert mais.tick() == []


def test_a_discovery_stops_the_stream(mais: Mais) -> None:
    ask(mais, "0700")
    mais.on_frame(0x70F, b"\xff")
    assert mais.tick() == [(0x7E0, bytes.fromhex("FF07030102"))]
    assert mais.tick() == []


def test_the_period_is_kept_once_it_is_saved(mais: Mais) -> None:
    ask(mais, "0805")
    mais.power_cycle()
    assert mais.period_ms == 1
    ask(mais, "0805")
    ask(mais, "09")
    mais.power_cycle()
    assert mais.period_ms == 5
