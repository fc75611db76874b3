"""A live robot for benchmarks/can_live.py: calibrated, then its joints swing to and fro.

As processes of a stack, or boards and HAL in one process that keeps the time of the wall clock.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from firmware_sim.boards.warm import warm
from firmware_sim.rig import Rig
from hal.buses.socketcan import SocketCanBus
from services.boards import Boards
from services.core.clock import NS_PER_MS, NS_PER_S, RealClock
from services.core.errors import NotReadyError
from services.core.paced import PacedClock
from services.core.realtime import freeze_garbage, request_scheduling
from services.core.service import CallFailed, Inputs, Outputs, Period, Service
from services.core.virtual import VirtualExecutor
from services.emulated.emulation import rig_spec
from services.emulated.messages import PlantTruth
from services.messages import Reply, ServiceStats
from services.robot import RobotService
from services.robot_messages import RobotRequest, RobotStatus
from services.robotfile.rates import Rates
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import joint_limits_deg
from services.stack import Stack
from services.streams import PLANT_TRUTH, ROBOT_CALL, ROBOT_STATUS, STATS

PROCESSES = ("boards", "robot")
START_S = 120.0
SWING_RAD = 0.05
SWING_S = 2.0
PRIORITY = 50
LOOK_S = 0.25


class Run(ABC):
    """A running robot, and what it is told to do."""

    def __init__(self, robot: RobotFile) -> None:
        self._robot = robot

    @abstractmethod
    def rest(self, seconds: float) -> None:
        """Let time pass; what arrives meanwhile is read."""

    @abstractmethod
    def now_s(self) -> float:
        """Time that has passed."""

    @abstractmethod
    def status(self) -> RobotStatus | None:
        """The HAL's newest word."""

    @abstractmethod
    def truth(self) -> PlantTruth | None:
        """The boards' newest word."""

    @abstractmethod
    def call(self, request: RobotRequest) -> Reply:
        """Hand a request to the HAL."""

    @abstractmethod
    def stats(self) -> dict[str, ServiceStats]:
        """How each loop has kept its time."""

    def counted(self) -> tuple[RobotStatus, PlantTruth]:
        """What HAL and boards have counted by now."""
        status, truth = self.status(), self.truth()
        if status is None or truth is None:
            raise NotReadyError("HAL or boards have said nothing")
        return status, truth

    def calibrate(self) -> None:
        """Wait for the HAL's start-up, then calibrate every axis and go to where it is parked."""
        self._until(lambda status: status.phase in ("idle", "failed"))
        status, _ = self.counted()
        if status.phase == "failed":
            raise NotReadyError(f"the robot has failed: {status.faults[-1]}")
        self._finish(self._ask(RobotRequest(action="calibrate")))
        self._finish(self._move(0.0))

    def swing(self, seconds: float) -> None:
        """Move every joint to and fro about where the robot is parked."""
        end_s = self.now_s() + seconds
        away = SWING_RAD
        while (left_s := end_s - self.now_s()) > 0:
            self._move(away)
            away = -away
            self.rest(min(SWING_S, left_s))

    def _move(self, away_rad: float) -> int:
        robot = self._robot
        goal: dict[str, float] = {}
        for names in robot.parts.values():
            for name in names:
                low, high = np.radians(joint_limits_deg(robot, name))
                room = 2 * SWING_RAD  # the limits keep a margin
                parked = math.radians(robot.joints[name].park_deg)
                goal[name] = float(min(max(parked, low + room), high - room)) + away_rad
        return self._ask(
            RobotRequest(
                action="move",
                joints=tuple(goal),
                q_rad=tuple(goal.values()),
                duration_s=SWING_S / 2,
            )
        )

    def _ask(self, request: RobotRequest) -> int:
        reply = self.call(request)
        if not reply.ok:
            raise NotReadyError(f"{request.action}: {reply.reason}")
        return reply.task

    def _finish(self, task: int) -> None:
        self._until(lambda status: status.finished_task >= task)
        failed = dict(self.counted()[0].failed_tasks)
        if task in failed:
            raise NotReadyError(failed[task])

    def _until(self, done: Callable[[RobotStatus], bool]) -> None:
        give_up_s = self.now_s() + START_S
        while True:
            self.rest(LOOK_S)
            status = self.status()
            if status is not None and done(status):
                return
            if self.now_s() > give_up_s:
                raise NotReadyError(f"not within {START_S:g} s: {status}")


