"""Whether the field's periods begin in time: a point that is late gives way late.

A warning once for each time that it happens: it is over after a second without a late period.
"""

import logging
from collections import deque

from services.core.clock import NS_PER_MS, NS_PER_S

logger = logging.getLogger(__name__)

WINDOW_NS = NS_PER_S
LATE_MS = 50.0  # five periods


class Lateness:
    """Of the last second, and how often it was too much."""

    def __init__(self) -> None:
        self.count = 0  # times since the start
        self._kept: deque[tuple[int, int]] = deque()  # when, how late; later ones are less late
        self._is_late = False

    @property
    def largest_ms(self) -> float:
        """Of the last second."""
        return self._kept[0][1] / NS_PER_MS if self._kept else 0.0

    def note(self, now_ns: int, late_ns: int) -> None:
        """A period has begun, and so late."""
        kept = self._kept
        while kept and kept[-1][1] <= late_ns:
            kept.pop()
        kept.append((now_ns, late_ns))
        while now_ns - kept[0][0] > WINDOW_NS:
            kept.popleft()
        was_late, self._is_late = self._is_late, self.largest_ms > LATE_MS
        if self._is_late and not was_late:
            self.count += 1
            logger.warning(
                "a period began %.0f ms late: the processor has too much to do, and the arm gets "
                "out of the way so much later",
                self.largest_ms,
            )
