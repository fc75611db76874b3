"""One service's end of the Zenoh bus: its subscriptions, publishers, queryables and requests.

Zenoh's threads only append to a deque and call `wake`; all else is done by the thread that steps
the service. Payloads are MessagePack of the stream's message type.
"""

from collections import deque
from collections.abc import Callable
from typing import Any

import msgspec
import zenoh

from hal.buses.zenoh import in_network_thread
from services.core.clock import Clock
from services.core.ports import CallPort, Port, Refusals, ServePort, StreamPort, encoding_of
from services.core.service import Inputs, Service, triggers
from services.core.stream import AnyCall, AnyStream

INBOX_LIMIT = 10_000  # arrivals; some seconds of everything that one process reads
CONTROL_FROM_HZ = 50.0  # control streams go ahead of everything else

Subscription = zenoh.Subscriber[None] | zenoh.ext.AdvancedSubscriber[None]

_encode = msgspec.msgpack.Encoder().encode


class Link:
    """Connects one service; also the Carrier of its outputs."""

    def __init__(
        self,
        session: zenoh.Session,
        robot: str,
        service: Service,
        clock: Clock,
        wake: Callable[[], None] | None,
    ) -> None:
        """`wake` is called in Zenoh's threads after an arrival that starts a step; None = never."""
        self.oldest_ns = 0  # arrival of the first item that starts the coming step
        self.refusals = Refusals()
        self._session = session
        self._robot = robot
        self._now_ns = clock.now_ns
        self._wake = wake
        self._inbox: deque[tuple[Port, Any, int]] = deque()
        self._publishers = {s: publisher(session, robot, s) for s in service.writes}
        self._calls = {call: CallPort(call) for call in service.calls}
        self._serves = {call: ServePort(call, self.refusals) for call in service.serves}
        self._declared: list[Subscription | zenoh.Queryable[None]] = []
        started_by = triggers(type(service).__name__, service)
        for stream in service.reads:
            port = StreamPort(stream, self.refusals, wakes=stream in started_by)
            taker = self._taker(port, wakes=port.wakes)
            self._declared.append(subscribe(session, robot, stream, taker))
        for call, serve_port in self._serves.items():
            handler = in_network_thread(self._taker(serve_port, wakes=True))
            self._declared.append(
                session.declare_queryable(call.key(robot), handler, complete=True)
            )

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Carrier: publish."""
        self._publishers[stream](_encode(message))

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:
        """Carrier: answer a request."""
        self._serves[call].answer(call.key(self._robot), token, _encode(reply))

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Carrier: ask; the answer arrives like a sample."""
        port = self._calls[call]
        port.expect(token)
        take = self._taker(port, wakes=True)
        ask(self._session, self._robot, call, request, lambda reply: take((token, reply)))

    def drain(self, inputs: Inputs) -> bool:
        """Hand over all that has arrived; true where something did that starts a step."""
        inbox = self._inbox
        woken = False
        for _ in range(len(inbox)):
            port, item, stamp_ns = inbox.popleft()
            if port.take(inputs, item, stamp_ns) and not woken:
                woken = True
                self.oldest_ns = stamp_ns
        return woken

    def forget_late_requests(self, now_ns: int) -> None:
        """Let go of requests that the service has not answered in time."""
        for port in self._serves.values():
            port.forget(now_ns)

    def close(self) -> None:
        """Listen no more; what is sent still goes out."""
        for declared in self._declared:
            declared.undeclare()  # type: ignore[no-untyped-call]  # so in zenoh's stubs
        self._declared.clear()

    def _taker(self, port: Port, wakes: bool) -> Callable[[Any], None]:
        """What Zenoh calls in its own thread."""
        inbox, now_ns = self._inbox, self._now_ns
        wake = self._wake if wakes else None

        def take(item: object) -> None:
            stamp_ns = now_ns()
            if len(inbox) >= INBOX_LIMIT:
                self.refusals.note("inbox", "full, the service does not keep up", stamp_ns)
                return
            inbox.append((port, item, stamp_ns))
            if wake is not None:
                wake()

        return take


def publisher(session: zenoh.Session, robot: str, stream: AnyStream) -> Callable[[bytes], None]:
    """What sends encoded messages of a stream. A full queue drops them: never hold up a step.

    Late joiners get the last one of occasional values, for as long as their sender lives.
    Not express: four streams at 1 kHz then arrive as early or earlier for half the hub's work,
    while express, one message in each of the queue's two batches, lost one in a thousand.
    """
    control = stream.rate_hz >= CONTROL_FROM_HZ
    priority = zenoh.Priority.REAL_TIME if control else zenoh.Priority.DATA
    if stream.rate_hz > 0:
        plain = session.declare_publisher(
            stream.key(robot),
            encoding=encoding_of(stream.message),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=priority,
        )
        return plain.put
    advanced = zenoh.ext.declare_advanced_publisher(
        session,
        stream.key(robot),
        encoding=encoding_of(stream.message),
        congestion_control=zenoh.CongestionControl.DROP,
        priority=priority,
        cache=zenoh.ext.CacheConfig(max_samples=1),
        publisher_detection=True,
    )
    return advanced.put


def subscribe(
    session: zenoh.Session, robot: str, stream: AnyStream, take: Callable[[zenoh.Sample], None]
) -> Subscription:
    """Have `take` called for every sample of a stream, in Zenoh's own thread."""
    handler = in_network_thread(take)
    if stream.rate_hz > 0:
        return session.declare_subscriber(stream.key(robot), handler)
    return zenoh.ext.declare_advanced_subscriber(
        session,
        stream.key(robot),
        handler,
        history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1),
    )


def ask(
    session: zenoh.Session,
    robot: str,
    call: AnyCall,
    request: msgspec.Struct,
    take: Callable[[zenoh.Reply | None], None],
    timeout_s: float | None = None,
) -> None:
    """Send a request; `take` is called with the answer, and with None behind the last one."""
    handler: zenoh.handlers.Callback[zenoh.Reply] = in_network_thread(take, lambda: take(None))
    session.get(
        call.key(robot),
        handler,
        payload=_encode(request),
        encoding=encoding_of(call.request),
        timeout=call.timeout_s if timeout_s is None else timeout_s,
        consolidation=zenoh.ConsolidationMode.NONE,
    )
