"""The hub: the Zenoh router that every other process is a client of.

It writes the endpoint that it listens at to standard output, one line. If it ends, all streams and
the Zenoh CAN buses fall silent, and the supervisor stops the stack. The official router (zenohd)
may stand in its place.
"""

import argparse
import logging
import signal
import sys
from collections.abc import Sequence

from services.core.errors import ServiceError
from services.core.live import GRACE_S, ROBOT_HELP, robot_name
from services.core.log import log_to_stderr
from services.core.loop import alive_key
from services.core.realtime import die_with_parent, request_scheduling
from services.core.session import ANY_FREE_PORT, open_hub
from services.processes import DEFAULT_ROBOT, HUB

logger = logging.getLogger(__name__)

STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)


def run_hub(arguments: Sequence[str] | None = None) -> int:
    """Route until a stop signal; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m services.hub")
    parser.add_argument("--robot", default=DEFAULT_ROBOT, help=ROBOT_HELP)
    parser.add_argument(
        "--listen", default=ANY_FREE_PORT, help="endpoint [a free port of the loopback interface]"
    )
    parser.add_argument("--parent", type=int, default=0, help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    log_to_stderr(HUB.name)
    if given.parent and not die_with_parent(given.parent):
        return 1
    # Blocked before Zenoh starts its threads, so that they wait for sigwait below.
    signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)
    scheduler = request_scheduling(HUB.fifo_priority, HUB.nice)
    try:
        hub = open_hub(given.listen)
    except ServiceError as error:
        logger.error("%s", error)  # noqa: TRY400  the sentence says it all
        return 1
    with hub:
        hub.announce(alive_key(robot_name(given.robot), HUB.name))
        logger.info("listening at %s, %s", hub.endpoint, scheduler)
        sys.stdout.write(f"{hub.endpoint}\n")
        sys.stdout.flush()
        signal.sigwait(STOP_SIGNALS)
        signal.alarm(GRACE_S)
    return 0


if __name__ == "__main__":
    raise SystemExit(run_hub())
