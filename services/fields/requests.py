"""What the field is asked: taken up or refused with the reason, at once; paths in a queue."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.errors import DforcError
from dforc.ik.problem import IkProblem
from services.core.errors import ConfigError, ServiceError
from services.core.service import Inputs, Outputs
from services.fields.answers import check_action, gains_reply, info_reply
from services.fields.around import around_limb
from services.fields.driver import PointDriver, start_at, start_from
from services.fields.goal_intake import GoalIntake
from services.fields.goals import ActiveGoal, no_object, out_of_reach
from services.fields.limbs import FieldLimb
from services.fields.messages import FieldReply, FieldRequest
from services.fields.mode import FieldMode, ModeOf
from services.fields.preview import PreviewJob
from services.fields.seen import SeenObject
from services.fields.sources import Sources, find_object
from services.messages import CartesianStatus
from services.reaching.limb_readings import LimbReadings
from services.streams import FIELD_CALL

MOST_PREVIEWS = 8  # that wait


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Situation:
    """What is known in the period in which something is asked."""

    seen: tuple[SeenObject, ...]
    status: CartesianStatus | None
    body: tuple[Vector, Vector]  # joints and speeds of the whole body
    readings: LimbReadings
    answer: Vector | None  # posture that the limb in use is led to


@dataclass(frozen=True, slots=True, eq=False)
class Spare:
    """A mode for previews: to make one may take longer than a period."""

    law: FieldMode
    problem: IkProblem  # of the limb as it was set up then


class FieldRequests:
    """Served by the field."""

    def __init__(
        self,
        driver: PointDriver,
        limbs: Mapping[str, FieldLimb],
        makers: Mapping[str, ModeOf],
        sources: Sources,
        goals: GoalIntake,
    ) -> None:
        self._driver = driver
        self._limbs = limbs
        self._makers = makers
        self._sources = sources
        self._goals = goals
        self._previews: deque[tuple[int, PreviewJob]] = deque()
        self._spares: dict[tuple[str, str], Spare] = {}

    def take(self, now_ns: int, inputs: Inputs, outputs: Outputs, here: Situation) -> None:
        """Answer what is new, but for previews."""
        for token, request in inputs.requests(FIELD_CALL):
            try:
                check_action(request.action)
                if request.action == "preview":
                    self._begin_preview(token, request, here)
                else:
                    outputs.reply(FIELD_CALL, token, self._done(now_ns, request, here))
            except (ServiceError, DforcError) as error:
                outputs.reply(FIELD_CALL, token, FieldReply(ok=False, reason=str(error)))

    def advance(self, outputs: Outputs, *, busy: bool) -> None:
        """Go on with the oldest preview; `busy`: a point is in motion, which comes first."""
        if not self._previews:
            return
        token, job = self._previews[0]
        if job.advance(busy=busy):
            self._previews.popleft()
            outputs.reply(FIELD_CALL, token, FieldReply(ok=True, preview=job.result()))

    def _done(self, now_ns: int, request: FieldRequest, here: Situation) -> FieldReply:
        driver = self._driver
        if request.action == "goal":
            return self._go(now_ns, request, here)
        if request.action == "info":
            limbs = tuple(self._limbs)
            return info_reply(now_ns, driver, self._sources, limbs, self._goals.main)
        if request.action == "forget":
            return FieldReply(ok=True, forgotten=self._sources.forget(request.source))
        if request.action == "stop":
            driver.stop()
        else:
            driver.change(request.mode, request.gains, request.preset, here.answer)
        return gains_reply(driver)

    def _go(self, now_ns: int, request: FieldRequest, here: Situation) -> FieldReply:
        if request.goal is None:
            raise ConfigError("a goal is asked for, and none is given")
        followed = request.goal.follow
        if followed and find_object(here.seen, followed) is None:
            raise ConfigError(no_object(followed, here.seen))
        goal = self._goals.take(now_ns, request.goal, here.status)
        limb = self._limbs[goal.limb]
        asked, reason = goal.hands(limb, here.seen)
        if asked is not None:
            reason = out_of_reach(limb, asked)
        return FieldReply(ok=True, goal=goal.number, mode=self._driver.mode, reason=reason)

    def _begin_preview(self, token: int, request: FieldRequest, here: Situation) -> None:
        if len(self._previews) >= MOST_PREVIEWS:
            raise ConfigError(f"{MOST_PREVIEWS} previews wait already; ask again later")
        goal = self._driver.goal if request.goal is None else self._goals.checked(request.goal)
        if goal is None:
            raise ConfigError("there is no goal to preview; give one")
        limb = self._limbs[goal.limb]
        asked, reason = goal.hands(limb, here.seen)
        if asked is None:
            raise ConfigError(reason)
        law = self._begun(request, goal, limb, here)
        around = around_limb(here.seen, goal, here.body)
        job = PreviewJob(law, limb, goal, here.seen, around, request.duration_s)
        self._previews.append((token, job))

    def _begun(
        self, request: FieldRequest, goal: ActiveGoal, limb: FieldLimb, here: Situation
    ) -> FieldMode:
        """The mode of a preview, where the point is now, or else the hand."""
        driver = self._driver
        mode = request.mode or driver.mode
        gains = driver.changed(mode, request.gains, request.preset)
        if driver.motion is not None and driver.goal is not None and driver.goal.limb == goal.limb:
            start = start_from(limb, driver.motion, here.answer)
        else:
            reading = here.readings.recent(limb.name)
            if reading.missing:
                raise ConfigError(f"where the hand is is not known: {reading.missing}")
            start = start_at(limb, np.array(reading.q_rad))
        law = self.spare(mode, limb, gains)
        law.begin(start)
        return law

    def spare(self, mode: str, limb: FieldLimb, gains: Mapping[str, float]) -> FieldMode:
        """A mode that moves nothing: one that was made before, unless a preview uses it.

        Raises:
            ServiceError: the mode does not move such a limb.
        """
        kept = self._spares.get((mode, limb.name))
        in_use = [job.law for _, job in self._previews]
        if kept is not None and kept.problem is limb.problem and kept.law not in in_use:
            kept.law.use(gains)
            return kept.law
        law = self._makers[mode](limb, gains)
        self._spares[mode, limb.name] = Spare(law, limb.problem)
        return law
