"""Force field: moves the hand's virtual point to its goal and around what is in the way.

Reads   field/goal, field/objects, joint_state (where hands and body are), ik/ik_solution,
        cartesian/status (whether somebody else moves the hand), cartesian/setup
Writes  field/virtual_point, field/status
Serves  field/request
The point starts at the hand when a goal becomes active, and is silent while none is, or while the
hand cannot be moved; the status says why. Goals and objects that are none are refused and counted;
the last good ones hold. What a source has sent stays when it falls silent. docs/fields.md has it
all.
"""

import contextlib

import msgspec
import numpy as np

from dforc.arrays import Vector
from dforc.errors import DforcError
from services.config import load_robot
from services.core.errors import ServiceError
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.fields.around import BodyReading, around_limb
from services.fields.driver import PointDriver, start_at
from services.fields.goal_intake import GoalIntake
from services.fields.goals import out_of_reach
from services.fields.lateness import Lateness
from services.fields.limbs import FieldLimb
from services.fields.messages import FieldStatus
from services.fields.mode import PERIOD_S, HandPoint, Motion, Surroundings
from services.fields.modes import DEFAULT_MODE, mode_makers
from services.fields.refusals import Refusals
from services.fields.report import field_status
from services.fields.requests import FieldRequests, Situation
from services.fields.robot_body import robot_body
from services.fields.seen import SeenObject
from services.fields.sources import Sources
from services.fields.takeover import Takeover
from services.fields.warm import warm_modes
from services.messages import CartesianStatus, IkSolution
from services.reaching.limb import find_limb
from services.reaching.limb_reading import Reading
from services.reaching.limb_readings import LimbReadings
from services.reaching.limb_shape import limb_shape
from services.robotfile.robot_tables import RobotFile
from services.streams import (
    CARTESIAN_SETUP,
    CARTESIAN_STATUS,
    FIELD_CALL,
    FIELD_STATUS,
    GOAL,
    IK_SOLUTION,
    JOINT_STATE,
    OBJECTS,
    VIRTUAL_POINT,
)

STATUS_EVERY_STEPS = 5
CARTESIAN_AGE_S = 0.2
ANSWER_AGE_S = 0.1
FAR_BEHIND_M = 0.05


