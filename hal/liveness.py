"""Who has fallen silent: boards by their periodic frames, buses by their own word.

A silent board gets no commands, only a handshake once per second. A board that talks again by
itself has kept its settings (a restarted one has its masks at zero); one that only answers has
restarted and is configured again: its axes are then idle and need calibration. After a bus was off
every board on it is configured again.
"""

from collections.abc import Iterable

from hal.boards.board import NO_ANSWER, HostBoard, Pulse, board_name
from hal.couplings import needed_boards
from hal.line import NOBODY, Line
from hal.machine import Machine
from hal.startup import first_frames, silence
from hal.tasks import Sequence
from hal.wire.motor_periodic import AxisFault

CHECK_NS = 5_000_000
HUSH_NS = 50_000_000  # a board that still sends anything else talks more often than this
PROBE_NS = 1_000_000_000
FIRST_PROBE_NS = 100_000_000


class Liveness:
    """Watches the boards and buses of a machine once it is configured."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._pulses = [(board, pulse) for board in machine.boards for pulse in board.pulses]
        self._next_ns = 0
        self._lost = dict.fromkeys(machine.lines, 0)
        self._heard = dict.fromkeys(machine.lines, 0)
        self._returning: dict[str, Sequence] = {}
        self._configuring: set[str] = set()  # these are silent until they are told to talk

    def start(self, unavailable: Iterable[HostBoard]) -> None:
        """Everything is heard from now on, but for the boards that the robot started without."""
        for board in self._machine.boards:
            for pulse in board.pulses:
                pulse.heard_ns = self._machine.now_ns
        for board in unavailable:
            for pulse in board.pulses:
                pulse.heard_ns = 0
            self._returning[board.board.name] = self._recover(board)

    def step(self, now_ns: int, boards_talk: bool) -> None:
        """Look at the buses, and at the boards once they should talk; bring boards back."""
        if self._returning:
            self._resume(now_ns)
        if now_ns < self._next_ns:
            return
        self._next_ns = now_ns + CHECK_NS
        if boards_talk:
            for board, pulse in self._pulses:
                if pulse.silent or now_ns - pulse.heard_ns > pulse.limit_ns:
                    self._check_pulse(board, pulse, now_ns)
        for line in self._machine.lines.values():
            self._check_line(line, now_ns, boards_talk)

    def _check_line(self, line: Line, now_ns: int, boards_talk: bool) -> None:
        faults = self._machine.faults
        was_off = line.is_off
        heard, self._heard[line.number] = self._heard[line.number], line.frames_received
        if heard != line.frames_received:
            line.nobody_listens = False
        elif boards_talk and self._is_deserted(line):
            line.nobody_listens = True
        if line.check_bus(now_ns):
            faults.report(now_ns, f"bus {line.number} {_STATE_TEXTS[line.state]}")
        if line.is_off and not was_off:
            line.discard()
        elif was_off and not line.is_off and boards_talk:
            self._restore(line)
        lost = line.frames_lost - self._lost[line.number]
        if lost > 0:
            self._lost[line.number] += lost
            if not line.is_off:  # that they are lost then has been said
                text = f"bus {line.number} lost {lost} frames ({line.frames_lost} in all)"
                faults.report(now_ns, text, f"bus {line.number} lost")

    def _is_deserted(self, line: Line) -> bool:
        pulses = [p for b in self._machine.boards if b.line is line for p in b.pulses]
        return bool(pulses) and all(pulse.silent for pulse in pulses)

    def _restore(self, line: Line) -> None:
        """The boards have faulted while the bus was off; nothing is taken for granted."""
        for board in self._machine.boards:
            if board.line is line:
                silence(board, f"bus {line.number} was off")
                name = board_name(board.board)
                text = f"{name} is configured again after its bus was off{_idle_axes(board)}"
                self._returning[board.board.name] = self._reconfigure(board, text)

    def _check_pulse(self, board: HostBoard, pulse: Pulse, now_ns: int) -> None:
        if board.board.name in self._configuring:
            return
        age_ns = self._machine.stalls.age_ns(now_ns, pulse.heard_ns)
        if age_ns > pulse.limit_ns and not pulse.silent:
            pulse.silent = True
            self._fall_silent(board, pulse, now_ns)
        elif (
            age_ns <= pulse.limit_ns
            and pulse.silent
            and pulse.address not in board.line.muted
            and board.board.name not in self._returning
        ):
            pulse.silent = False
            text = f"{board_name(board.board)} sends {pulse.what} again"
            self._machine.faults.report(now_ns, text)
            self._machine.inventory.note(board, "ok", now_ns)

    def _fall_silent(self, board: HostBoard, pulse: Pulse, now_ns: int) -> None:
        name, line = board_name(board.board), board.line
        age_s = (now_ns - pulse.heard_ns) / 1e9
        evidence = line.evidence(board.trace, (pulse.address,))
        if board.trace and now_ns - board.trace[-1][2] <= HUSH_NS:
            text = f"{name} sends no {pulse.what} for {age_s:.3f} s"
            if any(axis.fault_bits & AxisFault.ENCODER for axis in board.axes):
                text += " (it has an absolute encoder error)"
            self._machine.faults.report(now_ns, text, frames=evidence)
            self._machine.inventory.note(board, "silent", now_ns, f"no {pulse.what}")
            return
        text = f"{name} silent for {age_s:.3f} s{self._consequence(board)}"
        self._machine.faults.report(now_ns, text, f"{name} silent", evidence)
        self._machine.inventory.note(board, "silent", now_ns, f"no {pulse.what}")
        line.muted.add(pulse.address)
        for axis in board.axes:
            if axis.address == pulse.address:
                axis.set_calibrated(False)
                axis.set_fault_text("board silent")
        if board.board.name not in self._returning:
            self._returning[board.board.name] = self._recover(board)

    def _consequence(self, board: HostBoard) -> str:
        """Which boards fault because they do not hear this one."""
        if board.board.type != "mais":
            return ""
        hands = [
            other.board.name
            for other in self._machine.boards
            if other.axes and board.board in needed_boards(other.board, [board.board])
        ]
        if not hands:
            return ""
        return f": without it {', '.join(hands)} fault, check the cable and power of the MAIS"

    def _recover(self, board: HostBoard) -> Sequence:
        """Wait for a silent board: it talks again, or it has restarted and answers a handshake."""
        line, name = board.line, board_name(board.board)
        pause_ns = FIRST_PROBE_NS
        said = self._machine.inventory.records[board.board.name].reason
        while True:
            next_ns = line.now_ns + pause_ns
            pause_ns = PROBE_NS
            while line.now_ns < next_ns:
                yield
                if _talks(board):
                    _unmute(board)
                    reason = yield from board.read_back()
                    self._note(board, "ok", reason)
                    return reason or f"{name} is back; it has kept its settings"
            reason = yield from self._shake_hands(board)
            if not reason and not _talks(board):
                break
            if reason and not reason.endswith(NO_ANSWER) and reason != said:
                said = reason
                self._machine.faults.report(line.now_ns, reason)
                self._note(board, "wrong", reason)
        text = f"{name} has restarted; it is configured again{_idle_axes(board)}"
        reason = yield from self._reconfigure(board, text)
        return reason

    def _reconfigure(self, board: HostBoard, text: str) -> Sequence:
        """Settings, streams, axes idle; motion only when somebody asks for it.

        A board that answers but stays silent is configured again until it sends.
        """
        said = ""
        self._configuring.add(board.board.name)
        try:
            while True:
                reason = yield from self._configured(board)
                if all(pulse.heard_ns for pulse in board.pulses):
                    break
                silence(board, reason)
                self._note(board, "wrong", reason)
                if reason != said:
                    said = reason
                    self._machine.faults.report(board.line.now_ns, reason)
        finally:
            self._configuring.discard(board.board.name)
            for pulse in board.pulses:
                pulse.heard_ns = pulse.heard_ns or board.line.now_ns
        self._note(board, "restarted", reason)
        return reason or text

    def _configured(self, board: HostBoard) -> Sequence:
        """One attempt, from the handshake to the first frames."""
        while True:
            reason = yield from self._shake_hands(board)
            if not reason:
                break
        _unmute(board)
        for pulse in board.pulses:
            pulse.heard_ns = 0
        reason = yield from board.configure()
        if not reason:
            reason = yield from first_frames(board)
        return reason

    def _shake_hands(self, board: HostBoard) -> Sequence:
        self._machine.inventory.ask(board)
        reason = yield from board.handshake()
        return reason

    def _note(self, board: HostBoard, state: str, reason: str) -> None:
        failed = "wrong" if reason else state
        self._machine.inventory.note(board, failed, board.line.now_ns, reason)

    def _resume(self, now_ns: int) -> None:
        for name, sequence in list(self._returning.items()):
            try:
                next(sequence)
            except StopIteration as stop:
                del self._returning[name]
                self._machine.faults.report(now_ns, stop.value)


_STATE_TEXTS = {
    "active": "is back",
    "passive": "is error-passive: frames are often repeated",
    "off": "is off: no frame gets through",
    NOBODY: "is deserted: nobody acknowledges, check its cable, power and termination",
}


def _talks(board: HostBoard) -> bool:
    now_ns = board.line.now_ns
    return bool(board.pulses) and all(
        now_ns - pulse.heard_ns <= pulse.limit_ns for pulse in board.pulses
    )


def _idle_axes(board: HostBoard) -> str:
    return ", its axes are idle" if board.axes else ""


def _unmute(board: HostBoard) -> None:
    first = board.board.address
    board.line.muted.difference_update(range(first, first + board.addresses))
    for pulse in board.pulses:
        pulse.silent = False
        pulse.heard_ns = board.line.now_ns
