"""Plugging a board into a SocketCAN interface, from a process of its own."""

import os
import signal
from pathlib import Path

import pytest

from hal.buses.socketcan import interfaces_up
from tests.live.plugging import BOARD, JOINT, PATIENCE_S, board_run, plug_pull_and_plug_back
from tests.services.mixed import Mixed, without

HERE = interfaces_up(["vcan0"])
BACK = ("restarted", "needs calibration")
LIMIT_MS = round(PATIENCE_S * 1000)

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(not HERE, reason="vcan0 is not up on this kernel"),
]


@pytest.mark.skipif(os.cpu_count() == 1, reason="a process for each service needs two cores")
def test_a_board_is_plugged_pulled_and_plugged_back_into_a_stack_over_vcan(tmp_path: Path) -> None:
    plug_pull_and_plug_back("socketcan", tmp_path)


def test_a_board_is_plugged_pulled_and_plugged_back_over_vcan() -> None:
    robot = Mixed(without("icub:torso", BOARD), on_vcan=True)
    robot.open()
    assert robot.report(BOARD).state == "missing"
    for number in (signal.SIGTERM, signal.SIGINT):
        with board_run("--type", "bll") as board:
            robot.until(lambda: robot.report(BOARD).state in BACK, LIMIT_MS)
            robot.ask("calibrate", (JOINT,))
            os.kill(board.pid, number)
            robot.until(lambda: robot.report(BOARD).state == "silent", LIMIT_MS)
            assert board.ended() == 0
        assert f"{JOINT}: calibrated" in board.lines
        assert board.lines[-1].startswith("unplugged after ")
    robot.close()


def test_a_board_needs_no_stack_on_vcan() -> None:
    with board_run("--seconds", "1", "--status") as board:
        board.until("torso_yaw: bll_ie, firmware 2.54")
        board.until("silent, torso_yaw idle")
        board.until("unplugged after 1.0 s")
        assert board.ended() == 0
