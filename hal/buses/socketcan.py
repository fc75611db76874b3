"""CAN through the Linux kernel: a real interface (can0) or a virtual one (vcan0)."""

import errno
import fcntl
import select
import socket
import struct
from collections.abc import Iterable, Sequence

from can.typechecking import CanFilters

from hal.buses.bus import HostClock, TupleBus
from hal.buses.kernel_batch import BATCH, KernelBatch
from hal.errors import BusError
from hal.wire.can import Frame, Received

RECEIVE_BUFFER_BYTES = 4 << 20  # the default holds some 256 frames and then drops without a word
BATCHES_PER_OFFSET = 500  # half a second of a busy bus
JUMP_NS = 100_000_000  # a pause that long, or a jump of the clock of the day
BACKLOG_LIMIT = 256  # frames kept while the interface's queue is full: 30 ms of a 1 Mbit/s bus

# Numbers of the kernel's headers that Python's socket module lacks.
SO_TIMESTAMPNS = 35
SO_RXQ_OVFL = 40
SO_RCVBUFFORCE = 33
CAN_RAW_ERR_FILTER = 2
SIOCGIFFLAGS = 0x8913
IFF_UP = 0x1
CAN_ERR_BUSOFF = 0x40
CAN_ERR_RESTARTED = 0x100

FLAGS = socket.CAN_EFF_FLAG | socket.CAN_RTR_FLAG | socket.CAN_ERR_FLAG
GONE = (errno.ENETDOWN, errno.ENODEV, errno.ENXIO, errno.EBADF)


def interfaces_up(names: Iterable[str]) -> bool:
    """Whether the kernel knows SocketCAN and all these interfaces exist and are up."""
    if not hasattr(socket, "AF_CAN"):
        return False
    try:
        probe = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    except OSError:
        return False
    with probe:
        return all(_is_up(probe, name) for name in names)


