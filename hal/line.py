"""One CAN bus as the HAL uses it: who gets which frame, and what leaves in this millisecond.

A board's receive buffer holds 30 frames and it reads them once per millisecond, so sequences send
one command (a group that belongs together) per address and millisecond. Set-points and torques,
already coalesced, leave at once.
"""

from collections import deque
from collections.abc import Callable

import can

from hal.buses.bus import FrameBus
from hal.faults import FaultLog
from hal.wire.can import Frame, Received
from hal.wire.frames import describe

Handler = Callable[[bytes, int], None]
Trace = deque[Received]

TRACE_LENGTH = 8


class Line:
    """Dispatch table, outbox and counters of one bus."""

    __slots__ = (
        "_bus",
        "_faults",
        "_queues",
        "_sent",
        "_table",
        "_urgent",
        "draining",
        "frames_received",
        "frames_sent",
        "is_off",
        "muted",
        "now_ns",
        "number",
    )

    def __init__(self, number: int, bus: FrameBus, faults: FaultLog) -> None:
        self.number = number
        self.now_ns = 0
        self.is_off = False
        self.draining = False  # everything received is thrown away
        self.muted: set[int] = set()  # addresses that get no commands
        self.frames_received = 0
        self.frames_sent = 0
        self._bus = bus
        self._faults = faults
        self._table: dict[int, tuple[Handler, Trace]] = {}
        self._queues: dict[int, deque[tuple[Frame, ...]]] = {}
        self._urgent: list[Frame] = []
        self._sent: deque[Frame] = deque(maxlen=TRACE_LENGTH)

    @property
    def frames_lost(self) -> int:
        """Frames that the bus knows to be lost, either way."""
        return self._bus.frames_lost

    def check_bus(self) -> bool:
        """Ask the bus whether it is off, that is, whether nothing gets through."""
        self.is_off = self._bus.state is can.BusState.ERROR
        return self.is_off

    def attach(self, can_id: int, handler: Handler, trace: Trace) -> None:
        """Give every frame with this identifier to `handler`, remembered in `trace`."""
        self._table[can_id] = (handler, trace)

    def receive(self, now_ns: int) -> None:
        """Take everything that has arrived."""
        self.now_ns = now_ns
        frames = self._bus.receive_frames()
        if not frames:
            return
        self.frames_received += len(frames)
        if self.draining:
            return
        table = self._table
        for frame in frames:
            entry = table.get(frame[0])
            if entry is None:
                self._faults.drop(f"unexpected identifier 0x{frame[0]:03X} on bus {self.number}")
            else:
                entry[1].append(frame)
                entry[0](frame[1], frame[2])

    def command(self, address: int, *frames: Frame) -> None:
        """Queue one command, or several frames that must leave together, for a board's address."""
        if address in self.muted:
            self._faults.refuse("command to a silent board", len(frames))
            return
        self.probe(address, *frames)

    def probe(self, address: int, *frames: Frame) -> None:
        """Queue a command even for an address that is muted."""
        queue = self._queues.get(address)
        if queue is None:
            queue = self._queues[address] = deque()
        queue.append(frames)

    def pending(self, address: int) -> bool:
        """Whether commands for an address still wait."""
        return bool(self._queues.get(address))

    def send(self, address: int, frame: Frame) -> None:
        """Send a frame to one address with this step."""
        if address in self.muted:
            self._faults.refuse("command to a silent board")
            return
        self._urgent.append(frame)

    def broadcast(self, frame: Frame) -> None:
        """Send a frame that nobody in particular is addressed by, with this step."""
        self._urgent.append(frame)

    def discard(self) -> None:
        """Forget every command that waits."""
        self._queues.clear()
        self._urgent.clear()

    def flush(self) -> None:
        """Send what is due; a bus that is off gets nothing, its boards have faulted anyway."""
        out = self._urgent
        for queue in self._queues.values():
            if queue:
                group = queue.popleft()
                self._sent.extend(group)
                out.extend(group)
        if not out:
            return
        self._urgent = []
        if self.is_off:
            self._faults.refuse(f"frame while bus {self.number} is off", len(out))
            return
        self._bus.send_frames(out)
        self.frames_sent += len(out)

    def send_directly(self, frames: list[Frame]) -> None:
        """Send now, past every queue."""
        self._bus.send_frames(frames)
        self.frames_sent += len(frames)

    def evidence(self, trace: Trace, addresses: tuple[int, ...]) -> tuple[str, ...]:
        """The last frames of a board and the last commands to it, decoded, oldest first."""
        received = [f"received {describe(can_id, data)}" for can_id, data, _ in trace]
        sent = [f"sent {describe(*frame)}" for frame in self._sent if frame[0] & 0xF in addresses]
        return tuple(sent + received)
