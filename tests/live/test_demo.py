"""The main job on a live stack: every process of its own, CAN over Zenoh or over vcan."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hal.buses.socketcan import interfaces_up
from services.config import load_robot
from services.core.rundir import running
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_live import run_live
from services.stack import Stack

pytestmark = pytest.mark.live

ROOT = Path(__file__).resolve().parents[2]
INTERFACES = tuple(bus.channel for bus in load_robot("icub:reach").buses.values())


def demo(folder: Path, *options: str) -> None:
    """One `ulna demo reach`, and what must be true of it whatever the machine's speed."""
    report_file = folder / "report.json"
    command = [sys.executable, "-m", "services.cli.main", "demo", "reach", *options]
    command += ["--json", str(report_file), "--plot", str(folder / "reach.png")]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    report = json.loads(report_file.read_text(encoding="utf-8"))
    assert report["failure"] == ""
    assert report["reached"], done.stdout
    assert report["position_error_mm"] <= 5.0
    assert report["frames_lost"] == 0
    assert report["board_faults"] == 0
    assert report["limit_violations"] == 0
    assert report["joints_not_held_to_limits"] == []
    assert done.returncode == 0
    assert (folder / "reach.png").stat().st_size > 10_000
    assert running() == ()


def test_demo_reaches_over_zenoh(tmp_path: Path) -> None:
    demo(tmp_path, "--can", "zenoh")


@pytest.mark.skipif(
    not interfaces_up(INTERFACES), reason=f"{', '.join(INTERFACES)} are not up on this kernel"
)
def test_demo_reaches_over_vcan_in_one_process(tmp_path: Path) -> None:
    demo(tmp_path, "--can", "socketcan", "--one-process")


@pytest.mark.skipif(
    not interfaces_up(INTERFACES) or os.cpu_count() == 1,
    reason=f"{', '.join(INTERFACES)} are not up on this kernel, or it has one core only",
)
def test_demo_reaches_over_vcan(tmp_path: Path) -> None:
    demo(tmp_path, "--can", "socketcan")


def test_demo_without_its_interfaces_says_what_to_do(tmp_path: Path) -> None:
    if interfaces_up(INTERFACES):
        pytest.skip("the interfaces are up here")
    command = [sys.executable, "-m", "services.cli.main", "demo", "reach", "--can", "socketcan"]
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert INTERFACES[0] in done.stderr
    assert "--can zenoh" in done.stderr


def test_a_dead_process_is_named_while_the_arm_holds() -> None:
    killed: list[tuple[float, float, float]] = []

    def kill(stack: Stack, job: Reach) -> None:
        if job.progress == "holding" and not killed and job.recording.truth is not None:
            killed.append(job.recording.truth.tip_position_m)
            os.kill(stack.pids["dynamics"], signal.SIGKILL)

    options = ReachOptions(hold_s=30.0, position_bar_m=0.005)
    report = run_live("icub:reach", options, "zenoh", lambda _s, _w: None, lambda _text: None, kill)
    assert killed
    assert "'dynamics'" in str(report.report["failure"])
    assert "SIGKILL" in str(report.report["failure"])
    away = [abs(a - b) for a, b in zip(killed[0], report.recording.trace.tip_m[-1], strict=True)]
    assert max(away) < 0.01
    assert running() == ()
