"""Every figure of the closed loops on the boards, over several plants.

    python -m benchmarks.closed_loop [--json FILE] [--robot NAME] [--seeds N] [--short]

Virtual time. The whole robot takes one to three minutes a plant; --short takes one plant and fewer
joints, pushes and seconds.
"""

import argparse
import sys
from functools import partial
from pathlib import Path

from services.config import load_robot
from services.experiments.loops.closed_loop import WHOLE_ROBOT, Found, run
from services.experiments.rows import Row, publish

PROGRESS_S = 10.0
TICK_S = 0.1  # between two calls of progress


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--robot", default=WHOLE_ROBOT)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--short", action="store_true")
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    whole = Found()
    for seed in range(1 if arguments.short else arguments.seeds):
        whole.add(run(robot, seed, short=arguments.short, progress=partial(_say, seed)))
    rows = [*whole.rows(), Row("virtual time of all runs", whole.virtual_s, "s")]
    return publish(f"closed loops, {arguments.robot}, virtual time", rows, arguments.json)


def _say(seed: int, at_s: float, what: str) -> None:
    if at_s % PROGRESS_S < TICK_S:
        print(f"plant {seed}, {at_s:.0f} s: {what}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
