"""Boards and HAL of torso and both arms live: frames lost, and ticks late beside an empty loop.

    python -m benchmarks.can_live [--json FILE] [--seconds S] [--can socketcan|zenoh]

Over vcan where it is up, else inside a guest kernel that has it, else over Zenoh. Hub, boards and
robot are processes of their own, as `ulna up` starts them; the arms swing while it is measured.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.rows import Row, at_least, at_most, publish
from hal.buses.socketcan import interfaces_up
from services.cli.up import Can, Stack
from services.config import load_robot
from services.core.clock import NS_PER_S, RealClock
from services.core.errors import NotReadyError
from services.messages import PlantTruth, RobotRequest, RobotStatus, ServiceStats
from services.processes import HUB, PROCESSES
from services.streams import PLANT_TRUTH, ROBOT_CALL, ROBOT_STATUS, STATS
from services.wiring import joint_limits_deg

ROOT = Path(__file__).resolve().parent.parent
GUEST = ROOT.parent / "shared" / "tools" / "run-with-vcan"
ROBOT = "icub:arms"
NEEDED = ("boards", "robot")
TIMES_EMPTY_LOOP = 3.0
SETTLE_S = 3.0  # of the statistics, once a second
START_S = 120.0
SWING_RAD = 0.05
SWING_S = 2.0
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
        return measured("vcan", "socketcan", seconds)
    rows = in_guest(seconds) if can is None and GUEST.exists() else []
    return rows if len(rows) > 1 else rows + measured("Zenoh", "zenoh", seconds)


def in_guest(seconds: float) -> list[Row]:
    """The same inside a guest kernel that has vcan; a row that says so where it gave no result."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "rows.json"
        command = [str(GUEST), "-t", str(round(seconds) + GUEST_EXTRA_S), "--", sys.executable]
        command += ["-m", "benchmarks.can_live", "--can", "socketcan"]
        command += ["--seconds", str(seconds), "--json", str(result)]
        done = subprocess.run(
            command, cwd=ROOT, check=False, stdout=sys.stderr, stderr=subprocess.PIPE, text=True
        )
        if not result.exists():
            why = done.stderr.strip().rpartition("\n")[2] or f"exit status {done.returncode}"
            return [Row("vcan in a guest kernel", f"no result: {why}")]
        rows = json.loads(result.read_text(encoding="utf-8"))["rows"]
    return [Row(**{**row, "name": f"guest kernel, one CPU, {row['name']}"}) for row in rows]


def measured(name: str, can: Can, seconds: float) -> list[Row]:
    """One run."""
    rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))
    with Stack(ROBOT, can=can, name="can-live", rows=rows) as stack:
        run = Run(stack)
        run.calibrate()
        run.rest(SETTLE_S)
        before = run.latest_status(), run.latest_truth()
        slips = {row: run.stats(row).tick_slips for row in NEEDED}
        empty = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.empty_loop"], cwd=ROOT, stdout=subprocess.PIPE
        )
        try:
            run.swing(seconds)
        finally:
            empty.terminate()
            said = empty.communicate()[0]
        after = run.latest_status(), run.latest_truth()
        run.rest(SETTLE_S)
        stats = {row: run.stats(row) for row in NEEDED}
    slips = {row: each.tick_slips - slips[row] for row, each in stats.items()}
    where = f"{name}, torso and arms"
    return rows_of(where, seconds, before, after, stats, slips, json.loads(said))


Sides = tuple[RobotStatus, PlantTruth]


def rows_of(
    name: str,
    seconds: float,
    before: Sides,
    after: Sides,
    stats: dict[str, ServiceStats],
    slips: dict[str, int],
    empty: dict[str, object],
) -> list[Row]:
    """Figures of one run; `before` and `after` are what HAL and boards had counted.

    The lateness of a process is that since its start, with the configuration of all boards in it.
    """
    hal, boards = after[0], after[1]
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


