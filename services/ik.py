"""Inverse kinematics: a posture of the limb for every virtual point, and for poses on request.

Reads   field/virtual_point (trigger), cartesian/status (trigger, nothing else), cartesian/setup,
        joint_state of the limbs' parts (where a search begins)
Writes  ik/ik_solution, ik/status
Serves  ik/request
Points: each search starts from the answer before, and no joint moves by more than a few degrees
from one answer to the next. A position out of reach gives the nearest feasible posture, and says
so. A point that is none is refused, counted and logged.
Requests: poses wait in a queue; each step works off some of them, and fewer while points come, so
that those are answered in time. Nothing that is asked moves the robot.
"""

import logging
from collections import deque

from dforc.errors import DforcError
from services.config import load_robot
from services.core.clock import NS_PER_S
from services.core.errors import ConfigError
from services.core.live import Context, run_process
from services.core.log import OncePerSecond
from services.core.service import Inputs, Outputs, Service
from services.messages import VirtualPoint
from services.reaching.ik_follower import Follower
from services.reaching.ik_job import IkJob
from services.reaching.ik_limb import IkLimb
from services.reaching.ik_statistics import SearchCount
from services.reaching.limb import find_limb
from services.reaching.messages import IkReply, IkRequest, IkStatusReport
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    IK_CALL,
    IK_SOLUTION,
    IK_STATUS,
    VIRTUAL_POINT,
)

logger = logging.getLogger(__name__)

STATUS_PERIOD_NS = 100_000_000
FOLLOWING_WORK_MS = 2.0  # for requests, in one step while points come: a fifth of their period
IDLE_WORK_MS = 20.0  # else
LONGEST_NS = round((IK_CALL.timeout_s - 1.0) * NS_PER_S)  # then the asker gives up, too
AWAKE_S = 2.0  # cartesian/status silent for longer: only requests start steps


class Ik(Service):
    """A solver for each limb of the parts in use."""

    writes = (IK_SOLUTION, IK_STATUS)
    serves = (IK_CALL,)
    trigger = (VIRTUAL_POINT, CARTESIAN_STATUS)
    timed = VIRTUAL_POINT

    def __init__(self, robot: RobotFile) -> None:
        self._limbs = {name: IkLimb(robot, name) for name in robot.limbs}
        self._first = self._limbs[find_limb(robot).name]
        self._first.warm()
        self._follower = Follower(self._first)
        self._requests = SearchCount()
        self._jobs: deque[tuple[int, IkJob]] = deque()
        self._setup_refused = ""
        self._reported_ns = -STATUS_PERIOD_NS
        self._throttle = OncePerSecond()
        states = dict.fromkeys(state for limb in self._limbs.values() for state in limb.states)
        self.reads = (VIRTUAL_POINT, CARTESIAN_STATUS, CARTESIAN_SETUP, *states)

    @property
    def refused(self) -> int:
        """Points that were none."""
        return self._follower.counts.refused

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Answer the newest point; older ones that queued up meanwhile are history."""
        self._take_setups(now_ns, inputs)
        point = inputs.new(VIRTUAL_POINT)
        if point is not None:
            self._follow(now_ns, point, inputs, outputs)
        for token, request in inputs.requests(IK_CALL):
            self._take_request(now_ns, token, request, inputs, outputs)
        if self._jobs:
            self._work(now_ns, inputs, outputs)
        if now_ns - self._reported_ns >= STATUS_PERIOD_NS:
            self._reported_ns = now_ns
            outputs.put(IK_STATUS, self._status(now_ns))

    def _take_setups(self, now_ns: int, inputs: Inputs) -> None:
        for message in inputs.all_new(CARTESIAN_SETUP):
            try:
                self._limb(message.setup.limb).set_up(message.setup)
                self._setup_refused = ""
            except ConfigError as error:
                self._setup_refused = str(error)
                if self._throttle.allows("setup", now_ns):
                    logger.warning("set-up refused: %s", error)

    def _follow(self, now_ns: int, point: VirtualPoint, inputs: Inputs, outputs: Outputs) -> None:
        try:
            limb = self._limb(point.limb)
            self._follower.use(limb)
            solution = self._follower.answer(now_ns, point, limb.measured(inputs))
        except ConfigError as error:
            self._follower.counts.refused += 1
            if self._throttle.allows("point", now_ns):
                logger.warning("point refused: %s", error)
            return
        if solution is not None:
            outputs.put(IK_SOLUTION, solution)

    def _take_request(
        self, now_ns: int, token: int, request: IkRequest, inputs: Inputs, outputs: Outputs
    ) -> None:
        try:
            limb = self._limb(request.limb)
            job = IkJob(limb, request, limb.measured(inputs), self._requests, now_ns)
        except ConfigError as error:
            self._refuse_request(token, str(error), outputs)
            return
        self._jobs.append((token, job))

    def _refuse_request(self, token: int, reason: str, outputs: Outputs) -> None:
        self._requests.refused += 1
        statistics = self._requests.report()
        outputs.reply(IK_CALL, token, IkReply(ok=False, reason=reason, statistics=statistics))

    def _work(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Solve poses of the requests, the first come first, as many as this step may."""
        left_ms = IDLE_WORK_MS
        if self._follower.is_following(now_ns):
            left_ms = FOLLOWING_WORK_MS
        elif inputs.age_s(CARTESIAN_STATUS) > AWAKE_S:
            left_ms = float("inf")  # no step would come to go on in
        while self._jobs and left_ms > 0.0:
            token, job = self._jobs[0]
            if now_ns - job.begun_ns > LONGEST_NS:
                self._jobs.popleft()
                outputs.reply(IK_CALL, token, job.reply(now_ns))
                continue
            try:
                left_ms -= job.advance()
            except DforcError as error:
                self._jobs.popleft()
                self._refuse_request(token, str(error), outputs)
                continue
            if not job.waiting:
                self._jobs.popleft()
                outputs.reply(IK_CALL, token, job.reply(now_ns))

    def _limb(self, name: str) -> IkLimb:
        limb = self._limbs.get(name) if name else self._first
        if limb is None:
            raise ConfigError(f"unknown limb {name!r}; there are: {', '.join(self._limbs)}")
        return limb

    def _status(self, now_ns: int) -> IkStatusReport:
        follower = self._follower
        return IkStatusReport(
            stamp_ns=now_ns,
            limb=follower.limb.name,
            solver=follower.solver,
            joints=follower.limb.joints,
            status=follower.status,
            reason=follower.reason,
            stream=follower.counts.report(),
            requests=self._requests.report(),
            waiting=sum(job.waiting for _, job in self._jobs),
            setup_refused=self._setup_refused,
        )


def build(context: Context) -> Ik:
    """Build the problems of the robot's limbs."""
    return Ik(load_robot(context.robot))


if __name__ == "__main__":
    raise SystemExit(run_process("ik", build))
