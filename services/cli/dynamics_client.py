"""A command's conversation with the dynamics service of a running stack."""

import sys
from collections.abc import Sequence
from typing import TypeVar

import msgspec

from services.cli.stack_client import StackClient
from services.core.clock import NS_PER_MS, NS_PER_S
from services.core.errors import ServiceError
from services.core.stream import Stream
from services.messages import Reply
from services.streams import DYNAMICS_CALL, DYNAMICS_HEALTH
from services.wholebody.dynamics_messages import DynamicsHealth, DynamicsRequest
from services.wholebody.sensor_tasks import TOUCHED

MessageT = TypeVar("MessageT", bound=msgspec.Struct)

SHORT_PATIENCE_S = 0.5
CALIBRATION_PATIENCE_S = 120.0
REST_PATIENCE_S = 3.0  # for a hand to leave, and the limb to come to rest
ASK_AGAIN_NS = 50 * NS_PER_MS


class DynamicsClient(StackClient):
    """One client of a stack."""

    def ask(self, request: DynamicsRequest) -> bool:
        """Send a request and print what the service says; whether it was taken up."""
        return _told(self.call(DYNAMICS_CALL, request))

    def ask_at_rest(self, request: DynamicsRequest) -> bool:
        """`ask`, and again for a moment while a touch is all that is in the way.

        A hand that is just leaving, or a limb that swings out or strikes its stop needs no word.
        A touch that stays is told as always.
        """
        end_ns = self.clock.now_ns() + round(REST_PATIENCE_S * NS_PER_S)
        while True:
            reply = self.call(DYNAMICS_CALL, request)
            now_ns = self.clock.now_ns()
            if reply.ok or TOUCHED not in reply.reason or now_ns >= end_ns:
                return _told(reply)
            self.clock.sleep_until(now_ns + ASK_AGAIN_NS)

    def silence(self, name: str) -> ServiceError:
        """What to say of a stream that is silent though the stack is up."""
        if "dynamics" not in self.bus.alive():
            return ServiceError(
                f"no dynamics process in stack {self.stack!r}: its parts have no "
                f"force/torque sensor, or it has ended; see `ulna up`'s log"
            )
        return ServiceError(
            f"{name} is silent: the HAL sends neither wrenches nor joint states; "
            f"are the boards powered and found (`ulna can scan`)?"
        )

    def newest(self, stream: Stream[MessageT]) -> MessageT | None:
        """The next message of a stream that may rightly be silent."""
        return self.next_of(stream, SHORT_PATIENCE_S) or self.bus.latest(stream)

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


def _told(reply: Reply) -> bool:
    """Print what the service says; whether the request was taken up."""
    if reply.reason:
        print(reply.reason, file=sys.stdout if reply.ok else sys.stderr)
    return reply.ok
