"""A supervisor of a toy stack: tells the pids of its processes, then watches them until Ctrl-C."""

import sys

from services.processes import HUB, Process
from services.stack import Stack


def main() -> int:
    rows = (HUB, Process("echo", "tests.live.toy_echo"), Process("robot", "tests.live.toy_robot"))
    try:
        with Stack("icub", name="toys", rows=rows, report=say) as stack:
            sys.stdout.write(" ".join(str(pid) for pid in stack.pids.values()) + "\n")
            sys.stdout.flush()
            stack.wait()
    except KeyboardInterrupt:
        return 0
    return 1


def say(text: str) -> None:
    if "at work" not in text:
        sys.stdout.write(text + "\n")


if __name__ == "__main__":
    raise SystemExit(main())
