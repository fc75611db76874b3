"""Time that this process itself lost: it must not be blamed on boards or on other processes.

When the process, or the whole machine, stands still for a tenth of a second, everything looks late
in the first step afterwards, although the frames and torques of that time are only waiting to be
read. So ages leave out the process's own stalls. A sender that is really gone is still found, its
time limit after the stall.

One stall, the longest, is left out of an age, and no more: the boards' own watchdogs forgive none,
and a process that is slow all the time must not hide from itself that the torques have stopped.
"""

from collections import deque

LONGEST_STEP_NS = 15_000_000  # longer than any period that it is stepped with
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
        """Time from a stamp until now, less the longest stall that ended in between."""
        age_ns = now_ns - stamp_ns
        forgiven_ns = 0
        for end_ns, length_ns in self._ended:
            if end_ns > stamp_ns:
                forgiven_ns = max(forgiven_ns, min(length_ns, end_ns - stamp_ns))
        return age_ns - forgiven_ns
