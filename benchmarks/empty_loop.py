"""An idle 1 kHz process: how late this machine wakes a process that does nothing.

It runs beside every live measurement, at the same priority, because no loop can do better.
"""

import json
import signal
import sys
from types import FrameType

from services.core.clock import RealClock
from services.core.realtime import request_scheduling
from services.core.timing import Durations

PERIOD_NS = 1_000_000
PRIORITY = 50  # that of the boards and robot processes


def main() -> int:
    """Run until a stop signal, then print median and 99th percentile of the lateness in us."""
    stopped = False

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal stopped
        stopped = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    scheduler = request_scheduling(PRIORITY, 0)
    clock, lateness = RealClock(), Durations()
    deadline_ns = clock.now_ns() + PERIOD_NS
    while not stopped:
        clock.sleep_until(deadline_ns)
        lateness.add(clock.now_ns() - deadline_ns)
        deadline_ns = max(deadline_ns + PERIOD_NS, clock.now_ns())
    p50_ns, p99_ns = lateness.percentiles_ns(50, 99)
    json.dump({"p50_us": p50_ns / 1e3, "p99_us": p99_ns / 1e3, "scheduler": scheduler}, sys.stdout)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
