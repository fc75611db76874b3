"""Makes the limbs stiff when the HAL falls silent, and brings them down when nobody else can.

Reads   robot/status (the HAL's heartbeat)
Serves  guard/request: stop (stiff, position mode, idle), idle (power off at once)
It has bus handles of its own, so it works while the robot process hangs or is gone. It acts once
per silence, and not at all while it does what it was asked for; when the heartbeat comes back it
steps aside.
"""

import logging
from collections.abc import Mapping

from hal.buses.bus import FrameBus
from hal.errors import DescriptionError
from hal.guarding import Guard
from hal.stalls import Stalls
from hal.tasks import Task
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import Reply
from services.robot_messages import RobotRequest
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import parked, robot_description
from services.streams import GUARD_CALL, ROBOT_STATUS

logger = logging.getLogger(__name__)

TICK_S = 0.01
SILENCE_S = 0.06  # three heartbeats; the boards' own 200 ms watchdog on torques is far behind
IDLE_PHASES = ("opening", "idle", "failed")


class GuardService(Service):
    """Watches one heartbeat."""

    reads = (ROBOT_STATUS,)
    serves = (GUARD_CALL,)
    trigger = Period(TICK_S)

    def __init__(self, robot: RobotFile, buses: Mapping[int, FrameBus]) -> None:
        self._robot = robot
        self._guard = Guard(robot_description(robot), buses)
        self._stalls = Stalls()
        self._acted = False
        self._running: Task | None = None

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Act when the heartbeat is late, or when asked."""
        for token, request in inputs.requests(GUARD_CALL):
            outputs.reply(GUARD_CALL, token, self._take_up(now_ns, request))
        self._stalls.note(now_ns)
        status = inputs.latest(ROBOT_STATUS)
        silent = status is not None and self._silence_s(now_ns, inputs) > SILENCE_S
        if status is not None and silent and not self._acted and status.phase not in IDLE_PHASES:
            self._acted = True
            if self._running is None or self._running.done:  # a stop makes the joints stiff too
                logger.error("robot process silent for %.0f ms: joints made stiff", SILENCE_S * 1e3)
                self._running = self._guard.make_stiff(now_ns)
        elif not silent:
            self._acted = False
        self._guard.step(now_ns)

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        """The buses are closed by whoever opened them."""
        self._guard.close()

    def _silence_s(self, now_ns: int, inputs: Inputs) -> float:
        """Age of the heartbeat, without the time in which this process stood still itself."""
        heard_ns = now_ns - round(inputs.age_s(ROBOT_STATUS) * 1e9)
        return self._stalls.age_ns(now_ns, heard_ns) * 1e-9

    def _take_up(self, now_ns: int, request: RobotRequest) -> Reply:
        if request.action == "stop":
            request = parked(self._robot, request)
            try:
                self._running = self._guard.stop(now_ns, request.joints, request.q_rad)
            except DescriptionError as error:
                return Reply(ok=False, reason=str(error))
        elif request.action == "idle":
            self._running = self._guard.idle_all(now_ns)
        else:
            return Reply(ok=False, reason=f"the guard cannot {request.action!r}; it can stop, idle")
        return Reply(ok=self._running.ok, reason=self._running.reason)


def build(context: Context) -> GuardService:
    """Open every bus of the robot file a second time."""
    robot = load_robot(context.robot)
    buses = {bus.number: context.open_bus(bus.number, bus.channel) for bus in robot.buses.values()}
    return GuardService(robot, buses)


if __name__ == "__main__":
    raise SystemExit(run_process("guard", build))
