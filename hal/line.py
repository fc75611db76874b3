"""One CAN bus as the HAL uses it: who gets which frame, and what leaves in this millisecond.

A board's receive buffer holds 30 frames and it reads them once per millisecond, so sequences send
one command (a group that belongs together) per address and millisecond. Set-points and torques,
already coalesced, leave at once. Whatever is asked for, no board gets more than BUDGET in one
millisecond: the rest of its buffer is for the frames that sensors and partner boards send it.
"""

from collections import deque
from collections.abc import Callable

import can

from hal.buses.bus import FrameBus
from hal.faults import FaultLog
from hal.readings import BusReport
from hal.wire.can import CLASS_ANALOG_POLLING, CLASS_MOTOR_POLLING, Frame, Received, class_of
from hal.wire.frames import describe

Handler = Callable[[bytes, int], None]
Trace = deque[Received]

TRACE_LENGTH = 8
BUDGET = 16
WINDOW_NS = 1_000_000_000
OVERHEAD_BITS = 47  # of a frame without stuff bits; 8 more for each data byte (can-protocol 11)
BIT_RATE = 1_000_000
NOBODY = "nobody acknowledges"
_STATES = {
    can.BusState.ACTIVE: "active",
    can.BusState.PASSIVE: "passive",
    can.BusState.ERROR: "off",
}


