"""A live stack that lacks one board, and `ulna board run` as a process of its own."""

import os
import queue
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from services.config import robots_folder
from services.core.clock import NS_PER_S, RealClock
from services.processes import HUB, PROCESSES
from services.robot_messages import BoardStatus, RobotRequest
from services.stack import Stack
from services.stack_choice import Can
from services.streams import ROBOT_CALL, ROBOT_STATUS

ROOT = Path(__file__).resolve().parents[2]
SITE = "[boards]\ntorso_yaw = { simulated = false }\n"
BOARD, JOINT = "torso_yaw", "torso_yaw"
NEEDED = ("boards", "robot")
NOT_YET = "not asked yet"  # the HAL's word before its first handshake
PATIENCE_S = 150.0  # one slow core that others use too, and code not yet compiled


class Bench:
    """The stack, and what its HAL says of the board that is plugged in."""

    def __init__(self, can: Can, folder: Path) -> None:
        """A torso, two boards on one bus, without one of them by a site file in `folder`."""
        robot = shutil.copytree(robots_folder() / "icub", folder / "icub")
        (robot / "sites" / "here.toml").write_text(SITE, "utf-8")
        rows = (HUB, *(row for row in PROCESSES if row.name in NEEDED))
        self.stack = Stack(f"{robot / 'robot.toml'}:torso@here", can=can, rows=rows)
        self._clock = RealClock()

    def __enter__(self) -> "Bench":
        """Return once the HAL has started without the board."""
        self.stack.start()
        assert "does not answer" in self.until("missing").reason
        return self

    def __exit__(self, *_: object) -> None:
        self.stack.stop()

    def report(self) -> BoardStatus | None:
        status = self.stack.client.latest(ROBOT_STATUS)
        boards = () if status is None else status.boards
        return next((board for board in boards if board.name == BOARD), None)

    def until(self, *states: str) -> BoardStatus:
        """Wait for the board to be in one of these states."""
        give_up_ns = self._clock.now_ns() + round(PATIENCE_S * NS_PER_S)
        while True:
            report = self.report()
            if report is not None and report.state in states and report.reason != NOT_YET:
                return report
            assert self._clock.now_ns() < give_up_ns, f"waited for {states}, it is {report}"
            self.stack.check()
            self._clock.sleep_until(self._clock.now_ns() + 20_000_000)

    def ask(self, request: RobotRequest) -> None:
        """A request to the HAL that ends well."""
        client = self.stack.client
        reply = client.call(ROBOT_CALL, request)
        assert reply.ok, reply.reason
        give_up_ns = self._clock.now_ns() + round(PATIENCE_S * NS_PER_S)
        while True:
            status = client.latest(ROBOT_STATUS)
            if status is not None and status.finished_task >= reply.task:
                assert reply.task not in dict(status.failed_tasks), status.failed_tasks
                return
            assert self._clock.now_ns() < give_up_ns, f"waited for {request}"
            self._clock.sleep_until(self._clock.now_ns() + 20_000_000)


class BoardRun:
    """`ulna board run` and the lines that it has printed."""

    def __init__(self, *options: str) -> None:
        command = [sys.executable, "-m", "services.cli.main", "board", "run", *options]
        self._process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.pid = self._process.pid
        self.lines: list[str] = []
        self._queue: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stdout:
            for line in stdout:
                self._queue.put(line.rstrip())

    def until(self, beginning: str) -> None:
        """Wait for a line that begins like this."""
        while not any(line.startswith(beginning) for line in self.lines):
            try:
                self.lines.append(self._queue.get(timeout=PATIENCE_S))
            except queue.Empty:
                raise AssertionError(f"no line {beginning!r} in {self.lines}") from None

    def stop(self, number: signal.Signals = signal.SIGINT) -> int:
        """Unplug it; the exit status."""
        if self._process.poll() is None:
            os.kill(self.pid, number)
        return self.ended()

    def ended(self) -> int:
        """Wait until it ends by itself; the exit status."""
        status = self._process.wait(timeout=PATIENCE_S)
        self._reader.join(timeout=PATIENCE_S)
        while not self._queue.empty():
            self.lines.append(self._queue.get())
        return status


@contextmanager
def board_run(*options: str) -> Iterator[BoardRun]:
    """The process, which does not outlive the test."""
    run = BoardRun("--bus", "vcan0", "--address", "5", "--robot", "icub", *options)
    try:
        yield run
    finally:
        run.stop(signal.SIGKILL)


def plug_pull_and_plug_back(can: Can, folder: Path) -> None:
    """What must be true of a board that comes, goes and comes back, over any transport."""
    with Bench(can, folder) as bench:
        with board_run("--type", "bll") as board:
            board.until("streams started")
            bench.until("restarted", "needs calibration")
            bench.ask(RobotRequest(action="calibrate", joints=(JOINT,)))
            bench.until("ok")
            board.until(f"{JOINT}: calibrated")
            assert board.stop(signal.SIGTERM) == 0
            assert board.lines[-1].startswith("unplugged after ")
        assert bench.until("silent").reason == "no POSITION"
        with board_run() as board:
            board.until("streams started")
            bench.until("restarted", "needs calibration")
            assert board.stop(signal.SIGINT) == 0
