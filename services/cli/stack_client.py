"""A command's connection to a running stack."""

import functools
from typing import TypeVar

import msgspec

from services.config import load_robot
from services.core.clock import NS_PER_MS, NS_PER_S
from services.core.connection import StackConnection
from services.core.errors import ServiceError
from services.core.stream import Stream
from services.robotfile.robot_tables import RobotFile

MessageT = TypeVar("MessageT", bound=msgspec.Struct)

PATIENCE_S = 3.0
LOOK_NS = 20 * NS_PER_MS


class StackClient(StackConnection):
    """One client of a stack. Use it as a context manager."""

    @functools.cached_property
    def robot(self) -> RobotFile:
        """What the stack runs.

        Raises:
            ConfigError: its file cannot be read any more.
        """
        return load_robot(self.record.reference or self.record.robot)

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
