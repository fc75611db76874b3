"""Opening the robot: silence the buses, find every board, configure it. It can be repeated."""

from hal.boards.board import HostBoard, board_name
from hal.machine import Machine
from hal.tasks import Sequence, together

DRAIN_NS = 20_000_000
FIRST_FRAMES_NS = 100_000_000


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
        reason = yield from together(board.handshake() for board in machine.boards)
        if reason:
            return reason
        self.phase = "configuring"
        reason = yield from together(board.configure() for board in machine.boards)
        if reason:
            return reason
        reason = yield from together(first_frames(board) for board in machine.boards)
        return reason

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


def first_frames(board: HostBoard) -> Sequence:
    """Wait until everything that a board should broadcast has been heard."""
    deadline_ns = board.line.now_ns + FIRST_FRAMES_NS
    for pulse in board.pulses:
        while not pulse.heard_ns:
            if board.line.now_ns >= deadline_ns:
                return f"{board_name(board.board)} answers but sends no {pulse.what}"
            yield
    return ""
