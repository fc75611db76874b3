"""A client of the stack that follows a script: requests, waits and time-outs, one after another.

The script is a generator that is resumed once per period; `yield` waits for the next one.
"""

from abc import abstractmethod
from collections.abc import Callable, Generator

from services.core.service import CallFailed, Inputs, Outputs, Service
from services.fields.messages import FieldReply
from services.messages import Reply
from services.robot_messages import RobotRequest, RobotStatus
from services.streams import ROBOT_CALL, ROBOT_STATUS

TASK_TIMEOUT_S = 15.0
OPEN_TIMEOUT_S, CALIBRATION_TIMEOUT_S = 20.0, 60.0

Script = Generator[None, None, None]


class AbandonedError(Exception):
    """The script cannot go on; the text says why."""


class ScriptedService(Service):
    """Runs its script once; `finished` says when, `progress` what it is doing.

    It must read ROBOT_STATUS and declare every call that the script makes.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        """`joints` are those that requests mean when they name none."""
        self.progress = "waiting for the boards"
        self.finished = False
        self.now_ns = 0
        self.inputs: Inputs
        self.outputs: Outputs
        self.replies: dict[int, Reply | CallFailed] = {}
        self._joints = joints
        self._running = self.script()

    @abstractmethod
    def script(self) -> Script:
        """What to do."""

    def observe(self) -> None:
        """Look at what has arrived; called every period before the script goes on."""

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Resume the script where it waits."""
        self.now_ns, self.inputs, self.outputs = now_ns, inputs, outputs
        for call in self.calls:
            for token, reply in inputs.replies(call):
                if isinstance(reply, Reply | CallFailed):
                    self.replies[token] = reply
                elif isinstance(reply, FieldReply):
                    self.replies[token] = Reply(ok=reply.ok, reason=reply.reason)
        self.observe()
        if not self.finished:
            try:
                next(self._running)
            except StopIteration:
                self.finished = True

    def say(self, what: str) -> None:
        """What it is doing now."""
        self.progress = what

    def ask(
        self,
        what: str,
        action: str,
        timeout_s: float = TASK_TIMEOUT_S,
        *,
        joints: tuple[str, ...] = (),
        value: str = "",
        q_rad: tuple[float, ...] = (),
        duration_s: float = 0.0,
    ) -> Script:
        """Ask the HAL for something and wait until it is done.

        Raises:
            AbandonedError: refused, failed or not done in time, with the reason.
        """
        self.say(what)
        request = RobotRequest(
            action=action,
            joints=joints or self._joints,
            value=value,
            q_rad=q_rad,
            duration_s=duration_s,
        )
        token = self.outputs.call(ROBOT_CALL, request)
        reply = yield from self.answered(token, action)
        yield from self.until(
            lambda: self.status().finished_task >= reply.task, timeout_s, f"{action} done"
        )
        for number, reason in self.status().failed_tasks:
            if number == reply.task:
                raise AbandonedError(reason)

    def calibrate(self, timeout_s: float = CALIBRATION_TIMEOUT_S) -> Script:
        """Wait until the boards answer, then calibrate every axis.

        Raises:
            AbandonedError: they do not, or an axis cannot be calibrated, with the reason.
        """
        yield from self.until(
            lambda: self.status().phase in ("idle", "ready"), OPEN_TIMEOUT_S, "boards answer"
        )
        yield from self.ask("calibrating the axes", "calibrate", timeout_s)

    def answered(self, token: int, what: str) -> Generator[None, None, Reply]:
        """Wait for the answer to a request."""
        while token not in self.replies:
            yield
        reply = self.replies.pop(token)
        if isinstance(reply, CallFailed):
            raise AbandonedError(f"{what}: {reply.reason}")
        if not reply.ok:
            raise AbandonedError(f"{what}: refused: {reply.reason}")
        return reply

    def until(self, condition: Callable[[], bool], timeout_s: float, what: str) -> Script:
        """Wait until something holds; the HAL's failure ends the waiting."""
        deadline_ns = self.now_ns + round(timeout_s * 1e9)
        while True:
            if self.inputs.latest(ROBOT_STATUS) is not None:
                if condition():
                    return
                if self.status().phase == "failed":
                    raise AbandonedError("; ".join(self.status().faults) or "the HAL failed")
            if self.now_ns >= deadline_ns:
                raise AbandonedError(f"waited {timeout_s:g} s in vain: {what}{self.faults()}")
            yield

    def faults(self) -> str:
        """The faults that the HAL reports, as the end of a sentence."""
        status = self.inputs.latest(ROBOT_STATUS)
        return ": " + "; ".join(status.faults) if status is not None and status.faults else ""

    def status(self) -> RobotStatus:
        """The HAL's newest status."""
        status = self.inputs.latest(ROBOT_STATUS)
        if status is None:
            raise AbandonedError("no robot/status yet")
        return status
