"""Opening the robot: silence the buses, find every board, configure it. It can be repeated.

A board that is not required, or any board of a robot that may start with boards missing, keeps
only its own axes from being used.
"""

from collections.abc import Callable, Iterable

from hal.boards.board import NO_ANSWER, HostBoard, board_name
from hal.machine import Machine
from hal.tasks import Sequence, together

DRAIN_NS = 20_000_000
FIRST_FRAMES_NS = 500_000_000
PATIENCE_NS = 10_000_000_000  # boards, or the process that emulates them, may start after the host
OPTIONAL_PATIENCE_NS = 1_000_000_000

Reasons = dict[str, str]


class Startup:
    """The sequence and the phase it is in: opening, handshake, configuring.

    `unavailable` are the boards that the robot starts without.
    """

    def __init__(self, machine: Machine) -> None:
        self.phase = "opening"
        self.unavailable: list[HostBoard] = []
        self._machine = machine

    def run(self) -> Sequence:
        """Open every bus and board; the reason names what does not fit."""
        machine = self._machine
        yield from self._quiesce()
        self.phase = "handshake"
        reason = yield from self._find_boards()
        if reason:
            return reason
        self.phase = "configuring"
        for work in (_configured, first_frames):
            reasons: Reasons = {}
            there = [board for board in machine.boards if board not in self.unavailable]
            yield from _each(there, work, reasons)
            reason = self._without(there, "wrong" if work is _configured else "silent", reasons)
            if reason:
                return reason
        for board in machine.boards:
            if board not in self.unavailable:
                machine.inventory.note(board, "ok", machine.now_ns)
        return ""

    def is_required(self, board: HostBoard) -> bool:
        """Whether the robot does not start without it."""
        return board.board.required and not self._machine.description.allow_missing

    def _find_boards(self) -> Sequence:
        """Shake hands with every board; those that power up after the host get some time."""
        machine = self._machine
        began_ns = machine.now_ns
        missing = list(machine.boards)
        reasons: Reasons = {}
        while self._worth_waiting(missing, machine.now_ns - began_ns):
            yield from _each(missing, self._shake_hands, reasons)
            wrong = {name: reason for name, reason in reasons.items() if NO_ANSWER not in reason}
            reason = self._without(missing, "wrong", wrong)
            if reason:
                return reason
            missing = [
                board
                for board in missing
                if reasons[board.board.name] and board not in self.unavailable
            ]
        return self._without(missing, "missing", reasons)

    def _worth_waiting(self, missing: list[HostBoard], passed_ns: int) -> bool:
        if any(self.is_required(board) for board in missing):
            return passed_ns < PATIENCE_NS
        return bool(missing) and passed_ns < OPTIONAL_PATIENCE_NS

    def _shake_hands(self, board: HostBoard) -> Sequence:
        inventory = self._machine.inventory
        inventory.ask(board)
        reason = yield from board.handshake()
        collision = inventory.collision(board)
        return f"{board_name(board.board)}: {collision}" if collision else reason

    def _without(self, boards: Iterable[HostBoard], state: str, reasons: Reasons) -> str:
        """Leave out the boards that have failed; the reasons of those that are required."""
        failed: list[str] = []
        machine = self._machine
        for board in boards:
            reason = reasons.get(board.board.name, "")
            if not reason:
                continue
            machine.inventory.note(board, state, machine.now_ns, reason)
            if self.is_required(board):
                failed.append(reason)
                continue
            self.unavailable.append(board)
            silence(board, reason)
            names = ", ".join(axis.name for axis in board.axes)
            text = f"{reason}; the robot starts without {names or 'it'}"
            machine.faults.report(machine.now_ns, text)
        return "; ".join(failed)

    def _quiesce(self) -> Sequence:
        machine = self._machine
        for line in machine.lines.values():
            line.draining = True
        for board in machine.boards:
            for frame in board.quiesce():
                board.line.command(board.board.address, frame)
        end_ns = machine.now_ns + DRAIN_NS
        while machine.now_ns < end_ns:
            yield
        for line in machine.lines.values():
            line.draining = False
        return ""


def silence(board: HostBoard, reason: str) -> None:
    """No commands to a board; its axes say why they are not available."""
    first = board.board.address
    board.line.muted.update(range(first, first + board.addresses))
    for pulse in board.pulses:
        pulse.silent = True
    for axis in board.axes:
        axis.set_calibrated(False)
        axis.set_fault_text(reason)


def _each(
    boards: Iterable[HostBoard], work: Callable[[HostBoard], Sequence], reasons: Reasons
) -> Sequence:
    """Work on all boards at once, and keep the reason of each."""

    def one(board: HostBoard) -> Sequence:
        reasons[board.board.name] = yield from work(board)
        return ""

    return together([one(board) for board in boards])


def _configured(board: HostBoard) -> Sequence:
    return board.configure()


def first_frames(board: HostBoard) -> Sequence:
    """Wait until everything that a board should broadcast has been heard."""
    began_ns = board.line.now_ns
    for pulse in board.pulses:
        while not pulse.heard_ns:
            if board.line.now_ns - began_ns >= max(FIRST_FRAMES_NS, pulse.limit_ns):
                return f"{board_name(board.board)} answers but sends no {pulse.what}"
            yield
    return ""
