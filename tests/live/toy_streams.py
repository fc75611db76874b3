"""Messages, streams and calls of the toy processes."""

import msgspec

from services.core.stream import Call, Stream


class Ping(msgspec.Struct, frozen=True, array_like=True):
    """A number and when it was sent."""

    stamp_ns: int
    number: int


class Order(msgspec.Struct, frozen=True, array_like=True):
    """What a toy is to do: answer, ignore, or fail."""

    action: str


class Done(msgspec.Struct, frozen=True, array_like=True):
    """A toy's answer."""

    text: str


PING = Stream("toy/ping", Ping, rate_hz=1000)
PONG = Stream("toy/pong", Ping, rate_hz=1000)
SETTING = Stream("toy/setting", Ping, rate_hz=0)
FAREWELL = Stream("toy/farewell", Ping, rate_hz=0)
ORDER = Call("toy/order", Order, Done, timeout_s=1.0)
