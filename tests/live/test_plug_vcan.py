"""Plugging a board into a SocketCAN interface, from a process of its own."""

import pytest

from hal.buses.socketcan import interfaces_up
from tests.live.plugging import board_run, plug_pull_and_plug_back

INTERFACE = "vcan2"

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(
        not interfaces_up([INTERFACE]), reason=f"{INTERFACE} is not up on this kernel"
    ),
]


def test_a_board_is_plugged_pulled_and_plugged_back_over_vcan() -> None:
    plug_pull_and_plug_back("socketcan")


def test_a_board_needs_no_stack_on_vcan() -> None:
    with board_run("--seconds", "1", "--status") as board:
        board.until("r_shoulder: bll_ie, firmware 2.50")
        board.until("silent, r_shoulder_pitch idle")
        board.until("unplugged after 1.0 s")
        assert board.ended() == 0
