"""Boards and HAL of torso and both arms live: frames lost, and ticks late beside an empty loop.

    python -m benchmarks.can_live [--json FILE] [--seconds S] [--can socketcan|zenoh]

Over vcan where it is up, else inside a guest kernel that has it, else over Zenoh. Hub, boards and
robot are processes of their own, as `ulna up` starts them, where there is more than one CPU; the
arms swing while it is measured.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.can_live_run import PROCESSES as NEEDED
from benchmarks.can_live_run import OneProcessRun, Run, StackRun
from hal.buses.socketcan import interfaces_up
from services.config import load_robot
from services.emulated.messages import PlantTruth
from services.experiments.rows import Row, at_least, at_most, publish
from services.messages import ServiceStats
from services.processes import HUB, PROCESSES
from services.robot_messages import RobotStatus
from services.stack import Stack
from services.stack_choice import Can

ROOT = Path(__file__).resolve().parent.parent
GUEST = ROOT.parent / "shared" / "tools" / "run-with-vcan"
ROBOT = "icub:arms"
TIMES_EMPTY_LOOP = 3.0
SETTLE_S = 3.0  # of the statistics, once a second
GUEST_EXTRA_S = 400


def main() -> int:
    """Measure and publish."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--can", choices=("socketcan", "zenoh"), default=None)
    arguments = parser.parse_args()
    rows = live_rows(arguments.seconds, arguments.can)
    return publish("boards and HAL, live", rows, arguments.json)


def live_rows(seconds: float = 60.0, can: Can | None = None) -> list[Row]:
    """Rows over the best transport of this machine, or over the one asked for."""
    interfaces = tuple(bus.channel for bus in load_robot(ROBOT).buses.values())
    if can == "socketcan" or (can is None and interfaces_up(interfaces)):
        if os.cpu_count() == 1:
            return in_one_process(seconds)
        return measured("vcan", "socketcan", seconds)
    rows = in_guest(seconds) if can is None and GUEST.exists() else []
    return rows if len(rows) > 1 else rows + measured("Zenoh", "zenoh", seconds)


def in_guest(seconds: float) -> list[Row]:
    """The same inside a guest kernel that has vcan; a row that says so where it gave no result."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "rows.json"
        # Its processes can have no more of the machine than the guest has.
        command = [
            "nice",
            "-n",
            "-20",
            str(GUEST),
            "-t",
            str(round(seconds) + GUEST_EXTRA_S),
            "--",
            sys.executable,
        ]
        command += ["-m", "benchmarks.can_live", "--can", "socketcan"]
        command += ["--seconds", str(seconds), "--json", str(result)]
        done = subprocess.run(
            command, cwd=ROOT, check=False, stdout=sys.stderr, stderr=subprocess.PIPE, text=True
        )
        if not result.exists():
            why = done.stderr.strip().rpartition("\n")[2] or f"exit status {done.returncode}"
            return [Row("vcan in a guest kernel", f"no result: {why}")]
        rows = json.loads(result.read_text(encoding="utf-8"))["rows"]
    return [Row(**{**row, "name": f"guest kernel, {row['name']}"}) for row in rows]


def measured(name: str, can: Can, seconds: float) -> list[Row]:
    """One run with a process for the boards and one for the HAL."""
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))
    with Stack(ROBOT, can=can, name="can-live", rows=rows) as stack:
        return swung(f"{name}, torso and arms", StackRun(load_robot(ROBOT), stack), seconds)


def in_one_process(seconds: float) -> list[Row]:
    """One run with boards and HAL in this process, over SocketCAN."""
    run = OneProcessRun(load_robot(ROBOT))
    try:
        return swung("vcan, one process for one CPU, torso and arms", run, seconds)
    finally:
        run.close()


def swung(name: str, run: Run, seconds: float) -> list[Row]:
    """Calibrate, swing for so long beside an empty loop, and count."""
    run.calibrate()
    run.rest(SETTLE_S)
    before, slips_before = run.counted(), slips_of(run)
    empty = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.empty_loop"], cwd=ROOT, stdout=subprocess.PIPE
    )
    try:
        run.swing(seconds)
    finally:
        empty.terminate()
        said = empty.communicate()[0]
    after = run.counted()
    run.rest(SETTLE_S)
    slips = {process: count - slips_before[process] for process, count in slips_of(run).items()}
    return rows_of(name, seconds, (before, after), run.stats(), slips, json.loads(said))


def slips_of(run: Run) -> dict[str, int]:
    """Ticks that each loop has left out since its start."""
    return {process: stats.tick_slips for process, stats in run.stats().items()}


Sides = tuple[RobotStatus, PlantTruth]


def rows_of(
    name: str,
    seconds: float,
    counted: tuple[Sides, Sides],
    stats: dict[str, ServiceStats],
    slips: dict[str, int],
    empty: dict[str, object],
) -> list[Row]:
    """Figures of one run; `counted` is what HAL and boards had counted before and after it.

    The lateness of a process is that since its start, with the configuration of all boards in it.
    """
    before, (hal, boards) = counted
    lost = hal.frames_lost - before[0].frames_lost + boards.frames_lost - before[1].frames_lost
    frames = hal.frames_sent - before[0].frames_sent + boards.frames - before[1].frames
    empty_p99_us = float(str(empty["p99_us"]))
    bar_us = TIMES_EMPTY_LOOP * empty_p99_us
    rows = [
        at_most(f"{name}: frames lost in {seconds:g} s", lost, "", 0),
        at_least(f"{name}: frames", frames / seconds, "1/s", 1.0),
        Row(f"{name}: axes and boards", f"{len(boards.joints)} and {len(hal.boards)}"),
        Row(f"{name}: empty loop, ticks late, median", float(str(empty["p50_us"])), "us"),
        Row(f"{name}: empty loop, ticks late, p99", empty_p99_us, "us"),
    ]
    for process, each in stats.items():
        rows += [
            Row(f"{name}: {process}, ticks late, median", each.late_us_p50, "us"),
            at_most(f"{name}: {process}, ticks late, p99", each.late_us_p99, "us", bar_us),
            Row(f"{name}: {process}, a step, median", each.step_ms_p50, "ms"),
            Row(f"{name}: {process}, a step, p99", each.step_ms_p99, "ms"),
            Row(f"{name}: {process}, ticks left out", float(slips[process])),
            Row(f"{name}: {process}, scheduling", each.scheduler),
        ]
    return rows


if __name__ == "__main__":
    raise SystemExit(main())
