"""Any bus that python-can can open (slcan, pcan, virtual, ...) as a FrameBus."""

from collections.abc import Sequence

import can
from can.typechecking import CanFilters

from hal.buses.bus import Clock, frame_of
from hal.errors import BusError
from hal.wire.can import Frame, Received

MOST_AT_ONCE = 512  # frames taken in one call: a flood must not hold up the loop


class PythonCanBus:
    """One opened python-can bus. Stamps are those of the reading: drivers' own are not comparable.

    Frames that the iCub's protocol does not have (29-bit, remote, FD) are passed over; `foreign`
    counts them.
    """

    def __init__(self, interface: str, channel: str, clock: Clock) -> None:
        """Open a bus by python-can's names.

        Raises:
            BusError: python-can has no such interface, or it cannot open the channel.
        """
        try:
            self._bus = can.Bus(interface=interface, channel=channel)
        except (can.CanError, OSError, ValueError) as error:
            known = ", ".join(sorted(can.VALID_INTERFACES))
            raise BusError(
                f"python-can cannot open interface {interface!r}, channel {channel!r}: {error}; "
                f"interfaces: {known}"
            ) from error
        self._now_ns = clock.now_ns
        self.foreign = 0
        self._lost = 0
        self._filters: CanFilters | None = None

    @property
    def frames_lost(self) -> int:
        """Frames that python-can refused to send; what a driver loses by itself is not known."""
        return self._lost

    @property
    def state(self) -> can.BusState:
        """See FrameBus; ACTIVE where the driver does not tell."""
        try:
            return self._bus.state
        except NotImplementedError:
            return can.BusState.ACTIVE

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """See FrameBus."""
        for can_id, data in frames:
            try:
                self._bus.send(
                    can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=0
                )
            except can.CanError:
                self._lost += 1

    def receive_frames(self) -> list[Received]:
        """See FrameBus."""
        frames: list[Received] = []
        stamp_ns = self._now_ns()
        while len(frames) < MOST_AT_ONCE:
            try:
                message = self._bus.recv(0)
            except can.CanError:
                break
            if message is None:
                break
            # is_rx says nothing: SocketCAN's is False for every frame
            try:
                can_id, data = frame_of(message)
            except can.CanOperationError:
                self.foreign += 1
                continue
            if self._passes(can_id):
                frames.append((can_id, data, stamp_ns))
        return frames

    def set_filters(self, filters: CanFilters | None = None) -> None:
        """See FrameBus. Not python-can's: there a frame filtered out looks like an empty queue."""
        self._filters = filters

    def _passes(self, can_id: int) -> bool:
        filters = self._filters
        return filters is None or any(
            (can_id ^ entry["can_id"]) & entry["can_mask"] == 0 for entry in filters
        )

    def shutdown(self) -> None:
        """See FrameBus."""
        self._bus.shutdown()
