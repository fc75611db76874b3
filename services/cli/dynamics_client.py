"""A command's conversation with the dynamics service of a running stack."""

import sys
from collections.abc import Sequence
from types import TracebackType
from typing import TypeVar

import msgspec

from services.config import load_robot
from services.core.client import Client
from services.core.clock import NS_PER_MS, NS_PER_S, RealClock
from services.core.errors import NotRunningError, ServiceError
from services.core.rundir import read_record
from services.core.stream import Stream
from services.dynamics_messages import DynamicsHealth, DynamicsRequest
from services.streams import DYNAMICS_CALL, DYNAMICS_HEALTH

MessageT = TypeVar("MessageT", bound=msgspec.Struct)

PATIENCE_S = 3.0
SHORT_PATIENCE_S = 0.5
CALIBRATION_PATIENCE_S = 120.0
LOOK_NS = 20 * NS_PER_MS


class DynamicsClient:
    """One client of a stack."""

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
        self.clock = RealClock()
        self.bus = Client(record.robot, record.endpoint, self.clock)
        self._stack = stack

    def __enter__(self) -> "DynamicsClient":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.bus.close()

    def ask(self, request: DynamicsRequest) -> bool:
        """Send a request and print what the service says; whether it was taken up."""
        reply = self.bus.call(DYNAMICS_CALL, request)
        if reply.reason:
            print(reply.reason, file=sys.stdout if reply.ok else sys.stderr)
        return reply.ok

    def wait_for(self, stream: Stream[MessageT], patience_s: float = PATIENCE_S) -> MessageT:
        """The next message of a stream.

        Raises:
            ServiceError: none comes; the text says what to look at.
        """
        end_ns = self.clock.now_ns() + round(patience_s * NS_PER_S)
        while True:
            messages = self.bus.new(stream)
            if messages:
                return messages[-1]
            if self.clock.now_ns() >= end_ns:
                if "dynamics" not in self.bus.alive():
                    raise ServiceError(
                        f"no dynamics process in stack {self._stack!r}: its parts have no "
                        f"force/torque sensor, or it has ended; see `ulna up`'s log"
                    )
                raise ServiceError(
                    f"{stream.name} is silent: the HAL sends neither wrenches nor joint states; "
                    f"are the boards powered and found (`ulna can scan`)?"
                )
            self.clock.sleep_until(self.clock.now_ns() + LOOK_NS)

    def newest(self, stream: Stream[MessageT]) -> MessageT | None:
        """The next message of a stream that may rightly be silent."""
        end_ns = self.clock.now_ns() + round(SHORT_PATIENCE_S * NS_PER_S)
        while not self.bus.new(stream) and self.clock.now_ns() < end_ns:
            self.clock.sleep_until(self.clock.now_ns() + LOOK_NS)
        return self.bus.latest(stream)

    def wait_for_calibration(self, sensors: Sequence[str]) -> DynamicsHealth:
        """Health once no named sensor (none named: no sensor) is being calibrated any more.

        Raises:
            ServiceError: that takes too long, or health falls silent.
        """
        end_ns = self.clock.now_ns() + round(CALIBRATION_PATIENCE_S * NS_PER_S)
        self.wait_for(DYNAMICS_HEALTH)  # may have been on its way before the request
        while True:
            health = self.wait_for(DYNAMICS_HEALTH)
            asked = [sensor for sensor in health.sensors if not sensors or sensor.name in sensors]
            if not any(sensor.task == "calibrating" for sensor in asked):
                return health
            if self.clock.now_ns() >= end_ns:
                raise ServiceError("the calibration does not end; is a joint moving all the time?")
