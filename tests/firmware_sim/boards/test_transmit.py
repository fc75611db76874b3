"""The transmit buffer of ten, last-in-first-out (can-protocol 1 and worked example 2)."""

from dataclasses import replace

from firmware_sim.boards.transmit import TransmitBuffer
from hal.wire import motor
from hal.wire.can import Frame
from hal.wire.motor_periodic import STATUS, CanStatus
from tests.firmware_sim.boards.bench import SPECS, Bench


def frames(count: int) -> list[Frame]:
    return [(number, b"") for number in range(count)]


def sent(buffer: TransmitBuffer, made: list[Frame]) -> list[int]:
    return [can_id for can_id, _ in buffer.step(made)]


def test_the_pieces_of_a_label_arrive_as_observed() -> None:
    bench = Bench("dc4 1.11")
    bench.give((0x703, b"\x0c"))
    answers = bench.tick()
    assert [can_id for can_id, _ in answers] == [0x730] * 8
    assert [data[1] for _, data in answers] == [0, 1, 3, 4, 5, 6, 7, 2]


def test_a_strict_board_keeps_the_order() -> None:
    spec = replace(SPECS["dc4 1.11"], faithful=False)
    bench = Bench("", spec)
    bench.give((0x703, b"\x0c"))
    assert [data[1] for _, data in bench.tick()] == list(range(8))


def test_three_frames_keep_their_order() -> None:
    assert sent(TransmitBuffer(), frames(3)) == [0, 1, 2]
    assert sent(TransmitBuffer(), frames(4)) == [0, 1, 3, 2]


def test_what_does_not_fit_a_millisecond_leaves_in_the_next() -> None:
    buffer = TransmitBuffer()
    assert sent(buffer, frames(12)) == [0, 1, 3, 4, 5, 6, 7, 8, 9]
    assert sent(buffer, []) == [10, 11, 2]
    assert buffer.lost == 0


def test_an_overflow_empties_the_buffer() -> None:
    buffer = TransmitBuffer()
    early = sent(buffer, frames(30))
    assert early == [0, 1, 3, 4, 5, 6, 7, 8, 9]
    assert buffer.lost == 10
    assert sent(buffer, []) == [10, 11, 29, 28, 27, 26, 25, 24, 23]
    assert sent(buffer, []) == [22, 21]
    assert sent(buffer, []) == []


def test_an_overflow_is_told_in_the_status() -> None:
    bench = Bench("bll_ie").configure(mask=STATUS.mask_bit)
    bench.tick(10)
    for _ in range(30):
        bench.send(motor.GET_CONTROL_MODE)
    told = bench.statuses(20)
    assert CanStatus.TX_OVERRUN in [status[4] for status in told]
    assert bench.board.dropped["transmit"] == 10
