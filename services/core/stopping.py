"""How a stack comes down: the limbs first, then the processes."""

import signal
from collections.abc import Callable
from types import FrameType, TracebackType

from services.core.client import Client
from services.core.clock import NS_PER_S, Clock
from services.core.errors import CallFailedError
from services.core.stream import Call
from services.messages import Reply
from services.robot_messages import RobotRequest
from services.streams import GUARD_CALL, ROBOT_CALL, ROBOT_STATUS

BRING_DOWN_S = 3.0  # what the HAL takes at most to bring the limbs down in position mode
MARGIN_S = 1.0
ANSWER_S = 1.0
FIRST_STATUS_S = 0.3  # thirty heartbeats
LOOK_EVERY_NS = 10_000_000
AT_REST = ("idle", "failed")


class StopRequests:
    """Counts Ctrl-C, SIGTERM and SIGHUP instead of being interrupted by them."""

    def __init__(self) -> None:
        self.count = 0
        self._previous: list[tuple[signal.Signals, object]] = []

    def __enter__(self) -> "StopRequests":
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            self._previous.append((number, signal.getsignal(number)))
            signal.signal(number, self._arrived)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for number, previous in self._previous:
            if callable(previous) or isinstance(previous, signal.Handlers):
                signal.signal(number, previous)

    def _arrived(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.count += 1


class LimbStop:
    """Brings the limbs down through the robot process or, where that is gone, through the guard."""

    def __init__(
        self,
        client: Client,
        clock: Clock,
        is_dead: Callable[[str], bool],
        report: Callable[[str], None],
    ) -> None:
        self._client = client
        self._clock = clock
        self._is_dead = is_dead
        self._report = report

    def run(self, presses: StopRequests) -> None:
        """Down in position mode, then idle; one press more idles at once."""
        self._client.watch(ROBOT_STATUS)
        if self._is_dead("robot"):
            self._through_guard(presses)
            return
        self._wait(FIRST_STATUS_S, self._has_status)
        if not self._at_rest():
            self._through_robot(presses)

    def _through_robot(self, presses: StopRequests) -> None:
        self._report("bringing the limbs down; Ctrl-C again idles them at once")
        pressed = presses.count  # before the question: a press while it is under way counts
        if self._ask(ROBOT_CALL, "stop"):
            self._wait(BRING_DOWN_S + MARGIN_S, lambda: self._at_rest() or presses.count > pressed)
        if self._at_rest():
            return
        if self._is_dead("robot"):
            self._through_guard(presses)
        elif self._ask(ROBOT_CALL, "idle"):
            self._report("idle at once")
            self._wait(MARGIN_S, self._at_rest)
        else:
            self._through_guard(presses)

    def _through_guard(self, presses: StopRequests) -> None:
        why = "is gone" if self._is_dead("robot") else "does not answer"
        self._report(f"the robot process {why}: the guard brings the limbs down")
        pressed = presses.count
        if self._ask(GUARD_CALL, "stop"):
            self._wait(BRING_DOWN_S, lambda: presses.count > pressed or self._is_dead("guard"))
        if presses.count > pressed:
            self._ask(GUARD_CALL, "idle")

    def _wait(self, seconds: float, condition: Callable[[], bool]) -> None:
        """Wait for the condition, that long at most."""
        end_ns = self._clock.now_ns() + round(seconds * NS_PER_S)
        while not condition() and self._clock.now_ns() < end_ns:
            self._clock.sleep_until(self._clock.now_ns() + LOOK_EVERY_NS)

    def _has_status(self) -> bool:
        return self._client.latest(ROBOT_STATUS) is not None

    def _at_rest(self) -> bool:
        """Whether the robot reports rest; a robot process that is gone reports nothing any more."""
        status = self._client.latest(ROBOT_STATUS)
        return status is not None and status.phase in AT_REST and not self._is_dead("robot")

    def _ask(self, call: Call[RobotRequest, Reply], action: str) -> bool:
        try:
            reply = self._client.call(call, RobotRequest(action=action), ANSWER_S)
        except CallFailedError as error:
            self._report(f"{action}: {error}")
            return False
        if not reply.ok:
            self._report(f"{action}: refused: {reply.reason}")
        return reply.ok
