"""A client's connection to a running stack of this host, which it finds by name."""

from types import TracebackType
from typing import Self, TypeVar

import msgspec

from services.core.client import Client
from services.core.clock import Clock, RealClock
from services.core.errors import CallFailedError, NotRunningError
from services.core.rundir import read_record, running
from services.core.stream import Call

RequestT = TypeVar("RequestT", bound=msgspec.Struct)
ReplyT = TypeVar("ReplyT", bound=msgspec.Struct)


class StackConnection:
    """Use it as a context manager."""

    def __init__(self, stack: str) -> None:
        """Connect.

        Raises:
            ServiceError: no such stack, or its hub does not answer.
        """
        try:
            self.record = read_record(stack)
        except NotRunningError as error:
            raise NotRunningError(f"{error}; start one with `ulna up`") from error
        self.stack = stack
        self.clock: Clock = RealClock()
        self.bus = Client(self.record.robot, self.record.endpoint, self.clock)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def check_up(self) -> None:
        """Raise NotRunningError once the stack has ended since this client connected."""
        here = (self.record.name, self.record.endpoint)
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

    def close(self) -> None:
        """Leave the bus."""
        self.bus.close()
