"""What every CAN bus of Ulna can do, and the python-can side that the buses of our own share.

All are python-can buses as well (send, recv, filters, state, shutdown), so that any python-can tool
works on them. The control loops use the two calls of FrameBus, which carry bare tuples: a
can.Message costs more than the whole codec.
"""

from abc import abstractmethod
from collections import deque
from collections.abc import Sequence
from typing import Protocol

import can
from can.typechecking import CanFilters

from hal.wire.can import Frame, Received

MAX_STANDARD_ID = 0x7FF


class Clock(Protocol):
    """Where a bus takes its arrival stamps from."""

    def now_ns(self) -> int:
        """Instant now [ns]."""


class HostClock(Clock, Protocol):
    """A clock that also knows where the kernel's time stamps stand on it."""

    def since_day_clock_ns(self) -> int:
        """What to add to an instant of the clock of the day to have it on this clock [ns]."""


class FrameBus(Protocol):
    """One opened CAN channel."""

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Send frames in this order; on a bus that is off they are counted as lost, not raised."""

    def receive_frames(self) -> list[Received]:
        """Every data frame that others sent and that has arrived, oldest first. Never waits."""

    @property
    def frames_lost(self) -> int:
        """Frames known not to have made it, in either direction, since the bus was opened."""

    @property
    def state(self) -> can.BusState:
        """ACTIVE, or ERROR while the bus is off."""

    def set_filters(self, filters: CanFilters | None = None) -> None:
        """Receive only what matches one of python-can's filters; None = everything."""

    def shutdown(self) -> None:
        """Close; may be called twice."""


class TupleBus(can.BusABC):
    """A python-can bus whose native unit is the tuple; the iCub's 11-bit data frames only."""

    def __init__(self, channel: str, can_filters: CanFilters | None = None) -> None:
        self._accepted: dict[int, bool] = {}
        self._unread: deque[Received] = deque()
        self.channel = channel
        self.channel_info = f"{type(self).__name__} {channel}"
        super().__init__(channel=channel, can_filters=can_filters)

    @abstractmethod
    def send_frames(self, frames: Sequence[Frame]) -> None:
        """See FrameBus."""

    @abstractmethod
    def receive_frames(self) -> list[Received]:
        """See FrameBus."""

    @property
    @abstractmethod
    def frames_lost(self) -> int:
        """See FrameBus."""

    @abstractmethod
    def _wait(self, timeout_s: float | None) -> None:
        """Return when something has arrived, or after the time-out."""

    @abstractmethod
    def is_off(self) -> bool:
        """Whether nothing gets through at present."""

    @property
    def state(self) -> can.BusState:
        """See FrameBus."""
        return can.BusState.ERROR if self.is_off() else can.BusState.ACTIVE

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        raise NotImplementedError(f"{self.channel_info} cannot be set {new_state}")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002
        """Send one message; raises CanOperationError where this bus cannot carry it or is off."""
        if self.is_off():
            raise can.CanOperationError(f"{self.channel_info} is off")
        self.send_frames((frame_of(msg),))

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._unread:
            self._unread.extend(self.receive_frames())
        if not self._unread and timeout != 0:
            self._wait(timeout)
            self._unread.extend(self.receive_frames())
        if not self._unread:
            return None, True
        return message_of(self._unread.popleft(), self.channel), True

    def _apply_filters(self, filters: CanFilters | None) -> None:  # noqa: ARG002  kept by BusABC
        self._accepted.clear()

    def _filtered(self, frames: list[Received]) -> list[Received]:
        """Only what the filters let through; the decision is taken once for each identifier."""
        if self._filters is None:
            return frames
        return [frame for frame in frames if self._accepts(frame[0])]

    def _accepts(self, can_id: int) -> bool:
        accepted = self._accepted.get(can_id)
        if accepted is None:
            probe = can.Message(arbitration_id=can_id, is_extended_id=False)
            accepted = self._accepted[can_id] = self._matches_filters(probe)
        return accepted


def frame_of(message: can.Message) -> Frame:
    """The tuple of a message; CanOperationError where the iCub's protocol has no such frame."""
    odd = (
        message.is_extended_id
        or message.is_remote_frame
        or message.is_error_frame
        or message.is_fd
        or message.arbitration_id > MAX_STANDARD_ID
    )
    if odd:
        raise can.CanOperationError(f"only 11-bit data frames are carried here, not: {message}")
    return message.arbitration_id, bytes(message.data)


def message_of(received: Received, channel: str) -> can.Message:
    """The python-can message of a received tuple; its timestamp is the arrival on our clock [s]."""
    can_id, data, stamp_ns = received
    return can.Message(
        arbitration_id=can_id,
        data=data,
        is_extended_id=False,
        timestamp=stamp_ns * 1e-9,
        channel=channel,
        is_rx=True,
    )
