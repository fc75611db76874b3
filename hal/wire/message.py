"""Rows of the frame tables: a polled command of one axis or board, and a periodic message.

Encoding a value that does not fit raises WireError. Decoding never raises: a payload of the wrong
length gives None. Byte 0 of a command is not checked again: the caller looked the command up by it.
"""

import struct
from collections.abc import Iterable

from hal.wire.can import CLASS_MOTOR_POLLING, HOST, Frame, frame_id
from hal.wire.layout import Field, Layout, WireError

AXIS_BIT = 0x80
CODE_MASK = 0x7F

Payload = Iterable[Field] | Layout
"""Fields behind byte 0, or a layout of its own kind that has room for byte 0."""


def _compiled(payload: Payload, order: str) -> Layout:
    return payload if isinstance(payload, Layout) else Layout(payload, order=order, prefix=True)


class PolledMessage:
    """What a command of any polling class is: code, name, a request and maybe a reply."""

    __slots__ = ("_base", "code", "lenient", "name", "reply_layout", "request_layout")

    def __init__(
        self,
        can_class: int,
        code: int,
        name: str,
        request: Payload = (),
        reply: Payload | None = None,
        *,
        order: str = "<",
        lenient: bool = False,
    ) -> None:
        """`order` is "<" (little-endian) or ">"; `lenient` takes a request of any length."""
        self._base = frame_id(can_class, HOST, HOST)
        self.code = code
        self.name = name
        self.lenient = lenient
        self.request_layout = _compiled(request, order)
        self.reply_layout = None if reply is None else _compiled(reply, order)

    def parse_request(self, data: bytes) -> tuple[int, ...] | None:
        """Values of a request; None when its length is wrong and the board would drop it."""
        layout = self.request_layout
        if len(data) == layout.dlc:
            return layout.unpack(data)
        return layout.parse_lenient(data) if self.lenient else layout.parse(data)

    def parse_reply(self, data: bytes) -> tuple[int, ...] | None:
        """Values of a reply; None when its length is wrong or the command has no reply."""
        layout = self.reply_layout
        if layout is None:
            return None
        if len(data) == layout.dlc:
            return layout.unpack(data)
        return layout.parse(data)

    def _reply_layout(self) -> Layout:
        if self.reply_layout is None:
            raise WireError(f"{self.name} has no reply")
        return self.reply_layout


class Command(PolledMessage):
    """A command of class 2 or 7: byte 0 is the code. Boards check no length in these classes."""

    __slots__ = ()

    def __init__(
        self,
        can_class: int,
        code: int,
        name: str,
        request: Payload = (),
        reply: Payload | None = None,
        *,
        order: str = "<",
    ) -> None:
        """`order` is "<" (little-endian) or ">"."""
        super().__init__(can_class, code, name, request, reply, order=order, lenient=True)

    def request(self, address: int, *values: int) -> Frame:
        """Frame from the host to a board."""
        try:
            return self._base | address, self.request_layout.pack(self.code, *values)
        except struct.error:
            raise self.request_layout.refusal(self.name, values) from None

    def reply(self, source: int, *values: int) -> Frame:
        """Frame from a board to the host."""
        layout = self._reply_layout()
        try:
            return self._base | source << 4, layout.pack(self.code, *values)
        except struct.error:
            raise layout.refusal(self.name, values) from None


class AxisCommand(PolledMessage):
    """A motor command (class 0): bit 7 of byte 0 selects axis 0 or 1 of the address."""

    __slots__ = ()

    def __init__(
        self,
        code: int,
        name: str,
        request: Payload = (),
        reply: Payload | None = None,
        *,
        lenient: bool = False,
    ) -> None:
        """A command with a reply is a GET, whose request DSP boards take at any length."""
        super().__init__(
            CLASS_MOTOR_POLLING, code, name, request, reply, lenient=lenient or reply is not None
        )

    def request(self, address: int, axis: int, *values: int) -> Frame:
        """Frame from the host to the board that owns `axis` (0 or 1) at `address`."""
        try:
            return address, self.request_layout.pack(self.code | axis << 7, *values)
        except struct.error:
            raise self.request_layout.refusal(self.name, values) from None

    def reply(self, source: int, axis: int, *values: int) -> Frame:
        """Frame from the board at `source` to the host, about its `axis`."""
        layout = self._reply_layout()
        try:
            return source << 4, layout.pack(self.code | axis << 7, *values)
        except struct.error:
            raise layout.refusal(self.name, values) from None


class PeriodicMessage:
    """A broadcast of a periodic class; the low nibble of the identifier is its type."""

    __slots__ = ("_base", "layout", "mask_bit", "name", "type")

    def __init__(
        self, can_class: int, kind: int, name: str, layout: Layout, *, mask_bit: int = 0
    ) -> None:
        """`mask_bit` is the message's bit in SET_BCAST_POLICY, 0 when it has none."""
        self._base = frame_id(can_class, HOST, kind)
        self.type = kind
        self.name = name
        self.layout = layout
        self.mask_bit = mask_bit

    def frame(self, source: int, *values: int) -> Frame:
        """Frame sent by the board at `source`."""
        try:
            return self._base | source << 4, self.layout.pack(*values)
        except struct.error:
            raise self.layout.refusal(self.name, values) from None

    def parse(self, data: bytes) -> tuple[int, ...] | None:
        """Values of the message; None when its length is wrong."""
        layout = self.layout
        if len(data) == layout.dlc:
            return layout.unpack(data)
        return layout.parse(data)
