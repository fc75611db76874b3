"""Run all services in one process and in virtual time: deterministic, as fast as possible.

A tick is 1 ms. What is sent in tick t is visible from tick t + hop on; at one instant things happen
in the order (time, process row, sequence).
"""

import heapq
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec

from services.core.clock import NS_PER_MS, VirtualClock, wall_ns
from services.core.errors import ServiceError
from services.core.service import (
    CallFailed,
    Inputs,
    Outputs,
    Period,
    Service,
    is_timed,
    triggers,
)
from services.core.stream import AnyCall, AnyStream
from services.core.timing import Durations

TICKS_PER_S = 1000
NEVER = -1  # due tick of a service that only messages start


class _Node:
    """One service and what the executor keeps about it."""

    __slots__ = ("due", "inputs", "name", "outputs", "period", "service", "step_times", "woken")

    def __init__(self, name: str, service: Service, mail: "_Mail") -> None:
        self.name = name
        self.service = service
        self.inputs = Inputs(name, service.reads, service.serves, service.calls)
        carrier = _NodeCarrier(self, mail)
        self.outputs = Outputs(name, carrier, service.writes, service.serves, service.calls)
        self.period = _period_ticks(name, service)
        self.due = 0 if self.period else NEVER
        self.woken = False
        self.step_times = Durations()


_Target = tuple[_Node, bool]  # a reader, and whether the stream starts its step
_Posted = tuple[tuple[_Target, ...], AnyStream, msgspec.Struct]


@dataclass(slots=True)
class _PendingCall:
    """A request on its way, until its answer has been delivered."""

    caller: _Node
    token: int  # the caller's
    call: AnyCall


