"""Time that this process itself lost: it must not be blamed on boards or on other processes.

When the process, or the whole machine, stands still for a tenth of a second, everything looks late
in the first step afterwards, although the frames and torques of that time are only waiting to be
read. So ages leave out the process's own stalls. A sender that is really gone is still found, its
time limit after the stall.
"""

from collections import deque

LONGEST_STEP_NS = 10_000_000  # ten periods: more than catching up ever takes
KEPT = 16


class Stalls:
    """The stalls of one stepped process."""

    __slots__ = ("_ended", "_previous_ns", "count")

    def __init__(self) -> None:
        self.count = 0
        self._previous_ns: int | None = None
        self._ended: deque[tuple[int, int]] = deque(maxlen=KEPT)  # (end, length)

    def note(self, now_ns: int) -> None:
        """A step begins."""
        previous_ns, self._previous_ns = self._previous_ns, now_ns
        if previous_ns is not None and now_ns - previous_ns > LONGEST_STEP_NS:
            self.count += 1
            self._ended.append((now_ns, now_ns - previous_ns))

    def age_ns(self, now_ns: int, stamp_ns: int) -> int:
        """Time from a stamp until now, less the stalls that ended in between."""
        age_ns = now_ns - stamp_ns
        for end_ns, length_ns in self._ended:
            if end_ns > stamp_ns:
                age_ns -= min(length_ns, end_ns - stamp_ns)
        return age_ns
