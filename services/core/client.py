"""A client of a running stack, for commands and tests: blocking calls, new values, liveliness."""

import queue
from collections.abc import Callable
from types import TracebackType
from typing import TypeVar

import msgspec
import zenoh

from services.core.clock import Clock
from services.core.errors import CallFailedError
from services.core.link import Subscription, ask, publisher, subscribe
from services.core.loop import alive_key
from services.core.ports import CallPort, Refusals, StreamPort
from services.core.service import CallFailed, Inputs
from services.core.session import connect, disconnect
from services.core.stream import AnyStream, Call, Stream

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
RequestT = TypeVar("RequestT", bound=msgspec.Struct)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)

LIVELINESS_TIMEOUT_S = 1.0

_encode = msgspec.msgpack.Encoder().encode


class Client:
    """One session on a stack's hub."""

    def __init__(self, robot: str, endpoint: str, clock: Clock, timeout_s: float = 5.0) -> None:
        """Connect.

        Raises:
            HubUnreachableError: no hub there.
        """
        self._robot = robot
        self._clock = clock
        self._refusals = Refusals()
        self._watched: dict[AnyStream, tuple[Inputs, queue.SimpleQueue[tuple[zenoh.Sample, int]]]]
        self._watched = {}
        self._subscriptions: list[Subscription] = []
        self._publishers: dict[AnyStream, Callable[[bytes], None]] = {}
        self._session = connect(endpoint, timeout_s)

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def session(self) -> zenoh.Session:
        """For a LiveExecutor that runs a service inside this process."""
        return self._session

    def put(self, stream: Stream[MessageT], message: MessageT) -> None:
        """Publish a message."""
        if stream not in self._publishers:
            self._publishers[stream] = publisher(self._session, self._robot, stream)
        self._publishers[stream](_encode(message))

    def watch(self, stream: Stream[MessageT]) -> None:
        """Listen to a stream from now on."""
        if stream not in self._watched:
            arrived: queue.SimpleQueue[tuple[zenoh.Sample, int]] = queue.SimpleQueue()
            self._watched[stream] = (Inputs("client", (stream,)), arrived)
            now_ns = self._clock.now_ns
            subscription = subscribe(
                self._session, self._robot, stream, lambda sample: arrived.put((sample, now_ns()))
            )
            self._subscriptions.append(subscription)

    def listen(self, stream: Stream[MessageT], take: Callable[[MessageT], None]) -> None:
        """Have `take` called for every message from now on, in a thread of Zenoh's: be quick."""
        inputs = Inputs("client", (stream,))
        port = StreamPort(stream, self._refusals, wakes=False)

        def arrived(sample: zenoh.Sample) -> None:
            port.take(inputs, sample, self._clock.now_ns())
            for message in inputs.all_new(stream):
                take(message)
            inputs.end()

        self._subscriptions.append(subscribe(self._session, self._robot, stream, arrived))

    def new(self, stream: Stream[MessageT]) -> tuple[MessageT, ...]:
        """What has arrived since the last look, oldest first; the first look starts listening."""
        self.watch(stream)
        inputs, arrived = self._watched[stream]
        inputs.end()
        port = StreamPort(stream, self._refusals, wakes=False)
        while not arrived.empty():
            port.take(inputs, *arrived.get())
        return inputs.all_new(stream)

    def latest(self, stream: Stream[MessageT]) -> MessageT | None:
        """The newest message since the first look."""
        self.new(stream)
        return self._watched[stream][0].latest(stream)

    def call(
        self, call: Call[RequestT, ReplyT], request: RequestT, timeout_s: float | None = None
    ) -> ReplyT:
        """Ask and wait for the answer, by default as long as the call allows.

        Raises:
            CallFailedError: nobody serves the call, or the answer is late or unreadable.
        """
        port = CallPort(call)
        inputs = Inputs("client", (), calls=(call,))
        answers: queue.SimpleQueue[zenoh.Reply | None] = queue.SimpleQueue()
        port.expect(1)
        patience_s = call.timeout_s if timeout_s is None else timeout_s
        ask(self._session, self._robot, call, request, answers.put, patience_s)
        try:
            answer = answers.get(timeout=patience_s + 1.0)
        except queue.Empty:
            answer = None
        port.take(inputs, (1, answer), 0)
        ((_, reply),) = inputs.replies(call)
        if isinstance(reply, CallFailed):
            raise CallFailedError(reply.reason)
        return reply

    def alive(self) -> frozenset[str]:
        """Names of the processes that are at work."""
        tokens = self._session.liveliness().get(
            alive_key(self._robot, "*"), timeout=LIVELINESS_TIMEOUT_S
        )
        return frozenset(
            str(reply.ok.key_expr).rpartition("/")[2] for reply in tokens if reply.ok is not None
        )

    def close(self) -> None:
        """Leave the bus. A session that is closed while samples still arrive may wait for ever."""
        for subscription in self._subscriptions:
            subscription.undeclare()  # type: ignore[no-untyped-call]  # so in zenoh's stubs
        self._subscriptions.clear()
        disconnect(self._session)
