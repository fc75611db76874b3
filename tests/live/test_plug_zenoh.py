"""Plugging a board into the CAN over Zenoh of a running stack, from a process of its own."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.live.plugging import PATIENCE_S, ROOT, Bench, board_run, plug_pull_and_plug_back

pytestmark = pytest.mark.live


def test_a_board_is_plugged_pulled_and_plugged_back_over_zenoh(tmp_path: Path) -> None:
    plug_pull_and_plug_back("zenoh", tmp_path)


def test_a_board_whose_address_is_taken_is_refused(tmp_path: Path) -> None:
    with Bench("zenoh", tmp_path) as bench, board_run() as first:
        first.until("streams started")
        bench.until("restarted", "needs calibration")
        with board_run() as second:
            second.until("ulna: somebody else sends as address 5 on bus 0")
            assert second.ended() == 2
        assert first.stop() == 0


def test_a_board_ends_with_its_stack(tmp_path: Path) -> None:
    bench = Bench("zenoh", tmp_path)
    with bench.stack, board_run() as board:
        board.until("streams started")
        bench.stack.stop()
        board.until("unplugged: the stack has ended")
        assert board.ended() == 1


def test_without_a_stack_and_an_interface_it_says_what_to_do() -> None:
    command = [sys.executable, "-m", "services.cli.main", "board", "run", "--address", "1"]
    command += ["--bus", "right_arm", "--channel", "nocan0"]
    done = subprocess.run(
        command, cwd=ROOT, check=False, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert done.returncode == 2
    assert "nocan0 is not up on this machine" in done.stderr
    assert "no stack 'icub' is up" in done.stderr
