"""What went wrong, as text with its evidence; counts of what was dropped, refused or clamped."""

import logging
from collections import deque
from typing import NamedTuple

logger = logging.getLogger(__name__)

REPEAT_NS = 1_000_000_000  # one report per second and cause
KEPT = 96  # a whole robot says 73 things when its emergency button is pressed
COUNTED_CAUSES = 100  # apart from each other: any bytes may come from a bus
APART = 40  # of those, members of a family
OTHER = "other causes"
KEPT_CAUSES = 256  # boards can print anything


class Fault(NamedTuple):
    """One report; `frames` are the last frames of the board concerned, decoded, oldest first."""

    stamp_ns: int
    text: str
    frames: tuple[str, ...] = ()


class FaultLog:
    """Reports of one robot, newest last, and counts by cause.

    A cause that repeats is reported once a second; `count` counts reports.
    """

    def __init__(self) -> None:
        self.events: deque[Fault] = deque(maxlen=KEPT)
        self.count = 0
        self.drops: dict[str, int] = {}
        self.refusals: dict[str, int] = {}
        self.clamps: dict[str, int] = {}
        self._last_ns: dict[str, int] = {}

    def report(self, now_ns: int, text: str, cause: str = "", frames: tuple[str, ...] = ()) -> None:
        """Add a fault; with a `cause`, at most one per second of that cause."""
        if cause:
            last_ns = self._last_ns.get(cause)
            if last_ns is not None and now_ns - last_ns < REPEAT_NS:
                return
            if len(self._last_ns) >= KEPT_CAUSES:
                recent = self._last_ns.items()
                self._last_ns = {text: ns for text, ns in recent if now_ns - ns < REPEAT_NS}
            self._last_ns[cause] = now_ns
        self.count += 1
        self.events.append(Fault(now_ns, text, frames))
        logger.warning("%s%s", text, "".join(f"\n    {frame}" for frame in frames))

    def drop(self, cause: str, family: str = "") -> None:
        """Count a received frame that could not be used.

        A `cause` of a `family` with many members, such as identifiers, is counted by itself while
        there is room for it, and then with its family.
        """
        if family and cause not in self.drops and len(self.drops) >= APART:
            cause = family
        _count(self.drops, cause, 1)

    def refuse(self, cause: str, count: int = 1) -> None:
        """Count commands that were not carried out."""
        _count(self.refusals, cause, count)

    def clamp(self, cause: str) -> None:
        """Count a set-point that was sent, but not as given."""
        _count(self.clamps, cause, 1)


def _count(counts: dict[str, int], cause: str, more: int) -> None:
    if cause not in counts and len(counts) >= COUNTED_CAUSES:
        cause = OTHER
    counts[cause] = counts.get(cause, 0) + more
