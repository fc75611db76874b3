"""A clock that lets the virtual executor run by the wall: ticks at absolute deadlines."""

from services.core.clock import NS_PER_MS, Clock, VirtualClock
from services.core.timing import Durations

MOST_TICKS_TO_CATCH_UP = 20


class PacedClock(VirtualClock):
    """Moves with the host's clock, one tick at a time.

    After a stall at most 20 ticks are caught up; beyond that simulated time slips, and is counted.
    """

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock.now_ns())
        self.lateness = Durations()
        self.slips = 0
        self._clock = clock
        self._deadline_ns = self._now_ns

    def advance_ns(self, step_ns: int) -> None:
        """Wait for the next tick; then it is as late as the host made it."""
        self._deadline_ns += step_ns
        self._clock.sleep_until(self._deadline_ns)
        self._now_ns = self._clock.now_ns()
        late_ns = self._now_ns - self._deadline_ns
        self.lateness.add(late_ns)
        slipped = late_ns // NS_PER_MS - MOST_TICKS_TO_CATCH_UP
        if slipped > 0:
            self.slips += slipped
            self._deadline_ns += slipped * NS_PER_MS