class Line:
    """Dispatch table, outbox and counters of one bus."""

    __slots__ = (
        "_bits",
        "_bus",
        "_faults",
        "_owner",
        "_queues",
        "_sent",
        "_table",
        "_urgent",
        "_waiting",
        "_window_ns",
        "draining",
        "errors",
        "frames_received",
        "frames_sent",
        "is_off",
        "load_percent",
        "muted",
        "nobody_listens",
        "now_ns",
        "number",
        "since_ns",
        "state",
    )

    def __init__(self, number: int, bus: FrameBus, faults: FaultLog) -> None:
        self.number = number
        self.now_ns = 0
        self.is_off = False
        self.nobody_listens = False  # set by whoever knows the boards; then nothing is broadcast
        self.state = "active"
        self.since_ns = 0
        self.draining = False  # everything received is thrown away
        self.muted: set[int] = set()  # addresses that get no commands
        self.frames_received = 0
        self.frames_sent = 0
        self.errors = 0
        self.load_percent = 0.0
        self._bits = 0
        self._window_ns = 0
        self._bus = bus
        self._faults = faults
        self._table: dict[int, tuple[Handler, Trace]] = {}
        self._queues: dict[int, deque[tuple[Frame, ...]]] = {}
        self._waiting = 0
        self._owner: dict[int, int] = {}
        self._urgent: list[Frame] = []
        self._sent: deque[Frame] = deque(maxlen=TRACE_LENGTH)

    @property
    def frames_lost(self) -> int:
        """Frames that the bus knows to be lost, either way."""
        return self._bus.frames_lost

    def check_bus(self, now_ns: int) -> bool:
        """Ask the bus how it is; True when its state has changed."""
        bus_state = self._bus.state
        self.is_off = bus_state is can.BusState.ERROR
        state = _STATES[bus_state]
        if self.nobody_listens and not self.is_off:
            state = NOBODY
        if now_ns - self._window_ns >= WINDOW_NS:
            self.load_percent = 1e11 * self._bits / BIT_RATE / (now_ns - self._window_ns)
            self._bits, self._window_ns = 0, now_ns
        if state == self.state:
            return False
        self.state, self.since_ns = state, now_ns
        return True

    def report(self) -> BusReport:
        """State and counters."""
        return BusReport(
            number=self.number,
            state=self.state,
            since_ns=self.since_ns,
            frames_received=self.frames_received,
            frames_sent=self.frames_sent,
            frames_lost=self.frames_lost,
            errors=self.errors,
            load_percent=self.load_percent,
        )

    def attach(self, can_id: int, handler: Handler, trace: Trace) -> None:
        """Give every frame with this identifier to `handler`, remembered in `trace`."""
        self._table[can_id] = (handler, trace)

    def also(self, can_id: int, handler: Handler, trace: Trace) -> None:
        """Give it to `handler` too; the trace counts where nobody else is attached."""
        entry = self._table.get(can_id)
        if entry is None:
            self.attach(can_id, handler, trace)
            return
        first, trace = entry

        def both(data: bytes, stamp_ns: int) -> None:
            handler(data, stamp_ns)
            first(data, stamp_ns)

        self.attach(can_id, both, trace)

    def share(self, address: int, owner: int) -> None:
        """The board at `owner` reads the frames of this address from one buffer with its own."""
        self._owner[address] = owner

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
        size = 0
        for frame in frames:
            can_id, data, stamp_ns = frame
            size += len(data)
            entry = table.get(can_id)
            if entry is None:
                self.errors += 1
                self._faults.drop(
                    f"unexpected identifier 0x{can_id:03X} on bus {self.number}",
                    f"unexpected identifiers on bus {self.number}",
                )
            else:
                handler, trace = entry
                trace.append(frame)
                handler(data, stamp_ns)
        self._bits += OVERHEAD_BITS * len(frames) + 8 * size

    def command(self, address: int, *frames: Frame) -> None:
        """Queue one command, or several frames that must leave together, for a board's address."""
        if address in self.muted:
            self._faults.refuse("command to a silent board", len(frames))
            return
        self.probe(address, *frames)

    def probe(self, address: int, *frames: Frame) -> None:
        """Queue a command even for an address that is muted; one that waits already is enough."""
        queue = self._queues.get(address)
        if queue is None:
            queue = self._queues[address] = deque()
        head = frames[0][1][:1]
        for group in reversed(queue):
            if group[0][1][:1] == head:
                if group == frames:
                    return
                break
        queue.append(frames)
        self._waiting += 1

    def pending(self, address: int) -> bool:
        """Whether commands for an address still wait."""
        return bool(self._queues.get(address))

    def send(self, address: int, frame: Frame) -> None:
        """Send a frame to one address with this step."""
        if address in self.muted:
            self._faults.refuse("command to a silent board")
            return
        if frame not in self._urgent:
            self._urgent.append(frame)

    def broadcast(self, frame: Frame) -> None:
        """Send a frame that nobody in particular is addressed by, with this step."""
        if not self.nobody_listens:
            self._urgent.append(frame)

    def discard(self) -> None:
        """Forget every command that waits."""
        self._queues.clear()
        self._waiting = 0
        self._urgent.clear()

    def flush(self) -> None:
        """Send what is due; a bus that is off gets nothing, its boards have faulted anyway."""
        out = self._urgent
        if self._waiting:
            for queue in self._queues.values():
                if queue:
                    group = queue.popleft()
                    self._waiting -= 1
                    self._sent.extend(group)
                    out.extend(group)
        if not out:
            return
        self._urgent = []
        if self.is_off:
            self._faults.refuse(f"frame while bus {self.number} is off", len(out))
            return
        if len(out) > BUDGET:
            out = self._within_budget(out)
        self.send_directly(out)

    def _within_budget(self, frames: list[Frame]) -> list[Frame]:
        """What may leave now; what a board could not take in time leaves one millisecond later."""
        counts: dict[int, int] = {}
        now: list[Frame] = []
        for frame in frames:
            can_id = frame[0]
            if class_of(can_id) not in (CLASS_MOTOR_POLLING, CLASS_ANALOG_POLLING):
                now.append(frame)
                continue
            address = can_id & 0xF
            owner = self._owner.get(address, address)
            counts[owner] = counts.get(owner, 0) + 1
            (now if counts[owner] <= BUDGET else self._urgent).append(frame)
        return now

    def send_directly(self, frames: list[Frame]) -> None:
        """Send now, past every queue."""
        self._bus.send_frames(frames)
        self.frames_sent += len(frames)
        size = 0
        for frame in frames:
            size += len(frame[1])
        self._bits += OVERHEAD_BITS * len(frames) + 8 * size

    def evidence(self, trace: Trace, addresses: tuple[int, ...]) -> tuple[str, ...]:
        """The last frames of a board and the last commands to it, decoded, oldest first."""
        received = [f"received {describe(can_id, data)}" for can_id, data, _ in trace]
        sent = [f"sent {describe(*frame)}" for frame in self._sent if frame[0] & 0xF in addresses]
        return tuple(sent + received)
