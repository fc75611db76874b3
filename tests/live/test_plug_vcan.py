"""Plugging a board into a SocketCAN interface, from a process of its own."""

from pathlib import Path

import pytest

from hal.buses.socketcan import interfaces_up
from tests.live.plugging import board_run, plug_pull_and_plug_back

INTERFACE = "vcan0"

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(
        not interfaces_up([INTERFACE]), reason=f"{INTERFACE} is not up on this kernel"
    ),
]


def test_a_board_is_plugged_pulled_and_plugged_back_over_vcan(tmp_path: Path) -> None:
    plug_pull_and_plug_back("socketcan", tmp_path)


def test_a_board_needs_no_stack_on_vcan() -> None:
    with board_run("--seconds", "1", "--status") as board:
        board.until("torso_yaw: bll_ie, firmware 2.54")
        board.until("silent, torso_yaw idle")
        board.until("unplugged after 1.0 s")
        assert board.ended() == 0
