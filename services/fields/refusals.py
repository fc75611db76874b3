"""What was refused: counted, and logged once a second for each cause."""

import logging

from services.core.log import OncePerSecond

logger = logging.getLogger(__name__)


class Refusals:
    """Since the start."""

    def __init__(self) -> None:
        self.count = 0
        self.newest = ""
        self._throttle = OncePerSecond()

    def note(self, now_ns: int, reason: str) -> None:
        """One more."""
        self.count += 1
        self.newest = reason
        if self._throttle.allows(reason, now_ns):
            logger.warning("refused: %s", reason)
