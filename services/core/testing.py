"""A bench for one service: virtual time, no network, every output kept."""

from collections.abc import Mapping
from typing import Any, TypeVar

import msgspec

from services.core.clock import NS_PER_S, VirtualClock
from services.core.service import CallFailed, Inputs, Outputs, Period, Service, triggers
from services.core.stream import AnyCall, AnyStream, Call, Stream

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
RequestT = TypeVar("RequestT", bound=msgspec.Struct)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)


class Bench:
    """Feeds a service and keeps what it sends. Also the Carrier of its outputs."""

    def __init__(self, service: Service, clock: VirtualClock | None = None) -> None:
        self.service = service
        self.clock = clock or VirtualClock()
        self.steps = 0
        self.late_ns = 0  # that steps begin, as a live executor would measure it
        name = type(service).__name__
        self._triggers = triggers(name, service)
        self._inputs = Inputs(name, service.reads, service.serves, service.calls)
        self._outputs = Outputs(name, self, service.writes, service.serves, service.calls)
        self._sent: dict[AnyStream, list[Any]] = {stream: [] for stream in service.writes}
        self._replies: dict[AnyCall, list[Any]] = {call: [] for call in service.serves}
        self._requests: dict[AnyCall, list[Any]] = {call: [] for call in service.calls}
        self._due_ns = self.clock.now_ns()
        self._token = 0

    def put(self, stream: Stream[MessageT], message: MessageT) -> None:
        """A message arrives now; where it is the trigger, the service steps at once."""
        self._inputs.deliver(stream, message, self.clock.now_ns())
        if stream in self._triggers:
            self.step()

    def put_together(self, messages: Mapping[Stream[MessageT], MessageT]) -> None:
        """Messages that were sent in one step arrive now; they start one step at most."""
        for stream, message in messages.items():
            self._inputs.deliver(stream, message, self.clock.now_ns())
        if any(stream in self._triggers for stream in messages):
            self.step()

    def request(self, call: Call[RequestT, ReplyT], request: RequestT) -> int:
        """A request arrives now; the token finds its reply."""
        self._token += 1
        self._inputs.deliver_request(call, self._token, request)
        self._step_unless_periodic()
        return self._token

    def answer(self, call: Call[RequestT, ReplyT], token: int, reply: ReplyT | CallFailed) -> None:
        """The reply to one of the service's own requests arrives now."""
        self._inputs.deliver_reply(call, token, reply)
        self._step_unless_periodic()

    def advance(self, seconds: float) -> None:
        """Let time pass; a periodic service steps at every due instant, the first one included."""
        end_ns = self.clock.now_ns() + round(seconds * NS_PER_S)
        trigger = self.service.trigger
        if isinstance(trigger, Period):
            while self._due_ns <= end_ns:
                self.clock.sleep_until(self._due_ns)
                self.step()
                self._due_ns += round(trigger.seconds * NS_PER_S)
        self.clock.sleep_until(end_ns)

    def step(self) -> None:
        """Run one step now."""
        now_ns = self.clock.now_ns()
        self._inputs.begin(now_ns, self.late_ns)
        self.service.step(now_ns, self._inputs, self._outputs)
        self._inputs.end()
        self.steps += 1

    def close(self) -> None:
        """End the service."""
        self.service.close(self.clock.now_ns(), self._outputs)

    def last(self, stream: Stream[MessageT]) -> MessageT:
        """The newest message that the service sent; an error where it has sent none."""
        message: MessageT = self._sent[stream][-1]
        return message

    def sent(self, stream: Stream[MessageT]) -> list[MessageT]:
        """Every message that the service has sent on a stream."""
        return list(self._sent[stream])

    def replies(self, call: Call[RequestT, ReplyT]) -> list[tuple[int, ReplyT]]:
        """Every reply that the service has given."""
        return list(self._replies[call])

    def requests(self, call: Call[RequestT, ReplyT]) -> list[tuple[int, RequestT]]:
        """Every request that the service has made."""
        return list(self._requests[call])

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Carrier: keep a message."""
        self._sent[stream].append(message)

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:
        """Carrier: keep a reply."""
        self._replies[call].append((token, reply))

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Carrier: keep a request."""
        self._requests[call].append((token, request))

    def _step_unless_periodic(self) -> None:
        if not isinstance(self.service.trigger, Period):
            self.step()
