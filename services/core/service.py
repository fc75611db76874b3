"""What a service is, and the two windows through which it sees the world.

A service declares what it reads, writes, serves and calls, and does all its work in step(). An
executor (live, virtual) owns time, queues and the bus; the service cannot tell which one runs it.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol, TypeVar

import msgspec

from services.core.errors import ServiceError, UndeclaredUseError
from services.core.stream import AnyCall, AnyStream, Call, Stream

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
RequestT = TypeVar("RequestT", bound=msgspec.Struct)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)

NS_TO_S = 1e-9


@dataclass(frozen=True, slots=True)
class Period:
    """Trigger of a service that runs by the clock."""

    seconds: float


@dataclass(frozen=True, slots=True)
class CallFailed:
    """Stands where a reply would: nobody serves the call, or the answer is late or unreadable."""

    reason: str


class _Slot:
    """What has arrived on one stream."""

    __slots__ = ("arrival_ns", "latest", "new")

    def __init__(self) -> None:
        self.latest: Any = None
        self.arrival_ns = 0
        self.new: list[Any] = []


class Inputs:
    """What a service has received. Messages are shared, so they are frozen."""

    __slots__ = ("_dirty", "_now_ns", "_owner", "_replies", "_requests", "_slots", "late_ns")

    def __init__(
        self,
        owner: str,
        reads: tuple[AnyStream, ...],
        serves: tuple[AnyCall, ...] = (),
        calls: tuple[AnyCall, ...] = (),
    ) -> None:
        self._owner = owner
        self._slots: dict[AnyStream, _Slot] = {stream: _Slot() for stream in reads}
        self._requests: dict[AnyCall, list[Any]] = {call: [] for call in serves}
        self._replies: dict[AnyCall, list[Any]] = {call: [] for call in calls}
        self._dirty: list[list[Any]] = []
        self._now_ns = 0
        self.late_ns = 0
        """From when this step was due to when it began; 0 in virtual time. For statistics only."""

    def latest(self, stream: Stream[MessageT]) -> MessageT | None:
        """The newest message ever received, however old."""
        message: MessageT | None = self._slot(stream).latest
        return message

    def fresh(self, stream: Stream[MessageT], max_age_s: float) -> MessageT | None:
        """The newest message, if it arrived at most `max_age_s` ago."""
        slot = self._slot(stream)
        if slot.latest is None or (self._now_ns - slot.arrival_ns) * NS_TO_S > max_age_s:
            return None
        message: MessageT = slot.latest
        return message

    def new(self, stream: Stream[MessageT]) -> MessageT | None:
        """The newest message, if it arrived since this service's previous step."""
        slot = self._slot(stream)
        message: MessageT | None = slot.latest if slot.new else None
        return message

    def all_new(self, stream: Stream[MessageT]) -> tuple[MessageT, ...]:
        """Every message that arrived since this service's previous step, oldest first."""
        return tuple(self._slot(stream).new)

    def age_s(self, stream: Stream[MessageT]) -> float:
        """Time since the newest message arrived here; infinite before the first."""
        slot = self._slot(stream)
        return float("inf") if slot.latest is None else (self._now_ns - slot.arrival_ns) * NS_TO_S

    def requests(self, call: Call[RequestT, ReplyT]) -> tuple[tuple[int, RequestT], ...]:
        """Requests that arrived since the previous step, each with the token to answer it by."""
        try:
            return tuple(self._requests[call])
        except KeyError:
            self._refuse("serve", call, self._requests)

    def replies(self, call: Call[RequestT, ReplyT]) -> tuple[tuple[int, ReplyT | CallFailed], ...]:
        """Answers that arrived since the previous step, each with the token that call() gave."""
        try:
            return tuple(self._replies[call])
        except KeyError:
            self._refuse("call", call, self._replies)

    def deliver(self, stream: AnyStream, message: msgspec.Struct, arrival_ns: int) -> None:
        """Executors: a message has arrived."""
        slot = self._slots[stream]
        slot.latest = message
        slot.arrival_ns = arrival_ns
        if not slot.new:
            self._dirty.append(slot.new)
        slot.new.append(message)

    def deliver_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Executors: a request has arrived."""
        waiting = self._requests[call]
        waiting.append((token, request))
        self._dirty.append(waiting)

    def deliver_reply(self, call: AnyCall, token: int, reply: msgspec.Struct | CallFailed) -> None:
        """Executors: an answer has arrived."""
        waiting = self._replies[call]
        waiting.append((token, reply))
        self._dirty.append(waiting)

    def begin(self, now_ns: int, late_ns: int = 0) -> None:
        """Executors: a step starts, so late; ages count from `now_ns`."""
        self._now_ns = now_ns
        self.late_ns = late_ns

    def end(self) -> None:
        """Executors: the step is over; what it saw is no longer new."""
        if self._dirty:
            for waiting in self._dirty:
                waiting.clear()
            self._dirty.clear()

    def _slot(self, stream: AnyStream) -> _Slot:
        try:
            return self._slots[stream]
        except KeyError:
            self._refuse("read", stream, self._slots)

    def _refuse(self, verb: str, used: object, declared: Iterable[object]) -> NoReturn:
        raise UndeclaredUseError(undeclared(self._owner, verb, used, declared))


class Carrier(Protocol):
    """What an executor does with what a service sends."""

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Publish a message."""

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:
        """Answer a request."""

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Ask whoever serves the call."""


class Outputs:
    """What a service sends."""

    __slots__ = ("_calls", "_carrier", "_owner", "_serves", "_token", "_writes")

    def __init__(
        self,
        owner: str,
        carrier: Carrier,
        writes: tuple[AnyStream, ...],
        serves: tuple[AnyCall, ...] = (),
        calls: tuple[AnyCall, ...] = (),
    ) -> None:
        self._owner = owner
        self._carrier = carrier
        self._writes = frozenset(writes)
        self._serves = frozenset(serves)
        self._calls = frozenset(calls)
        self._token = 0

    def put(self, stream: Stream[MessageT], message: MessageT) -> None:
        """Publish a message; it is handed over as it is, so never change it afterwards."""
        if stream not in self._writes:
            raise UndeclaredUseError(undeclared(self._owner, "write", stream, self._writes))
        self._carrier.send(stream, message)

    def reply(self, call: Call[RequestT, ReplyT], token: int, reply: ReplyT) -> None:
        """Answer the request of that token, now or in a later step within the call's time limit."""
        if call not in self._serves:
            raise UndeclaredUseError(undeclared(self._owner, "serve", call, self._serves))
        self._carrier.send_reply(call, token, reply)

    def call(self, call: Call[RequestT, ReplyT], request: RequestT) -> int:
        """Send a request; Inputs.replies() of a later step has the answer under this token."""
        if call not in self._calls:
            raise UndeclaredUseError(undeclared(self._owner, "call", call, self._calls))
        self._token += 1
        self._carrier.send_request(call, self._token, request)
        return self._token


