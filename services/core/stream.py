"""Typed names: a stream carries one kind of message, a call one kind of request and its reply."""

from typing import Final, Generic, TypeVar, final

import msgspec

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
MessageT_co = TypeVar("MessageT_co", bound=msgspec.Struct, covariant=True)
RequestT = TypeVar("RequestT", bound=msgspec.Struct)
RequestT_co = TypeVar("RequestT_co", bound=msgspec.Struct, covariant=True)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)
ReplyT_co = TypeVar("ReplyT_co", bound=msgspec.Struct, covariant=True)

DEFAULT_CALL_TIMEOUT_S = 5.0  # requests are taken up or refused, never held for the work itself


@final
class Stream(Generic[MessageT_co]):
    """One stream.

    Two streams are the same only when they are the same object: streams.py makes each once.
    `rate_hz` is the nominal rate; 0 marks occasional values, whose last one late joiners are given.
    """

    __slots__ = ("message", "name", "rate_hz")

    def __init__(self, name: str, message: type[MessageT_co], rate_hz: float) -> None:
        self.name: Final = name
        self.message: Final = message
        self.rate_hz: Final = rate_hz

    def key(self, robot: str) -> str:
        """Key on the bus."""
        return f"{robot}/{self.name}"

    def __repr__(self) -> str:
        return f"Stream({self.name!r}, {self.message.__name__})"


@final
class PlacedStream(Generic[MessageT]):
    """A family of streams: the same message from several parts, sensors or processes."""

    __slots__ = ("_places", "message", "name", "rate_hz")

    def __init__(self, name: str, message: type[MessageT], rate_hz: float) -> None:
        self.name: Final = name
        self.message: Final = message
        self.rate_hz: Final = rate_hz
        self._places: dict[str, Stream[MessageT]] = {}

    def __getitem__(self, place: str) -> Stream[MessageT]:
        """The stream of one place; the same object every time."""
        stream = self._places.get(place)
        if stream is None:
            stream = Stream(f"{place}/{self.name}", self.message, self.rate_hz)
            self._places[place] = stream
        return stream

    def __repr__(self) -> str:
        return f"PlacedStream({self.name!r}, {self.message.__name__})"


@final
class Call(Generic[RequestT_co, ReplyT_co]):
    """One kind of request and its reply; exactly one service serves it."""

    __slots__ = ("name", "reply", "request", "timeout_s")

    def __init__(
        self,
        name: str,
        request: type[RequestT_co],
        reply: type[ReplyT_co],
        timeout_s: float = DEFAULT_CALL_TIMEOUT_S,
    ) -> None:
        self.name: Final = name
        self.request: Final = request
        self.reply: Final = reply
        self.timeout_s: Final = timeout_s

    def key(self, robot: str) -> str:
        """Key on the bus."""
        return f"{robot}/{self.name}"

    def __repr__(self) -> str:
        return f"Call({self.name!r})"


AnyStream = Stream[msgspec.Struct]
AnyCall = Call[msgspec.Struct, msgspec.Struct]
