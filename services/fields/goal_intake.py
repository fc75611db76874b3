"""Goals as they come, by stream and by request: which are new, and what they are about."""

from collections.abc import Mapping

import msgspec

from services.core.clock import NS_PER_MS
from services.fields.driver import PointDriver
from services.fields.goals import ActiveGoal, checked_goal
from services.fields.limbs import FieldLimb
from services.fields.takeover import Takeover
from services.messages import CartesianStatus, Goal

REPEAT_NS = 500 * NS_PER_MS  # a goal that comes again within this has been sent again, not anew


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

    def hear(self, now_ns: int, message: Goal, status: CartesianStatus | None) -> None:
        """A goal on the stream, which may be sent again and again.

        Raises:
            ServiceError: it is none; the one before stays.
        """
        unstamped = msgspec.structs.replace(message, stamp_ns=0)
        again = unstamped == self._heard and now_ns - self._heard_ns <= REPEAT_NS
        self._heard, self._heard_ns = unstamped, now_ns
        if not message.active:
            self._driver.stop()
        elif not again:
            self.take(now_ns, message, status)

    def take(self, now_ns: int, message: Goal, status: CartesianStatus | None) -> ActiveGoal:
        """A new goal; it takes over from whatever commands.

        Raises:
            ServiceError: it is none; the one before stays.
        """
        goal = self.checked(message, self.number + 1)
        self._driver.go(goal)
        self._takeover.begin(now_ns, goal.limb, status)
        self.number = goal.number
        return goal

    def checked(self, message: Goal, number: int = 0) -> ActiveGoal:
        """A goal that is only looked at.

        Raises:
            ConfigError: it is none.
        """
        return checked_goal(message, self._limbs, self.main, number)
