"""Kills each process of the live stack in turn, while the arm holds its target compliantly.

    python -m benchmarks.faults [--json FILE] [--only NAME]

For each: whether the stack names it, how far the hand moves in the second after, and what is left.
"""

import argparse
import os
import signal
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.live import processes_left
from services.emulated.messages import PlantTruth
from services.experiments.rows import Row, at_most, publish
from services.messages import Vector3
from services.processes import PROCESSES
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_live import run_live
from services.stack import Stack

LIMP = ("boards", "hub")  # physics, or every bus, is gone: nothing is promised
HELD_BAR_MM = 5.0
SETTLE_LOOKS = 10  # a second of holding before the kill
SEEN_SAMPLES = 80  # most of the second in which the arm is watched after it


@dataclass
class Killer:
    """Kills one process once the arm holds, and keeps where the hand was."""

    name: str
    looks: int = 0
    killed: bool = False
    before_m: Vector3 | None = None
    truths: list[PlantTruth] = field(default_factory=list)

    def __call__(self, stack: Stack, job: Reach) -> None:
        """Look once: ten times a second."""
        if job.progress != "holding" or self.killed:
            return
        self.looks += 1
        if self.looks >= SETTLE_LOOKS and job.recording.truth is not None:
            self.before_m = job.recording.truth.tip_position_m
            os.kill(stack.pids[self.name], signal.SIGKILL)
            self.killed = True


def main() -> int:
    """One stack per victim."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--only", default="", choices=["", *(row.name for row in PROCESSES)])
    arguments = parser.parse_args()
    names = [arguments.only] if arguments.only else [row.name for row in PROCESSES]
    rows = [row for name in names for row in kill(name)]
    return publish("a killed process, live", rows, arguments.json)


def kill(name: str) -> list[Row]:
    """One run with one victim."""
    print(f"killing {name} ...", file=sys.stderr, flush=True)
    killer = Killer(name)
    options = ReachOptions(hold_s=30.0, position_bar_m=0.005)
    outcome = run_live("icub:reach", options, "", lambda _s, _w: None, _say, killer)
    failure = str(outcome.report["failure"])
    named = f"{name!r}" in failure
    rows = [
        Row(f"{name}: killed while holding", str(killer.killed), "", "True", killer.killed),
        Row(f"{name}: the stack names it", str(named), "", "True", named),
        Row(f"{name}: what it says", failure),
        at_most(f"{name}: processes left", len(processes_left()), "", 0),
    ]
    moved_mm = moved_after_mm(killer, outcome.recording.trace.tip_m)
    if name in LIMP:
        return [*rows, Row(f"{name}: hand moved", moved_mm, "mm")]
    return [
        *rows,
        at_most(f"{name}: hand moved while coming to a stop", moved_mm, "mm", HELD_BAR_MM),
    ]


def moved_after_mm(killer: Killer, path_m: list[Vector3]) -> float:
    """Largest distance of the hand from where it was at the kill, in what was still recorded."""
    if killer.before_m is None:
        return float("inf")
    before = np.array(killer.before_m)
    last = np.array(path_m[-SEEN_SAMPLES:])
    return float(np.linalg.norm(last - before, axis=1).max()) * 1e3


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