class _Mail:
    """What has been sent in this tick, and the requests that wait for an answer."""

    def __init__(self) -> None:
        self.posted: list[_Posted] = []
        self.letters: list[Callable[[], None]] = []  # requests and replies: rare, so a closure each
        self.targets: dict[AnyStream, tuple[_Target, ...]] = {}
        self.servers: dict[AnyCall, _Node] = {}
        self.pending: dict[int, _PendingCall] = {}
        self.deadlines: list[tuple[int, int]] = []  # heap of (tick, key of pending)
        self.tick = 0
        self._key = 0

    def ask(self, caller: _Node, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Send a request to the service that serves it."""
        server = self.servers.get(call)
        if server is None:
            refusal = CallFailed(f"nobody serves {call.name}")
            self.letters.append(lambda: _hand_reply(caller, call, token, refusal))
            return
        self._key += 1
        key = self._key
        self.pending[key] = _PendingCall(caller, token, call)
        heapq.heappush(self.deadlines, (self.tick + round(call.timeout_s * TICKS_PER_S), key))
        self.letters.append(lambda: _hand_request(server, call, key, request))

    def answer(self, key: int, reply: msgspec.Struct | CallFailed) -> None:
        """Send an answer back; one that comes too late finds nobody waiting."""
        pending = self.pending.pop(key, None)
        if pending is not None:
            self.letters.append(
                lambda: _hand_reply(pending.caller, pending.call, pending.token, reply)
            )

    def expire(self) -> None:
        """Fail the requests whose time is up."""
        while self.deadlines and self.deadlines[0][0] <= self.tick:
            _, key = heapq.heappop(self.deadlines)
            pending = self.pending.get(key)
            if pending is not None:
                call = pending.call
                self.answer(key, CallFailed(f"{call.name}: no answer in {call.timeout_s:g} s"))


class _NodeCarrier:
    """Takes what one service sends."""

    __slots__ = ("_mail", "_node")

    def __init__(self, node: _Node, mail: _Mail) -> None:
        self._node = node
        self._mail = mail

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        mail = self._mail
        mail.posted.append((mail.targets[stream], stream, message))

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:  # noqa: ARG002
        self._mail.answer(token, reply)

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        self._mail.ask(self._node, call, token, request)


class VirtualExecutor:
    """Runs services, named and in the order of the process table, by ticks of 1 ms."""

    def __init__(
        self, clock: VirtualClock, services: Mapping[str, Service], hop_ticks: int = 1
    ) -> None:
        if hop_ticks < 1:
            raise ServiceError(f"a hop takes at least one tick, not {hop_ticks}")
        self._clock = clock
        self._mail = _Mail()
        self._nodes = [_Node(name, service, self._mail) for name, service in services.items()]
        self._mail.targets = _targets(self._nodes)
        self._mail.servers = _servers(self._nodes)
        hops: list[tuple[list[_Posted], list[Callable[[], None]]]] = [
            ([], []) for _ in range(hop_ticks)
        ]
        self._under_way = deque(hops)  # sent in the last hop_ticks ticks, oldest first

    @property
    def ticks(self) -> int:
        """Ticks run so far."""
        return self._mail.tick

    def put(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Send a message from outside, as if a service had sent it in the coming tick."""
        self._mail.posted.append((self._mail.targets.get(stream, ()), stream, message))

    def tick(self) -> None:
        """Run one millisecond: deliver, step what is due in row order, move the clock."""
        mail = self._mail
        now_ns = self._clock.now_ns()
        self._deliver(now_ns)
        tick = mail.tick
        for node in self._nodes:
            if node.due == tick or node.woken:
                self._step(node, now_ns)
                if node.due == tick:
                    node.due = tick + node.period
        self._under_way.append((mail.posted, mail.letters))
        mail.posted, mail.letters = [], []
        mail.tick = tick + 1
        self._clock.advance_ns(NS_PER_MS)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> bool:
        """Run for that long, or until the condition holds after a tick; returns whether it held."""
        for _ in range(round(seconds * TICKS_PER_S)):
            self.tick()
            if until is not None and until():
                return True
        return False

    def close(self) -> None:
        """Let every service send its safe command, last row first."""
        for node in reversed(self._nodes):
            node.service.close(self._clock.now_ns(), node.outputs)

    def step_times(self, name: str) -> Durations:
        """How long the steps of one service took on the wall."""
        for node in self._nodes:
            if node.name == name:
                return node.step_times
        raise ServiceError(f"no service {name!r}; there are: {[node.name for node in self._nodes]}")

    def _deliver(self, now_ns: int) -> None:
        posted, letters = self._under_way.popleft()
        for targets, stream, message in posted:
            for node, wakes in targets:
                node.inputs.deliver(stream, message, now_ns)
                if wakes:
                    node.woken = True
        for letter in letters:
            letter()
        if self._mail.deadlines:
            self._mail.expire()

    def _step(self, node: _Node, now_ns: int) -> None:
        node.woken = False
        inputs = node.inputs
        inputs.begin(now_ns)
        start_ns = wall_ns()
        try:
            node.service.step(now_ns, inputs, node.outputs)
        except Exception as error:
            error.add_note(f"in service {node.name!r}, at {now_ns / NS_PER_MS:.0f} ms")
            raise
        if is_timed(node.service, inputs):
            node.step_times.add(wall_ns() - start_ns)
        inputs.end()


def _period_ticks(name: str, service: Service) -> int:
    """Period of a service in ticks; 0 where messages start it."""
    if triggers(name, service) or not isinstance(service.trigger, Period):
        return 0
    ticks = service.trigger.seconds * TICKS_PER_S
    if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-6:
        raise ServiceError(f"{name}: a period of {service.trigger.seconds} s is not whole ticks")
    return round(ticks)


def _targets(nodes: list[_Node]) -> dict[AnyStream, tuple[_Target, ...]]:
    """Who reads each stream, in row order."""
    streams = dict.fromkeys(
        s for node in nodes for s in (*node.service.reads, *node.service.writes)
    )
    starts = {node: triggers(node.name, node.service) for node in nodes}
    return {
        stream: tuple(
            (node, stream in starts[node]) for node in nodes if stream in node.service.reads
        )
        for stream in streams
    }


def _servers(nodes: list[_Node]) -> dict[AnyCall, _Node]:
    """Who serves each call."""
    servers: dict[AnyCall, _Node] = {}
    for node in nodes:
        for call in node.service.serves:
            if call in servers:
                raise ServiceError(f"{call.name} is served by {servers[call].name} and {node.name}")
            servers[call] = node
    return servers


def _hand_request(server: _Node, call: AnyCall, key: int, request: msgspec.Struct) -> None:
    server.inputs.deliver_request(call, key, request)
    server.woken = server.woken or not server.period


def _hand_reply(
    caller: _Node, call: AnyCall, token: int, reply: msgspec.Struct | CallFailed
) -> None:
    caller.inputs.deliver_reply(call, token, reply)
    caller.woken = caller.woken or not caller.period
