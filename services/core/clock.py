"""The only file that knows the time."""

import ctypes
import time
from typing import Protocol

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000

wall_ns = time.perf_counter_ns
"""Stopwatch for statistics [ns]. Never an input of a decision: results must not depend on it."""

thread_cpu_ns = time.thread_time_ns
"""What the calling thread has used of a processor [ns]. For statistics only, like `wall_ns`."""


def wall_clock_text() -> str:
    """Date and time of day for names of files and reports, as 20260131-235959."""
    return time.strftime("%Y%m%d-%H%M%S")


TIMER_ABSTIME = 1


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


_clock_nanosleep = ctypes.CDLL(None).clock_nanosleep


class Clock(Protocol):
    """Time as an executor, a bus or a service edge sees it."""

    def now_ns(self) -> int:
        """Instant now, in ns since an arbitrary origin that stays the same for the whole host."""

    def sleep_until(self, deadline_ns: int) -> None:
        """Wait for an absolute instant; return at once when it has passed."""


class RealClock:
    """The host's monotonic clock."""

    now_ns = staticmethod(time.monotonic_ns)

    def since_day_clock_ns(self) -> int:
        """What to add to an instant of the clock of the day, as the kernel stamps it [ns]."""
        return time.monotonic_ns() - time.time_ns()

    def sleep_until(self, deadline_ns: int) -> None:
        """Wait for an absolute instant.

        One system call; time.sleep needs the time to sleep, so the time now, twice: three calls,
        and 40 us more a millisecond on a virtual kernel.
        """
        instant = _Timespec(deadline_ns // NS_PER_S, deadline_ns % NS_PER_S)
        while _clock_nanosleep(time.CLOCK_MONOTONIC, TIMER_ABSTIME, ctypes.byref(instant), None):
            pass  # a signal came; its handler has run by now


class VirtualClock:
    """A clock that moves only when it is told to."""

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def now_ns(self) -> int:
        """Instant that the clock was last moved to."""
        return self._now_ns

    def advance_ns(self, step_ns: int) -> None:
        """Move forward; a clock never goes back."""
        if step_ns < 0:
            raise ValueError(f"a clock cannot go back by {-step_ns} ns")
        self._now_ns += step_ns

    def sleep_until(self, deadline_ns: int) -> None:
        """Jump to the instant: in virtual time nobody waits."""
        self._now_ns = max(self._now_ns, deadline_ns)
