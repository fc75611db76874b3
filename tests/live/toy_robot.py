"""A process that plays the robot: ready until it is told to stop, then 1 s to come down."""

import logging

from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import Reply
from services.robot_messages import RobotStatus
from services.streams import ROBOT_CALL, ROBOT_STATUS

logger = logging.getLogger(__name__)

DOWN_IN_NS = 1_000_000_000


class ToyRobot(Service):
    writes = (ROBOT_STATUS,)
    serves = (ROBOT_CALL,)
    trigger = Period(0.01)

    def __init__(self) -> None:
        self._phase = "ready"
        self._down_at_ns = 0
        self._orders: list[str] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        for token, request in inputs.requests(ROBOT_CALL):
            self._orders.append(request.action)
            logger.info("order %s", request.action)
            self._phase = "stopping"
            self._down_at_ns = now_ns + DOWN_IN_NS * (request.action == "stop")
            outputs.reply(ROBOT_CALL, token, Reply(ok=True))
        if self._phase == "stopping" and now_ns >= self._down_at_ns:
            self._phase = "idle"
        outputs.put(ROBOT_STATUS, status(now_ns, self._phase, self._orders))

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        logger.info("orders %s, phase %s", self._orders, self._phase)


def status(now_ns: int, phase: str, orders: list[str]) -> RobotStatus:
    return RobotStatus(
        stamp_ns=now_ns,
        phase=phase,
        calibrated=True,
        compliant=(),
        faults=tuple(orders),
        fault_count=0,
        frames_received=0,
        frames_sent=0,
        frames_lost=0,
        frames_dropped=0,
    )


def build(context: Context) -> ToyRobot:  # noqa: ARG001
    return ToyRobot()


if __name__ == "__main__":
    raise SystemExit(run_process("robot", build))
