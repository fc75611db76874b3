"""A command's connection to a running stack."""

from types import TracebackType
from typing import Self, TypeVar

import msgspec

from services.config import load_robot
from services.core.client import Client
from services.core.clock import NS_PER_MS, NS_PER_S, Clock, RealClock
from services.core.errors import CallFailedError, NotRunningError, ServiceError
from services.core.rundir import read_record, running
from services.core.stream import Call, Stream

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
RequestT = TypeVar("RequestT", bound=msgspec.Struct)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)

PATIENCE_S = 3.0
LOOK_NS = 20 * NS_PER_MS


class StackClient:
    """One client of a stack. Use it as a context manager."""

    def __init__(self, stack: str) -> None:
        """Connect.

        Raises:
            ServiceError: no such stack, or its hub does not answer.
        """
        try:
            record = read_record(stack)
        except NotRunningError as error:
            raise NotRunningError(f"{error}; start one with `ulna up`") from error
        self.robot = load_robot(record.reference or record.robot)
        self.clock: Clock = RealClock()
        self.bus = Client(record.robot, record.endpoint, self.clock)
        self.stack = stack
        self._endpoint = record.endpoint

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.bus.close()

    def check_up(self) -> None:
        """Raise NotRunningError once the stack has ended since this client connected."""
        here = (self.stack, self._endpoint)
        if here not in [(record.name, record.endpoint) for record in running()]:
            raise NotRunningError(f"the stack {self.stack!r} has gone; start it with `ulna up`")

    def call(self, call: Call[RequestT, ReplyT], request: RequestT) -> ReplyT:
        """Ask and wait for the answer.

        Raises:
            ServiceError: the stack has gone, nobody serves the call, or no answer comes.
        """
        try:
            return self.bus.call(call, request)
        except CallFailedError:
            self.check_up()
            raise

    def next_of(self, stream: Stream[MessageT], patience_s: float = PATIENCE_S) -> MessageT | None:
        """The next message of a stream; None when none comes in that time."""
        end_ns = self.clock.now_ns() + round(patience_s * NS_PER_S)
        while True:
            messages = self.bus.new(stream)
            if messages:
                return messages[-1]
            if self.clock.now_ns() >= end_ns:
                return None
            self.clock.sleep_until(self.clock.now_ns() + LOOK_NS)

    def wait_for(self, stream: Stream[MessageT], patience_s: float = PATIENCE_S) -> MessageT:
        """The next message of a stream.

        Raises:
            ServiceError: none comes; the text says what to look at.
        """
        message = self.next_of(stream, patience_s)
        if message is None:
            self.check_up()
            raise self.silence(stream.name)
        return message

    def silence(self, name: str) -> ServiceError:
        """What to say of a stream that is silent though the stack is up."""
        if "robot" not in self.bus.alive():
            return ServiceError(
                f"no robot process in stack {self.stack!r}: it has ended; see `ulna up`'s log"
            )
        return ServiceError(f"{name} is silent; see `ulna up`'s log")
