"""Who is asked to bring the limbs down when the robot process does not answer."""

from typing import cast

import msgspec
import pytest

from services.core.client import Client
from services.core.clock import VirtualClock
from services.core.errors import CallFailedError
from services.core.stopping import LimbStop, StopRequests
from services.core.stream import AnyCall, AnyStream
from services.messages import Reply
from services.robot_messages import RobotRequest, RobotStatus
from services.streams import GUARD_CALL

READY = RobotStatus(
    stamp_ns=0,
    phase="ready",
    calibrated=True,
    compliant=(),
    faults=(),
    fault_count=0,
    frames_received=0,
    frames_sent=0,
    frames_lost=0,
    frames_dropped=0,
)


class GuardOnly:
    """A stack in which only the guard answers, and the robot's last words were that it is ready."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []

    def watch(self, stream: AnyStream) -> None:
        """Everything is known already."""

    def latest(self, stream: AnyStream) -> msgspec.Struct:  # noqa: ARG002
        return READY

    def call(self, call: AnyCall, request: RobotRequest, timeout_s: float) -> Reply:  # noqa: ARG002
        self.asked.append((call.name, request.action))
        if call is not GUARD_CALL:
            raise CallFailedError("no answer")
        return Reply(ok=True)


@pytest.mark.parametrize(("dead", "said"), [((), "does not answer"), (("robot",), "is gone")])
def test_the_guard_is_asked_when_the_robot_hangs_or_is_gone(
    dead: tuple[str, ...], said: str
) -> None:
    client, reports = GuardOnly(), list[str]()
    stop = LimbStop(cast(Client, client), VirtualClock(), dead.__contains__, reports.append)
    with StopRequests() as presses:
        stop.run(presses)
    assert client.asked[-1] == (GUARD_CALL.name, "stop")
    assert any(said in text for text in reports)
