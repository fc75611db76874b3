"""Opening the robot: silence the buses, find every board, configure it. It can be repeated."""

from hal.boards.board import NO_ANSWER, HostBoard, board_name
from hal.machine import Machine
from hal.tasks import Sequence, together

DRAIN_NS = 20_000_000
FIRST_FRAMES_NS = 100_000_000
PATIENCE_NS = 10_000_000_000  # boards, or the process that emulates them, may start after the host


class Startup:
    """The sequence and the phase it is in: opening, handshake, configuring."""

    def __init__(self, machine: Machine) -> None:
        self.phase = "opening"
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
        reason = yield from together(board.configure() for board in machine.boards)
        if reason:
            return reason
        reason = yield from together(first_frames(board) for board in machine.boards)
        return reason

    def _find_boards(self) -> Sequence:
        """Shake hands with every board; those that power up after the host get some time."""
        deadline_ns = self._machine.now_ns + PATIENCE_NS
        missing = list(self._machine.boards)
        reasons: dict[str, str] = {}
        while missing and self._machine.now_ns < deadline_ns:
            yield from together(_handshake(board, reasons) for board in missing)
            wrong = [reason for reason in reasons.values() if reason and NO_ANSWER not in reason]
            if wrong:
                return "; ".join(wrong)
            missing = [board for board in missing if reasons[board.board.name]]
        return "; ".join(reason for reason in reasons.values() if reason)

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


def _handshake(board: HostBoard, reasons: dict[str, str]) -> Sequence:
    reasons[board.board.name] = yield from board.handshake()
    return ""


def first_frames(board: HostBoard) -> Sequence:
    """Wait until everything that a board should broadcast has been heard."""
    deadline_ns = board.line.now_ns + FIRST_FRAMES_NS
    for pulse in board.pulses:
        while not pulse.heard_ns:
            if board.line.now_ns >= deadline_ns:
                return f"{board_name(board.board)} answers but sends no {pulse.what}"
            yield
    return ""
