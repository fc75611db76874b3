"""Where log lines of a process go, and how often one cause may speak."""

import logging
import sys

from services.core.clock import NS_PER_S

FORMAT = "%(asctime)s %(levelname)-7s {process}: %(message)s"


def log_to_stderr(process: str, level: int = logging.INFO) -> None:
    """Send this process's log lines to standard error, each with the process's name."""
    logging.basicConfig(
        level=level, stream=sys.stderr, format=FORMAT.format(process=process), force=True
    )
    logging.getLogger("can").setLevel(logging.WARNING)  # python-can reports every socket it opens


class OncePerSecond:
    """Lets each cause through at most once a second."""

    def __init__(self) -> None:
        self._spoke_ns: dict[str, int] = {}

    def allows(self, cause: str, now_ns: int) -> bool:
        """Whether this cause may be logged now."""
        last_ns = self._spoke_ns.get(cause)
        if last_ns is not None and now_ns - last_ns < NS_PER_S:
            return False
        self._spoke_ns[cause] = now_ns
        return True