class SocketCanBus(TupleBus):
    """One node's access to a SocketCAN interface. Frames that it sends do not come back to it."""

    def __init__(
        self, channel: str, clock: HostClock, can_filters: CanFilters | None = None
    ) -> None:
        """Open an interface.

        Raises:
            BusError: the kernel has no SocketCAN, or the interface is missing or down.
        """
        self._lost = 0
        self._dropped_by_kernel = 0
        self._down = False
        self._bus_off = False
        self._backlog: list[Frame] = []
        self._outgoing, self._incoming = KernelBatch(), KernelBatch()
        self._read_offset_ns = clock.since_day_clock_ns
        self._offset_ns = 0
        self._last_stamp_ns = 0
        self._batches_to_offset = 0
        self._socket = _open(channel)
        super().__init__(channel, can_filters)

    @property
    def frames_lost(self) -> int:
        """Dropped by the kernel before we read them, or not sent while the interface was off."""
        return self._lost

    def is_off(self) -> bool:
        """Interface down, or the controller in bus-off."""
        if self._down:
            self._down = not _is_up(self._socket, self.channel)
        return self._down or self._bus_off

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """See FrameBus. Where the interface's queue is full, the rest goes with the next call."""
        waiting = self._backlog + list(frames) if self._backlog else frames
        sent = 0
        try:
            while sent < len(waiting):
                sent += self._outgoing.send(self._socket, waiting[sent : sent + BATCH])
        except OSError as error:
            self._failed(error)
        if sent < len(waiting):
            keep = 0 if self._down or self._bus_off else BACKLOG_LIMIT
            left = list(waiting[sent:])
            self._lost += max(0, len(left) - keep)
            self._backlog = left[len(left) - keep :] if keep else []
        elif self._backlog:
            self._backlog = []

    def receive_frames(self) -> list[Received]:
        """See FrameBus; the stamp is the kernel's, on our clock."""
        frames: list[Received] = []
        try:
            while True:
                raw, stamps_ns, dropped = self._incoming.receive(self._socket)
                offset_ns = self._offset_for(stamps_ns)
                for (can_id, length, data), stamp_ns in zip(raw, stamps_ns, strict=True):
                    if can_id & FLAGS:
                        self._note_error_frame(can_id)
                    else:
                        frames.append((can_id, data[:length], stamp_ns + offset_ns))
                if dropped is not None:
                    self._lost += (dropped - self._dropped_by_kernel) & 0xFFFF_FFFF
                    self._dropped_by_kernel = dropped
                if len(raw) < BATCH:
                    return frames
        except OSError as error:
            self._failed(error)
        return frames

    def fileno(self) -> int:
        """For select()."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Close the socket."""
        super().shutdown()
        self._socket.close()

    def _wait(self, timeout_s: float | None) -> None:
        select.select([self._socket], [], [], timeout_s)

    def _offset_for(self, stamps_ns: list[int]) -> int:
        """What to add to the kernel's stamps to have them on our clock.

        Read now and then, as the clock of the day is slewed, and when that clock has jumped. Not
        each time: on a virtual kernel one look at a clock costs as much as the whole batch.
        """
        first_ns, last_ns = stamps_ns[0], stamps_ns[-1]
        jumped = not 0 <= first_ns - self._last_stamp_ns <= last_ns - self._last_stamp_ns < JUMP_NS
        self._last_stamp_ns = last_ns
        self._batches_to_offset -= 1
        if jumped or self._batches_to_offset <= 0:
            self._batches_to_offset = BATCHES_PER_OFFSET
            self._offset_ns = self._read_offset_ns()
        return self._offset_ns

    def _failed(self, error: OSError) -> None:
        """Tell "nothing to do now" from "the bus is gone"."""
        if error.errno in GONE:
            self._down = True
        elif error.errno not in (errno.EAGAIN, errno.ENOBUFS):
            raise BusError(f"{self.channel}: {error.strerror}") from error

    def _note_error_frame(self, can_id: int) -> None:
        if can_id & socket.CAN_ERR_FLAG:
            if can_id & CAN_ERR_BUSOFF:
                self._bus_off = True
            elif can_id & CAN_ERR_RESTARTED:
                self._bus_off = False

    def _apply_filters(self, filters: CanFilters | None) -> None:
        """The kernel filters; 11-bit data frames only."""
        wanted = filters or ({"can_id": 0, "can_mask": 0},)
        flags = socket.CAN_EFF_FLAG | socket.CAN_RTR_FLAG
        packed = b"".join(
            struct.pack("=II", entry["can_id"], entry["can_mask"] | flags)
            for entry in wanted
            if not entry.get("extended")
        )
        self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, packed)


def _open(channel: str) -> socket.socket:
    """A bound, non-blocking raw socket."""
    try:
        opened = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    except (AttributeError, OSError) as error:
        raise BusError(
            f"{channel}: this kernel has no SocketCAN; take one that has it, or a stack "
            "with --can zenoh"
        ) from error
    try:
        opened.bind((channel,))
        if not _is_up(opened, channel):
            raise BusError(
                f"{channel}: the interface is down; bring it up with: ulna can up, "
                f"or: ip link set {channel} up"
            )
        _configure(opened)
    except OSError as error:
        opened.close()
        raise BusError(
            f"{channel}: {error.strerror}; make the interface with: ulna can up, or use --can zenoh"
        ) from error
    except BusError:
        opened.close()
        raise
    return opened


def _configure(opened: socket.socket) -> None:
    opened.setblocking(False)
    try:  # beyond the system's limit, where we may
        opened.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BUFFER_BYTES)
    except PermissionError:
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    opened.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    opened.setsockopt(socket.SOL_SOCKET, SO_RXQ_OVFL, 1)
    errors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED
    opened.setsockopt(socket.SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors)


def _is_up(probe: socket.socket, name: str) -> bool:
    request = struct.pack("16sH14x", name.encode(), 0)
    try:
        answer = fcntl.ioctl(probe.fileno(), SIOCGIFFLAGS, request)
    except OSError:
        return False
    (flags,) = struct.unpack_from("H", answer, 16)
    return bool(flags & IFF_UP)