class StackRun(Run):
    """Processes of their own, over Zenoh streams."""

    def __init__(self, robot: RobotFile, stack: Stack) -> None:
        super().__init__(robot)
        self._client = stack.client
        self._check = stack.check
        self._clock = RealClock()
        for stream in (PLANT_TRUTH, ROBOT_STATUS, *(STATS[process] for process in PROCESSES)):
            self._client.watch(stream)

    def rest(self, seconds: float) -> None:
        """See Run."""
        end_ns = self._clock.now_ns() + round(seconds * NS_PER_S)
        while (now_ns := self._clock.now_ns()) < end_ns:
            self._clock.sleep_until(min(end_ns, now_ns + round(LOOK_S * NS_PER_S)))
            self._check()
            self._client.new(ROBOT_STATUS)
            self._client.new(PLANT_TRUTH)

    def now_s(self) -> float:
        """See Run."""
        return self._clock.now_ns() / NS_PER_S

    def status(self) -> RobotStatus | None:
        """See Run."""
        return self._client.latest(ROBOT_STATUS)

    def truth(self) -> PlantTruth | None:
        """See Run."""
        return self._client.latest(PLANT_TRUTH)

    def call(self, request: RobotRequest) -> Reply:
        """See Run."""
        return self._client.call(ROBOT_CALL, request)

    def stats(self) -> dict[str, ServiceStats]:
        """See Run; since the start of each process."""
        latest = {process: self._client.latest(STATS[process]) for process in PROCESSES}
        return {process: stats for process, stats in latest.items() if stats is not None}


class Operator(Service):
    """Hands requests on and keeps what it hears."""

    trigger = Period(0.02)
    reads = (ROBOT_STATUS, PLANT_TRUTH)
    calls = (ROBOT_CALL,)

    def __init__(self) -> None:
        self.status: RobotStatus | None = None
        self.truth: PlantTruth | None = None
        self.request: RobotRequest | None = None
        self.answers: list[Reply | CallFailed] = []

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        """Send the request that waits."""
        self.status, self.truth = inputs.latest(ROBOT_STATUS), inputs.latest(PLANT_TRUTH)
        self.answers += [answer for _, answer in inputs.replies(ROBOT_CALL)]
        if self.request is not None:
            outputs.call(ROBOT_CALL, self.request)
            self.request = None


class OneProcessRun(Run):
    """Boards and HAL in this process: for one slow core. Frames pass through the kernel."""

    def __init__(self, robot: RobotFile) -> None:
        super().__init__(robot)
        self._scheduler = request_scheduling(PRIORITY, 0)
        host = RealClock()
        self._clock = PacedClock(host)
        self._buses = [
            {bus.number: SocketCanBus(bus.channel, host) for bus in robot.buses.values()}
            for _ in PROCESSES
        ]
        warm()
        rates = Rates.live(robot)
        truth_hz = robot.rates["plant_truth"].live_hz
        self._operator = Operator()
        services: dict[str, Service] = {
            "boards": Boards(Rig(rig_spec(robot, seed=0)), self._buses[0], truth_hz),
            "robot": RobotService(robot, self._buses[1], rates),
            "operator": self._operator,
        }
        self._executor = VirtualExecutor(self._clock, services, hop_ticks=1)
        freeze_garbage()

    def close(self) -> None:
        """Axes idle, buses closed."""
        self._executor.close()
        for buses in self._buses:
            for bus in buses.values():
                bus.shutdown()

    def rest(self, seconds: float) -> None:
        """See Run."""
        self._executor.run(seconds)

    def now_s(self) -> float:
        """See Run."""
        return self._clock.now_ns() / NS_PER_S

    def status(self) -> RobotStatus | None:
        """See Run."""
        return self._operator.status

    def truth(self) -> PlantTruth | None:
        """See Run."""
        return self._operator.truth

    def call(self, request: RobotRequest) -> Reply:
        """See Run."""
        self._operator.answers.clear()
        self._operator.request = request
        self._executor.run(2.0, until=lambda: bool(self._operator.answers))
        answer = self._operator.answers[-1] if self._operator.answers else None
        return answer if isinstance(answer, Reply) else Reply(ok=False, reason=str(answer))

    def stats(self) -> dict[str, ServiceStats]:
        """See Run; the steps of boards and HAL one after the other are one tick."""
        late_p50_ns, late_p99_ns = self._clock.lateness.percentiles_ns(50, 99)
        boards = self._executor.step_times("boards")
        step_p50_ns, step_p99_ns = boards.percentiles_ns(50, 99)
        stats = ServiceStats(
            stamp_ns=self._clock.now_ns(),
            process="boards and robot",
            steps=boards.count,
            step_ms_p50=step_p50_ns / NS_PER_MS,
            step_ms_p99=step_p99_ns / NS_PER_MS,
            late_us_p50=late_p50_ns / 1e3,
            late_us_p99=late_p99_ns / 1e3,
            tick_slips=self._clock.slips,
            scheduler=self._scheduler,
        )
        return {"boards and robot": stats}