class Field(Service):
    """The virtual points of one limb at a time."""

    writes = (VIRTUAL_POINT, FIELD_STATUS)
    serves = (FIELD_CALL,)
    trigger = Period(PERIOD_S)

    def __init__(self, robot: RobotFile, mode: str = DEFAULT_MODE) -> None:
        """`mode` is the one in use at first."""
        main = find_limb(robot).name
        shapes = {name: limb_shape(robot, name) for name in robot.limbs}
        limbs = {name: FieldLimb.of(shape) for name, shape in shapes.items()}
        body = robot_body(robot)
        makers = mode_makers(robot, body)
        self._limbs = limbs
        self._limb = limbs[main]  # of the newest goal
        self._driver = driver = PointDriver(limbs, makers, mode)
        self._readings = LimbReadings(shapes)
        self._body = BodyReading(robot, body)
        self._sources = Sources()
        self._takeover = Takeover()
        self._refusals = Refusals()
        self._lateness = Lateness()
        self._goals = GoalIntake(driver, limbs, main, self._takeover)
        self._requests = FieldRequests(driver, limbs, makers, self._sources, self._goals)
        self._waiting = ""  # what a goal waits for
        self._steps = 0
        parts = dict.fromkeys(part for shape in shapes.values() for part in shape.parts)
        states = dict.fromkeys([JOINT_STATE[part] for part in parts])
        states |= dict.fromkeys(self._body.streams.values())
        self.reads = (GOAL, OBJECTS, CARTESIAN_STATUS, CARTESIAN_SETUP, IK_SOLUTION, *states)

    def warm(self) -> "Field":
        """Compile what is compiled before somebody waits for it."""
        warm_modes(self._driver, self._limb, self._body)
        for mode, gains in self._driver.gains.items():
            with contextlib.suppress(ServiceError):  # a mode that does not move such a limb
                self._requests.spare(mode, self._limb, gains)
        return self

    @property
    def refused(self) -> int:
        """Goals and objects that were none."""
        return self._refusals.count

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Move the points by one period."""
        self._lateness.note(now_ns, inputs.late_ns)
        self._readings.begin(inputs)
        self._body.take(inputs)
        status = inputs.fresh(CARTESIAN_STATUS, CARTESIAN_AGE_S)
        self._take(now_ns, inputs, status)
        seen = self._sources.seen(now_ns)
        self._requests.take(now_ns, inputs, outputs, self._situation(inputs, seen, status))
        around = self._around(seen)
        motion = self._move(now_ns, status, seen, around)
        if motion is not None and self._driver.goal is not None:
            outputs.put(VIRTUAL_POINT, self._driver.point(now_ns, motion, self._driver.goal))
        self._requests.advance(outputs, busy=motion is not None)
        self._steps += 1
        if self._steps % STATUS_EVERY_STEPS == 0:
            self._report(now_ns, inputs, outputs, seen, around)

    def _take(self, now_ns: int, inputs: Inputs, status: CartesianStatus | None) -> None:
        """Set-ups, objects and goals that are new."""
        for message in inputs.all_new(CARTESIAN_SETUP):
            limb = self._limbs.get(message.setup.limb)
            try:
                if limb is not None and limb.set_up(message.setup):
                    self._driver.forget_laws(limb.name)
            except ServiceError as error:
                self._refusals.note(now_ns, str(error))
        for objects in inputs.all_new(OBJECTS):
            for problem in self._sources.take(now_ns, objects):
                self._refusals.note(now_ns, problem)
        goal = inputs.new(GOAL)
        if goal is not None:
            try:
                self._goals.hear(now_ns, goal, status)
            except ServiceError as error:
                self._refusals.note(now_ns, str(error))

    def _situation(
        self, inputs: Inputs, seen: tuple[SeenObject, ...], status: CartesianStatus | None
    ) -> Situation:
        return Situation(
            seen=seen,
            status=status,
            body=(self._body.q_rad, self._body.dq_rad_s),
            readings=self._readings,
            answer=self._answer(inputs.fresh(IK_SOLUTION, ANSWER_AGE_S)),
        )

    def _answer(self, solution: IkSolution | None) -> Vector | None:
        """The posture that the arm is led to, where it is known."""
        limb = self._driver.limb
        if limb is None:
            return None
        if solution is not None and solution.limb == limb.name:
            q_rad = np.array(solution.q_rad)
            if len(q_rad) == limb.shape.n and np.isfinite(q_rad).all():
                return q_rad
        reading = self._readings.recent(limb.name)
        return None if reading.missing else np.array(reading.q_rad)

    def _around(self, seen: tuple[SeenObject, ...]) -> Surroundings:
        return around_limb(seen, self._driver.goal, (self._body.q_rad, self._body.dq_rad_s))

    def _move(
        self,
        now_ns: int,
        status: CartesianStatus | None,
        seen: tuple[SeenObject, ...],
        around: Surroundings,
    ) -> Motion | None:
        """The points of this period; None where there are none, and why."""
        driver, goal = self._driver, self._driver.goal
        self._waiting = ""
        if goal is None:
            return None
        self._limb = limb = self._limbs[goal.limb]
        reading = self._readings.recent(goal.limb)
        reason = self._takeover.reason(now_ns, goal.limb, status) or reading.missing
        if reason:
            driver.drop()
            self._waiting = reason
            return None
        goals, self._waiting = goal.hands(limb, seen)
        try:
            return driver.step(np.array(reading.q_rad), goals, around)
        except DforcError as error:
            self._refusals.note(now_ns, str(error))
            driver.drop()
            self._waiting = str(error)
            return None

    def _report(
        self,
        now_ns: int,
        inputs: Inputs,
        outputs: Outputs,
        seen: tuple[SeenObject, ...],
        around: Surroundings,
    ) -> None:
        told = field_status(now_ns, self._driver, self._hands(), around, seen, self._limb)
        state, reason = self._state(told, inputs.fresh(IK_SOLUTION, ANSWER_AGE_S))
        status = msgspec.structs.replace(
            told,
            state=state,
            reason=reason,
            last_goal=self._goals.number,
            refused=self._refusals.count,
            refusal=self._refusals.newest,
            assumed=self._body.assumed,
            late_ms=self._lateness.largest_ms,
            late_count=self._lateness.count,
        )
        outputs.put(FIELD_STATUS, status)

    def _state(self, told: FieldStatus, solution: IkSolution | None) -> tuple[str, str]:
        """State and reason, as far as more than the points is known."""
        driver, state, reason = self._driver, told.state, told.reason
        if self._waiting:
            return "waiting", self._waiting
        if driver.goal is None and self._goals.number:
            return state, f"goal {self._goals.number} was withdrawn"
        if driver.asked is not None and (beyond := out_of_reach(self._limb, driver.asked)):
            return "unreachable", beyond
        if state == "arrived" and solution is not None and solution.status == "infeasible":
            return "unreachable", solution.reason
        if state == "reaching" and not reason and driver.lag_m > FAR_BEHIND_M:
            reason = f"the hand is {driver.lag_m * 1e3:.0f} mm behind the point"
        return state, reason

    def _hands(self) -> tuple[HandPoint, ...]:
        """The points, or the measured hands where none is in motion; none where neither is."""
        if self._driver.motion is not None:
            return self._driver.motion.hands
        reading = self._readings.recent(self._limb.name)
        return () if reading.missing else _at_rest(self._limb, reading)


def _at_rest(limb: FieldLimb, reading: Reading) -> tuple[HandPoint, ...]:
    return start_at(limb, np.array(reading.q_rad)).hands


def build(context: Context) -> Field:
    """Build the models of limbs and body."""
    return Field(load_robot(context.robot)).warm()


if __name__ == "__main__":
    raise SystemExit(run_process("field", build))
