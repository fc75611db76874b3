"""Goals as they come, by stream and by request: which are new, and what they are about."""

import math
from collections.abc import Mapping
from dataclasses import replace

import msgspec

from dforc.poses import is_beyond
from services.core.clock import NS_PER_MS
from services.fields.driver import PointDriver
from services.fields.goals import ActiveGoal, checked_goal
from services.fields.limbs import FieldLimb
from services.fields.mode import Goals
from services.fields.takeover import Takeover
from services.messages import CartesianStatus, Goal, Vector3

REPEAT_NS = 500 * NS_PER_MS  # a goal that comes again within this has been sent again, not anew
# One that is streamed, and from one message to the next has moved by no more, has moved on.
MOVED_ON_M, TURNED_ON_RAD = 0.03, math.radians(15.0)
NOWHERE: Vector3 = (0.0, 0.0, 0.0)


class GoalIntake:
    """The goal in use is the newest good one."""

    def __init__(
        self, driver: PointDriver, limbs: Mapping[str, FieldLimb], main: str, takeover: Takeover
    ) -> None:
        self.number = 0  # of the newest goal
        self.main = main
        self._driver = driver
        self._limbs = limbs
        self._takeover = takeover
        self._heard: Goal | None = None
        self._heard_ns = -REPEAT_NS
        self._streamed = 0  # number of the newest goal of the stream

    def hear(self, now_ns: int, message: Goal, status: CartesianStatus | None) -> None:
        """A goal on the stream, which may be sent again and again, and may move.

        Raises:
            ServiceError: it is none; the one before stays.
        """
        unstamped = _as_meant(message)
        soon = now_ns - self._heard_ns <= REPEAT_NS
        again = soon and unstamped == self._heard
        self._heard, self._heard_ns = unstamped, now_ns
        if not message.active:
            self._driver.stop()
        elif not again:
            goal = self.checked(unstamped, self.number + 1)
            self._go(now_ns, goal, status, moved_on=soon and self._has_moved_on(goal))
            self._streamed = goal.number

    def take(self, now_ns: int, message: Goal, status: CartesianStatus | None) -> ActiveGoal:
        """A new goal; it takes over from whatever commands.

        Raises:
            ServiceError: it is none; the one before stays.
        """
        goal = self.checked(message, self.number + 1)
        self._go(now_ns, goal, status, moved_on=False)
        return goal

    def checked(self, message: Goal, number: int = 0) -> ActiveGoal:
        """A goal that is only looked at.

        Raises:
            ConfigError: it is none.
        """
        return checked_goal(message, self._limbs, self.main, number)

    def _go(
        self, now_ns: int, goal: ActiveGoal, status: CartesianStatus | None, *, moved_on: bool
    ) -> None:
        self._driver.go(goal, moved_on=moved_on)
        self._takeover.begin(now_ns, goal.limb, status)
        self.number = goal.number

    def _has_moved_on(self, goal: ActiveGoal) -> bool:
        """Whether the goal in use, of the stream too, is the same a little earlier."""
        before = self._driver.goal
        if before is None or before.number != self._streamed or before.limb != goal.limb:
            return False
        if before.message.follow != goal.message.follow:
            return False
        was, now = self._poses(before), self._poses(goal)
        return not is_beyond(was, now, MOVED_ON_M, TURNED_ON_RAD)

    def _poses(self, goal: ActiveGoal) -> Goals:
        """Of a goal as it was sent; of one that is followed the turn alone."""
        sent = replace(goal, message=msgspec.structs.replace(goal.message, follow=""))
        poses, _ = sent.hands(self._limbs[goal.limb], ())
        assert poses is not None  # nothing is followed
        return poses


def _as_meant(message: Goal) -> Goal:
    """Without its stamp, and where an object is followed without a place: that is the object's."""
    plain = msgspec.structs.replace(message, stamp_ns=0)
    if not message.follow:
        return plain
    return msgspec.structs.replace(plain, position_m=NOWHERE, velocity_m_s=NOWHERE)
