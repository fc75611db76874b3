"""Who has fallen silent: boards by their periodic frames, buses by their own word.

A silent board gets no commands, only a handshake once per second. A board that talks again by
itself has kept its settings (a restarted one has its masks at zero); one that only answers has
restarted and is configured again: its axes are then idle and need calibration.
"""

from hal.boards.board import SILENCE_NS, HostBoard, Pulse, board_name
from hal.line import Line
from hal.machine import Machine
from hal.tasks import Sequence
from hal.wire.motor_periodic import AxisFault

CHECK_NS = 10_000_000
HUSH_NS = 50_000_000  # a board that still sends anything else talks more often than this
PROBE_NS = 1_000_000_000


class Liveness:
    """Watches the boards and buses of a machine once it is configured."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._next_ns = 0
        self._lost = dict.fromkeys(machine.lines, 0)
        self._returning: dict[str, Sequence] = {}

    def start(self) -> None:
        """Everything is heard from now on."""
        for board in self._machine.boards:
            for pulse in board.pulses:
                pulse.heard_ns = self._machine.now_ns

    def step(self, now_ns: int, boards_talk: bool) -> None:
        """Look at the buses, and at the boards once they should talk; bring boards back."""
        if self._returning:
            self._resume(now_ns)
        if now_ns < self._next_ns:
            return
        self._next_ns = now_ns + CHECK_NS
        for line in self._machine.lines.values():
            self._check_line(line, now_ns)
        if boards_talk:
            for board in self._machine.boards:
                for pulse in board.pulses:
                    self._check_pulse(board, pulse, now_ns)

    def _check_line(self, line: Line, now_ns: int) -> None:
        faults = self._machine.faults
        was_off = line.is_off
        if line.check_bus() != was_off:
            state = "is off: no frame gets through" if line.is_off else "is back"
            faults.report(now_ns, f"bus {line.number} {state}")
        lost = line.frames_lost - self._lost[line.number]
        if lost > 0:
            self._lost[line.number] += lost
            text = f"bus {line.number} lost {lost} frames ({line.frames_lost} in all)"
            faults.report(now_ns, text, f"bus {line.number} lost")

    def _check_pulse(self, board: HostBoard, pulse: Pulse, now_ns: int) -> None:
        age_ns = self._machine.stalls.age_ns(now_ns, pulse.heard_ns)
        if age_ns > SILENCE_NS and not pulse.silent:
            pulse.silent = True
            self._fall_silent(board, pulse, now_ns)
        elif age_ns <= SILENCE_NS and pulse.silent and pulse.address not in board.line.muted:
            pulse.silent = False
            text = f"{board_name(board.board)} sends {pulse.what} again"
            self._machine.faults.report(now_ns, text)

    def _fall_silent(self, board: HostBoard, pulse: Pulse, now_ns: int) -> None:
        name, line = board_name(board.board), board.line
        age_s = (now_ns - pulse.heard_ns) / 1e9
        evidence = line.evidence(board.trace, (pulse.address,))
        if board.trace and now_ns - board.trace[-1][2] <= HUSH_NS:
            text = f"{name} sends no {pulse.what} for {age_s:.3f} s"
            if any(axis.fault_bits & AxisFault.ENCODER for axis in board.axes):
                text += " (it has an absolute encoder error)"
            self._machine.faults.report(now_ns, text, frames=evidence)
            return
        text = f"{name} silent for {age_s:.3f} s"
        self._machine.faults.report(now_ns, text, f"{name} silent", evidence)
        line.muted.add(pulse.address)
        for axis in board.axes:
            if axis.address == pulse.address:
                axis.set_calibrated(False)
                axis.set_fault_text("board silent")
        if board.board.name not in self._returning:
            self._returning[board.board.name] = self._recover(board)

    def _recover(self, board: HostBoard) -> Sequence:
        """Wait for a silent board: it talks again, or it has restarted and answers a handshake."""
        line, name = board.line, board_name(board.board)
        while True:
            next_ns = line.now_ns + PROBE_NS
            while line.now_ns < next_ns:
                yield
                if _talks(board):
                    _unmute(board)
                    reason = yield from board.read_back()
                    return reason or f"{name} is back; it has kept its settings"
            reason = yield from board.handshake()
            if not reason and not _talks(board):
                break
        _unmute(board)
        reason = yield from board.configure()
        return reason or f"{name} has restarted; it is configured again, its axes are idle"

    def _resume(self, now_ns: int) -> None:
        for name, sequence in list(self._returning.items()):
            try:
                next(sequence)
            except StopIteration as stop:
                del self._returning[name]
                self._machine.faults.report(now_ns, stop.value)


def _talks(board: HostBoard) -> bool:
    now_ns = board.line.now_ns
    return all(now_ns - pulse.heard_ns <= SILENCE_NS for pulse in board.pulses)


def _unmute(board: HostBoard) -> None:
    for pulse in board.pulses:
        pulse.silent = False
        pulse.heard_ns = board.line.now_ns
        board.line.muted.discard(pulse.address)
