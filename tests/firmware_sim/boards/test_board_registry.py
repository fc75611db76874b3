"""Boards by name."""

from importlib.metadata import EntryPoint

import pytest

from firmware_sim import registry
from firmware_sim.boards.board import Board, BoardError
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.boards.strain import Strain
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from tests.firmware_sim.boards.bench import SPECS

STRAIN = BoardSpec(bus=2, address=13, type="strain", firmware=(3, 0))


def test_makes_each_type_at_its_address() -> None:
    for spec in SPECS.values():
        board = make_board(spec)
        assert board.addresses[0] == spec.address
    sensor = make_board(STRAIN, (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0))
    assert sensor.addresses == (13,)
    assert len(sensor.raw_adc) == 6


def test_both_kinds_satisfy_the_interface() -> None:
    boards: list[type[Board]] = [MotorBoard, Strain]
    assert len(boards) == 2


def test_an_out_of_tree_board_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("mine", "firmware_sim.boards.bll_ie:BllIe", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "entry_points", lambda group: [point] * (group == point.group))
    board = make_board(BoardSpec(bus=0, address=2, type="mine", firmware=(2, 0x57)))
    assert board.addresses == (2,)


def test_an_unknown_type_is_refused_with_the_known_ones() -> None:
    spec = BoardSpec(bus=0, address=1, type="ems5", firmware=(1, 0))
    with pytest.raises(
        BoardError, match="unknown board type 'ems5'; known: bll, bll_dc, bll_ie, dc4, "
    ):
        make_board(spec)


def test_a_sensor_board_needs_its_full_scales() -> None:
    with pytest.raises(BoardError, match="strain at bus 2 address 13 has no sensor"):
        make_board(STRAIN)
