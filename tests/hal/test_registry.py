"""Host sides of boards by name."""

from importlib.metadata import EntryPoint

import pytest

from hal import registry
from hal.boards.bll_ie import BllIe
from hal.boards.strain import Strain
from hal.errors import DescriptionError
from hal.registry import BOARDS, board_type


def test_finds_every_board_of_the_table() -> None:
    for name in BOARDS:
        assert board_type(name).addresses in (1, 2)
    assert board_type("bll_ie") is BllIe


def test_lists_the_known_types() -> None:
    with pytest.raises(
        DescriptionError, match="unknown board type 'ems5'; known: bll, bll_dc, bll_ie, dc4"
    ):
        board_type("ems5")


def test_finds_an_out_of_tree_board(monkeypatch: pytest.MonkeyPatch) -> None:
    def installed(group: str) -> list[EntryPoint]:
        return [EntryPoint("strain9", "hal.boards.strain:Strain", group)]

    monkeypatch.setattr(registry, "entry_points", installed)

    assert board_type("strain9") is Strain
