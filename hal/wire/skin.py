"""Tactile frames, class 4, or 3 after an old-style set-up: 12 taxels of a triangle in two frames.

The low nibble of the identifier is the triangle; byte 0 tells the two frames apart (can-protocol
7.3). The identifier alone does not make a frame a skin frame: class and sender do.
"""

import struct
from collections.abc import Iterable
from enum import IntEnum

from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_MANAGEMENT,
    CLASS_SKIN_PERIODIC,
    Frame,
    frame_id,
)
from hal.wire.layout import Field, Layout, u8
from hal.wire.message import PeriodicMessage

TRIANGLES = 16
TAXELS = 12  # of a triangle
HEAD_TAXELS = 7
BOARD_TAXELS = TRIANGLES * TAXELS

CLASSES = (CLASS_SKIN_PERIODIC, CLASS_ANALOG_PERIODIC)
"""Classes of skin frames: of a board set up with the new commands, and with the old ones."""

DEFAULT_NO_LOAD = 245  # a taxel at rest; pressure lowers it
DEFAULT_PERIOD_MS = 40
DEFAULT_CDC_OFFSET = 0x2200


class TriangleError(IntEnum):
    """Low nibble of the last byte of a tail."""

    OK = 0
    NO_ANSWER = 1  # on the triangle's I2C bus
    NOT_CONNECTED = 2


class TriangleMessage:
    """One of the two frames of a triangle; byte 0 is its code."""

    __slots__ = ("code", "layout", "name")

    def __init__(self, code: int, name: str, fields: Iterable[Field]) -> None:
        self.code = code
        self.name = name
        self.layout = Layout(fields, prefix=True)

    def frame(
        self, source: int, triangle: int, *values: int, can_class: int = CLASS_SKIN_PERIODIC
    ) -> Frame:
        """Frame sent by the board at `source`."""
        try:
            data = self.layout.pack(self.code, *values)
        except struct.error:
            raise self.layout.refusal(self.name, values) from None
        return frame_id(can_class, source, triangle), data

    def parse(self, data: bytes) -> tuple[int, ...] | None:
        """Values of the frame; None when its length or its byte 0 is another's."""
        if len(data) == self.layout.dlc and data[0] == self.code:
            return self.layout.unpack(data)
        return None


HEAD = TriangleMessage(0x40, "TRIANGLE_HEAD", [u8(f"taxel{i}") for i in range(HEAD_TAXELS)])
TAIL = TriangleMessage(
    0xC0,
    "TRIANGLE_TAIL",
    [
        *(u8(f"taxel{i}") for i in range(HEAD_TAXELS, TAXELS)),
        u8("out_of_range_4_to_11"),
        u8("out_of_range_0_to_3_and_error"),  # high nibble, low nibble
    ],
)

MESSAGES: dict[int, TriangleMessage] = {message.code: message for message in (HEAD, TAIL)}
"""Rows by byte 0."""

RECEIVE_OVERFLOW = PeriodicMessage(CLASS_MANAGEMENT, 0x5, "RECEIVE_OVERFLOW", Layout(()))
"""Empty frame of an MTB whose receive queue was full: no management command, but in their class."""


def tail_state(mask: int, error: int) -> tuple[int, int]:
    """The last two bytes of a tail; bit i of `mask` says that taxel i is out of range."""
    return mask >> 4 & 0xFF, (mask & 0xF) << 4 | error & 0xF


def out_of_range(high: int, low: int) -> int:
    """Mask of the taxels out of range, from the last two bytes of a tail."""
    return high << 4 | low >> 4


def error_of(low: int) -> int:
    """Error of the triangle (see TriangleError), from the last byte of a tail."""
    return low & 0xF
