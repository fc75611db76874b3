"""CAN in virtual time: one process, no thread, nothing waits, every run the same."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import can
from can.typechecking import CanFilters

from hal.buses.bus import Clock, TupleBus
from hal.wire.can import Frame, Received

DEFAULT_DELAY_NS = 1_000_000  # one tick, as every hop between processes in virtual time


@dataclass
class Faults:
    """Switches of one channel, for tests and fault scenarios. Counts run down as they are used."""

    bus_off: bool = False  # nothing gets through and every sender sees it
    drop_next: int = 0  # frames that vanish, from the next one on
    drop_ids: set[int] = field(default_factory=set)  # identifiers that always vanish
    corrupt_next: int = 0  # frames whose data bytes arrive inverted
    duplicate_next: int = 0  # frames that arrive twice
    delay_ns: int = 0  # in addition to the network's


class MemoryNetwork:
    """All channels of one virtual robot. Sent at t, a frame can be read by others at t + delay."""

    def __init__(self, clock: Clock, delay_ns: int = DEFAULT_DELAY_NS) -> None:
        self.clock = clock
        self.delay_ns = delay_ns
        self._members: dict[str, list[MemoryBus]] = {}
        self._faults: dict[str, Faults] = {}

    def faults(self, channel: str) -> Faults:
        """The switches of a channel; all off until somebody changes one."""
        return self._faults.setdefault(channel, Faults())

    def injected(self, channel: str) -> Faults | None:
        """The switches, or None for a channel that nobody has ever asked the switches of."""
        return self._faults.get(channel)

    def join(self, bus: MemoryBus) -> list[MemoryBus]:
        """Add a bus to its channel; the list returned is the channel's and stays up to date."""
        members = self._members.setdefault(bus.channel, [])
        members.append(bus)
        return members


class MemoryBus(TupleBus):
    """One node's access to a channel of a MemoryNetwork."""

    def __init__(
        self, network: MemoryNetwork, channel: str, can_filters: CanFilters | None = None
    ) -> None:
        self._network = network
        self._clock = network.clock
        self._inbox: deque[tuple[int, list[Received]]] = deque()  # (readable from, frames)
        self._lost = 0
        super().__init__(channel, can_filters)
        self._members = network.join(self)

    @property
    def frames_lost(self) -> int:
        """Dropped by a switch on the way here, or sent from here while the channel was off."""
        return self._lost

    def is_off(self) -> bool:
        """Whether the channel is switched off."""
        faults = self._network.injected(self.channel)
        return faults is not None and faults.bus_off

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Hand the frames to every other bus of the channel; they share one list."""
        if not frames:
            return
        due_ns = self._clock.now_ns() + self._network.delay_ns
        faults = self._network.injected(self.channel)
        if faults is not None:
            due_ns += faults.delay_ns
            frames = self._spoiled(frames, faults)
        batch = due_ns, [(can_id, data, due_ns) for can_id, data in frames]
        for member in self._members:
            if member is not self:
                member.accept(batch)

    def accept(self, batch: tuple[int, list[Received]]) -> None:
        """Other buses of the channel: frames for us."""
        self._inbox.append(batch)

    def count_lost(self, frames: int) -> None:
        """Other buses of the channel: frames that a switch kept from us."""
        self._lost += frames

    def receive_frames(self) -> list[Received]:
        """See FrameBus; the stamp is the instant from which the frame could be read."""
        inbox = self._inbox
        frames: list[Received] = []
        now_ns = self._clock.now_ns()
        while inbox and inbox[0][0] <= now_ns:
            frames += inbox.popleft()[1]
        return self._filtered(frames) if self._filters else frames

    def recv(self, timeout: float | None = None) -> can.Message | None:  # noqa: ARG002
        """The next message or None; virtual time does not pass while somebody waits."""
        return super().recv(timeout=0)

    def shutdown(self) -> None:
        """Leave the channel."""
        if self in self._members:
            self._members.remove(self)
        super().shutdown()

    def _wait(self, timeout_s: float | None) -> None:
        """Nothing can arrive while we are running."""

    def _spoiled(self, frames: Sequence[Frame], faults: Faults) -> list[Frame]:
        """What is left of the frames once the switches have had their way."""
        if faults.bus_off:
            self._lost += len(frames)
            return []
        passed: list[Frame] = []
        dropped = 0
        for can_id, data in frames:
            if faults.drop_next > 0 or can_id in faults.drop_ids:
                faults.drop_next = max(0, faults.drop_next - 1)
                dropped += 1
            elif faults.corrupt_next > 0:
                faults.corrupt_next -= 1
                passed.append((can_id, bytes(byte ^ 0xFF for byte in data)))
            elif faults.duplicate_next > 0:
                faults.duplicate_next -= 1
                passed += [(can_id, data)] * 2
            else:
                passed.append((can_id, data))
        for member in self._members:
            if dropped and member is not self:
                member.count_lost(dropped)
        return passed
