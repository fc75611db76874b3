"""Many CAN frames in one system call: sendmmsg and recvmmsg, which Python's socket module lacks.

One call for each frame costs 1 us on bare metal and 16 us on the virtual kernels that tests run on;
with some 25 frames a millisecond and bus, that is the difference between a loop that keeps its time
and one that does not.
"""

import ctypes
import os
import socket
import struct
from collections.abc import Sequence

from hal.wire.can import Frame

BATCH = 64  # frames in one call
FRAME = struct.Struct("=IB3x8s")  # struct can_frame
# Two control messages at most: the kernel's time stamp (struct timespec), then the drop count.
CONTROL = struct.Struct("@NiiqqNiiI4x")
STAMP_ONLY = 32  # bytes of the first
NS_PER_S = 1_000_000_000

RawFrame = tuple[int, int, bytes]
"""Identifier with the kernel's flags, length, eight data bytes."""


class _Iovec(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Header(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_void_p),
        ("name_length", ctypes.c_uint32),
        ("iov", ctypes.c_void_p),
        ("iov_length", ctypes.c_size_t),
        ("control", ctypes.c_void_p),
        ("control_length", ctypes.c_size_t),
        ("flags", ctypes.c_int),
    )


class _Message(ctypes.Structure):
    _fields_ = (("header", _Header), ("length", ctypes.c_uint32))


class KernelBatch:
    """Buffers for one direction of one socket, set up once."""

    def __init__(self) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        self._sendmmsg, self._recvmmsg = libc.sendmmsg, libc.recvmmsg
        self._frames = bytearray(FRAME.size * BATCH)
        self._controls = bytearray(CONTROL.size * BATCH)
        self._messages = (_Message * BATCH)()
        self._iovecs = (_Iovec * BATCH)()
        frames = _address(self._frames)
        controls = _address(self._controls)
        for index, message in enumerate(self._messages):
            iovec = self._iovecs[index]
            iovec.base, iovec.length = frames + index * FRAME.size, FRAME.size
            message.header.iov, message.header.iov_length = ctypes.addressof(iovec), 1
            message.header.control = controls + index * CONTROL.size

        self._control_dirty = BATCH  # messages whose control length must be set before receiving

    def send(self, opened: socket.socket, frames: Sequence[Frame]) -> int:
        """Send up to BATCH frames; how many the kernel took.

        Raises:
            OSError: it took none.
        """
        offset = 0
        for can_id, data in frames:
            FRAME.pack_into(self._frames, offset, can_id, len(data), data)
            offset += FRAME.size
        sent: int = self._sendmmsg(opened.fileno(), self._messages, len(frames), 0)
        if sent < 0:
            raise _last_error()
        return sent

    def receive(self, opened: socket.socket) -> tuple[list[RawFrame], list[int], int | None]:
        """Up to BATCH frames, their arrival by the clock of the day [ns], and the drop count.

        The drop count is None where the kernel tells none: as long as it has dropped nothing.

        Raises:
            OSError: there is no frame (EAGAIN), or the socket is unusable.
        """
        for index in range(self._control_dirty):  # the last call has written over the lengths
            self._messages[index].header.control_length = CONTROL.size
        count: int = self._recvmmsg(opened.fileno(), self._messages, BATCH, 0, None)
        self._control_dirty = max(count, 0)
        if count < 0:
            raise _last_error()
        frames = list(FRAME.iter_unpack(memoryview(self._frames)[: count * FRAME.size]))
        controls = list(CONTROL.iter_unpack(memoryview(self._controls)[: count * CONTROL.size]))
        stamps_ns = [control[3] * NS_PER_S + control[4] for control in controls]
        told = self._messages[count - 1].header.control_length > STAMP_ONLY
        return frames, stamps_ns, controls[-1][8] if told else None


def _address(buffer: bytearray) -> int:
    """Where the bytes are; the buffer must not be resized."""
    return ctypes.addressof((ctypes.c_char * len(buffer)).from_buffer(buffer))


def _last_error() -> OSError:
    number = ctypes.get_errno()
    return OSError(number, os.strerror(number))