class Service(ABC):
    """Base of all services: declarations, one step, and the safe command at the end."""

    reads: tuple[AnyStream, ...] = ()
    writes: tuple[AnyStream, ...] = ()
    serves: tuple[AnyCall, ...] = ()
    calls: tuple[AnyCall, ...] = ()
    trigger: AnyStream | Period | tuple[AnyStream, ...]
    """A period, or streams that it reads: then a message, a request or a reply starts a step.

    Of several streams, what is sent in one step of its sender starts one step here; one that falls
    silent does not hold up the others.
    """
    timed: AnyStream | None = None
    """Durations are kept of steps with a message of it, which do the work; None: of all."""

    @abstractmethod
    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Do everything that is due now. Never wait."""

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: B027  most have nothing to do
        """Send the safe command and release what the constructor was given.

        Called once, when the process ends and also after an error in step().
        """


def is_timed(service: Service, inputs: Inputs) -> bool:
    """Whether the duration of the step that has just been made counts."""
    return service.timed is None or inputs.new(service.timed) is not None


def triggers(name: str, service: Service) -> tuple[AnyStream, ...]:
    """The streams that start a step; none where the service runs by the clock.

    Raises:
        ServiceError: it does not read one of them, or has neither period nor stream.
    """
    trigger = service.trigger
    if isinstance(trigger, Period):
        return ()
    streams = trigger if isinstance(trigger, tuple) else (trigger,)
    if not streams:
        raise ServiceError(f"{name} has no trigger: nothing would ever start a step")
    for stream in streams:
        if stream not in service.reads:
            raise ServiceError(f"{name} is triggered by {stream}, which it does not read")
    return streams


def undeclared(owner: str, verb: str, used: object, declared: Iterable[object]) -> str:
    """Sentence for the use of something that a service does not declare."""
    names = ", ".join(sorted(str(entry) for entry in declared)) or "nothing"
    return f"{owner} does not declare that it may {verb} {used}; it declares {names}"