class Run:
    """A running stack, and what it is told to do."""

    def __init__(self, stack: Stack) -> None:
        self._client = stack.client
        self._check = stack.check
        self._clock = RealClock()
        self._robot = load_robot(ROBOT)
        for stream in (PLANT_TRUTH, ROBOT_STATUS, *(STATS[process] for process in NEEDED)):
            self._client.watch(stream)

    def calibrate(self) -> None:
        """Wait for the HAL's start-up, then calibrate every axis."""
        self._until(lambda status: status.phase in ("idle", "failed"))
        status = self.latest_status()
        if status.phase == "failed":
            raise NotReadyError(f"the robot has failed: {status.faults[-1]}")
        self._finish(self._ask(RobotRequest(action="calibrate")))
        self._finish(self._move(0.0))

    def swing(self, seconds: float) -> None:
        """Move every joint to and fro about where the robot is parked."""
        end_ns = self._clock.now_ns() + round(seconds * NS_PER_S)
        away = SWING_RAD
        while self._clock.now_ns() < end_ns:
            self._move(away)
            away = -away
            left_s = (end_ns - self._clock.now_ns()) / NS_PER_S
            self.rest(min(SWING_S, max(left_s, 0.0)))

    def _move(self, away_rad: float) -> int:
        robot = self._robot
        goal: dict[str, float] = {}
        for names in robot.parts.values():
            for name in names:
                low, high = np.radians(joint_limits_deg(robot, name))
                room = 2 * SWING_RAD  # the limits keep a margin
                parked = math.radians(robot.joints[name].park_deg)
                goal[name] = min(max(parked, low + room), high - room) + away_rad
        joints, q_rad = tuple(goal), tuple(float(angle) for angle in goal.values())
        return self._ask(
            RobotRequest(action="move", joints=joints, q_rad=q_rad, duration_s=SWING_S / 2)
        )

    def rest(self, seconds: float) -> None:
        """Let time pass; what arrives meanwhile is read, now and then."""
        end_ns = self._clock.now_ns() + round(seconds * NS_PER_S)
        while self._clock.now_ns() < end_ns:
            self._clock.sleep_until(min(end_ns, self._clock.now_ns() + NS_PER_S // 4))
            self._check()
            self._client.new(ROBOT_STATUS)
            self._client.new(PLANT_TRUTH)

    def latest_status(self) -> RobotStatus:
        """What the HAL has counted."""
        status = self._client.latest(ROBOT_STATUS)
        if status is None:
            raise NotReadyError("the HAL has said nothing")
        return status

    def latest_truth(self) -> PlantTruth:
        """What the boards have counted."""
        truth = self._client.latest(PLANT_TRUTH)
        if truth is None:
            raise NotReadyError("the boards have said nothing")
        return truth

    def stats(self, process: str) -> ServiceStats:
        """How a process has kept its time since its start."""
        stats = self._client.latest(STATS[process])
        if stats is None:
            raise NotReadyError(f"{process} has said nothing")
        return stats

    def _ask(self, request: RobotRequest) -> int:
        """Hand a request to the HAL; the number of its task."""
        reply = self._client.call(ROBOT_CALL, request)
        if not reply.ok:
            raise NotReadyError(f"{request.action}: {reply.reason}")
        return reply.task

    def _finish(self, task: int) -> None:
        self._until(lambda status: status.finished_task >= task)
        failed = dict(self.latest_status().failed_tasks)
        if task in failed:
            raise NotReadyError(failed[task])

    def _until(self, done: Callable[[RobotStatus], bool]) -> None:
        give_up_ns = self._clock.now_ns() + round(START_S * NS_PER_S)
        while True:
            self.rest(0.25)
            status = self._client.latest(ROBOT_STATUS)
            if status is not None and done(status):
                return
            if self._clock.now_ns() > give_up_ns:
                raise NotReadyError(f"not within {START_S:g} s: {status}")


if __name__ == "__main__":
    raise SystemExit(main())
