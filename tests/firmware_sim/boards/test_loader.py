"""The boot loader's handshake (can-protocol 8 and worked example 4)."""

import pytest

from firmware_sim.boards.loader import PATIENCE_MS
from hal.wire import motor
from hal.wire.modes import ControlMode
from tests.firmware_sim.boards.bench import Bench

BOARD = b"\x00\x00"


@pytest.fixture
def bench() -> Bench:
    bench = Bench("bll_ie 2.51").ready(mask=0x37)
    bench.tick(20)
    bench.give((0x706, BOARD))
    assert bench.tick() == [(0x760, b"\x00\x01")]
    return bench


def test_board_stops_the_application_and_is_answered_by_the_loader(bench: Bench) -> None:
    assert not any(port.enabled for port in bench.board.ports)
    bench.send(motor.GET_CONTROL_MODE)
    assert bench.tick(100) == []
    assert bench.board.dropped["loader"] == 1


def test_discovery_in_the_loader_is_answered_with_four_bytes(bench: Bench) -> None:
    bench.give((0x70F, b"\xff"))
    ((can_id, data),) = bench.tick()
    assert can_id == 0x760
    assert data[:2] == b"\xff\x00"  # a generic DSP
    assert len(data) == 4


def test_the_loader_leaves_by_itself_after_five_seconds(bench: Bench) -> None:
    bench.tick(PATIENCE_MS - 2)
    bench.give((0x706, b"\xff"))
    assert len(bench.tick()[0][1]) == 4
    bench.tick()
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.IDLE,)
    assert bench.ask(motor.GET_CALIBRATION_STATUS) == (0, 0, 0)  # it booted


def test_a_second_board_command_makes_it_stay(bench: Bench) -> None:
    bench.give((0x706, BOARD))
    assert bench.tick() == [(0x760, b"\x00\x01")]
    bench.tick(PATIENCE_MS + 10)
    bench.give((0x706, b"\xff"))
    assert len(bench.tick()[0][1]) == 4


def test_a_line_is_acknowledged_when_it_is_complete(bench: Bench) -> None:
    for line in (
        "01100002000000",
        "03cfbb200080f0",
        "03200000018800",
    ):
        bench.give((0x70F, bytes.fromhex(line)))
        assert bench.tick() == []
    bench.give((0x70F, bytes.fromhex("0300000000")))
    assert bench.tick() == [(0x760, b"\x03\x01")]


def test_start_and_end_are_acknowledged_and_the_application_starts(bench: Bench) -> None:
    bench.give((0x706, bytes.fromhex("0200000000")))
    assert bench.tick() == [(0x760, b"\x02\x01")]
    bench.give((0x706, b"\x04"))
    assert bench.tick() == [(0x760, b"\x04\x01")]
    assert bench.ask(motor.GET_CONTROL_MODE) == (ControlMode.IDLE,)
    assert bench.tick(100) == []  # masks were forgotten


def test_data_without_an_address_are_not_acknowledged(bench: Bench) -> None:
    bench.give((0x706, bytes.fromhex("03000000")))
    assert bench.tick() == []


@pytest.mark.parametrize("code", [5, 0x0C, 0x32])
def test_other_commands_are_dropped_and_counted(bench: Bench, code: int) -> None:
    bench.give((0x706, bytes((code,))))
    assert bench.tick() == []
    assert bench.board.dropped["management"] == 1
