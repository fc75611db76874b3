"""Pulls each board of the whole robot out and plugs it back in, while the robot holds its posture.

    python -m benchmarks.can_plug [--json FILE] [--short]

Each board loses its power for a while. How soon that is reported, whether all others go on as
before, and whether the board comes back without a restart: handshake, configured, sending, axes
idle and in need of calibration. `--short` takes one board of each type.
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.quiet import quiet
from benchmarks.sniffer import Sniffer
from benchmarks.whole_robot import WholeRobot
from firmware_sim.switch_table import FaultSpec
from hal.couplings import needed_boards
from hal.description import Board
from hal.faults import Fault
from hal.wire.modes import ControlMode
from services.experiments.rows import Row, at_most, publish

WATCHED_MS = 400  # undisturbed, to know the longest gap of every stream
PULLED_MS = 400
BACK_MS = 3000
MS = 1_000_000
BARS_MS = {"mtb": 140.0, "mais": 110.0, "imu": 110.0}
"""Silence until it is reported, by the period: skin 40 ms (three pass), 10 ms; else BAR_MS."""
BAR_MS = 100.0


@dataclass
class Outcome:
    """What happened when one board was pulled and plugged back."""

    board: Board
    reported_ms: float = float("inf")  # of silence, when it was reported
    back_ms: float = float("inf")  # after it was plugged in
    interrupted: list[str] = field(default_factory=list)  # boards whose streams had a gap
    changed: list[str] = field(default_factory=list)  # joints that it is no business of
    wrong: list[str] = field(default_factory=list)  # of its state once it is back


class Plugger:
    """The whole robot, calibrated and holding; `pull` any of its boards."""

    def __init__(self, reference: str) -> None:
        self.robot = WholeRobot(reference)
        self.robot.calibrated()
        self._hal = self.robot.hal
        self.boards = self._hal.description.boards
        self._names = self._hal.joints.names
        addresses = {
            (board.bus, address): board.name
            for board in self.boards
            for address in self.robot.rig.board(board.bus, board.address).addresses
        }
        self._sniffer = Sniffer(self.robot, addresses)
        self._pass(WATCHED_MS)
        self._usual_ms = self._sniffer.take()

    def pull(self, board: Board) -> Outcome:
        """Take the power away, give it back, look, and make the robot whole again."""
        outcome = Outcome(board)
        spec = FaultSpec(kind="no_power", bus=board.bus, address=board.address)
        concerned = self._concerned(board)
        states = self._states()
        count = self._hal.status().fault_count
        self._sniffer.take()
        self.robot.rig.switches.switch_on(spec)
        last_ns = self._sniffer.heard_ns[board.name]
        self._pass(PULLED_MS)
        prefix = f"board {board.name} (bus {board.bus}, address {board.address}) silent"
        for event in self._events(count):
            if event.text.startswith(prefix):
                outcome.reported_ms = (event.stamp_ns - last_ns) / MS
        self.robot.rig.switches.switch_off(spec)
        for passed in range(BACK_MS):
            if self._state(board) != "silent":
                outcome.back_ms = passed
                break
            self._pass(1)
        self._pass(100)
        outcome.interrupted = self._gaps(board)
        after = self._states()
        outcome.changed = [n for n in self._names if n not in concerned and after[n] != states[n]]
        outcome.wrong = self._wrong(board)
        self._restore(outcome)
        return outcome

    def close(self) -> None:
        """Leave the buses."""
        self._sniffer.close()
        self.robot.close()

    def _pass(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self.robot.tick()
            self._sniffer.look()

    def _events(self, count: int) -> Sequence[Fault]:
        new = self._hal.status().fault_count - count
        return self._hal.fault_events[-new:] if new else ()

    def _gaps(self, board: Board) -> list[str]:
        found = self._sniffer.take()
        return [
            f"{name} {gap_ms:g} ms"
            for name, gap_ms in found.items()
            if name != board.name and gap_ms > self._usual_ms[name]
        ]

    def _concerned(self, board: Board) -> set[str]:
        """Joints of the board, and of boards that fault without it."""
        boards = {board.name} | {
            other.name for other in self.boards if board in needed_boards(other, self.boards)
        }
        return {name for one in self.boards if one.name in boards for name in self._joints(one)}

    def _joints(self, board: Board) -> list[str]:
        addresses = self.robot.rig.board(board.bus, board.address).addresses
        return [
            joint.name
            for joint in self._hal.description.joints
            if joint.bus == board.bus and joint.address in addresses
        ]

    def _states(self) -> dict[str, tuple[int, bool, str]]:
        joints = self._hal.joints
        rows = zip(joints.control_mode, joints.calibrated, joints.fault, strict=True)
        return dict(zip(self._names, rows, strict=True))

    def _state(self, board: Board) -> str:
        (report,) = [one for one in self._hal.status().boards if one.name == board.name]
        return report.state

    def _wrong(self, board: Board) -> list[str]:
        """What is not as it should be: motor boards idle and uncalibrated, sensors at work."""
        joints = self._joints(board)
        states = self._states()
        expected = (ControlMode.IDLE, False, "")
        wrong = [f"{name} {states[name]}" for name in joints if states[name] != expected]
        state = self._state(board)
        if state not in (("restarted", "needs calibration") if joints else ("ok", "restarted")):
            wrong.append(f"state {state}")
        if self._sniffer.heard_ns[board.name] < self.robot.now_ns - 100 * MS:
            wrong.append("sends nothing")
        return wrong

    def _restore(self, outcome: Outcome) -> None:
        """What a user would ask for: out of faults, calibrated, holding."""
        off = [n for n, (mode, *_) in self._states().items() if mode != ControlMode.POSITION]
        lost = [name for name in off if not self._states()[name][1]]
        steps = (("mode", off, "idle"), ("calibrate", lost, ""), ("mode", off, "position"))
        for action, joints, value in steps:
            if joints:
                task = self._hal.request(action, tuple(joints), value)
                self.robot.until(lambda: task.done, 60_000)  # noqa: B023  (run at once)
                outcome.wrong += [] if task.ok else [f"{action}: {task.reason}"]
        self._pass(WATCHED_MS // 4)


def plug_rows(*, short: bool = False, reference: str = "icub") -> list[Row]:
    """Every board of the robot in turn, or one of each type."""
    with quiet():
        plugger = Plugger(reference)
        try:
            boards = one_of_each(plugger.boards) if short else plugger.boards
            outcomes = [plugger.pull(board) for board in boards]
        finally:
            plugger.close()
    return rows_of(outcomes)


def one_of_each(boards: Iterable[Board]) -> list[Board]:
    """The first board of each type."""
    return list({board.type: board for board in reversed(tuple(boards))}.values())


def rows_of(outcomes: Sequence[Outcome]) -> list[Row]:
    """What the outcomes come to."""
    rows = [Row("boards pulled and plugged back", len(outcomes))]
    for kind in sorted({outcome.board.type for outcome in outcomes}):
        these = [outcome for outcome in outcomes if outcome.board.type == kind]
        slowest = max(outcome.reported_ms for outcome in these)
        name = f"{kind} ({len(these)}): silence when it was reported"
        rows.append(at_most(name, slowest, "ms", BARS_MS.get(kind, BAR_MS)))
        rows.append(Row(f"{kind}: slowest return", max(outcome.back_ms for outcome in these), "ms"))
    for what, found in (
        ("streams of other boards interrupted", _named(outcomes, "interrupted")),
        ("joints of other boards changed", _named(outcomes, "changed")),
        ("boards not back, configured, sending, idle", _named(outcomes, "wrong")),
    ):
        rows.append(Row(what, found or "none", "", "none", not found))
    return rows


def _named(outcomes: Iterable[Outcome], attribute: str) -> str:
    return "; ".join(
        f"{outcome.board.name}: {', '.join(getattr(outcome, attribute))}"
        for outcome in outcomes
        if getattr(outcome, attribute)
    )


def main() -> int:
    """All boards, or one of each type."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--short", action="store_true", help="one board of each type")
    arguments = parser.parse_args()
    print("starting the whole robot ...", file=sys.stderr, flush=True)
    rows = plug_rows(short=arguments.short)
    return publish("boards pulled and plugged back", rows, arguments.json)


if __name__ == "__main__":
    raise SystemExit(main())
