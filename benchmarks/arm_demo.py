"""The arm demo: the right hand goes to and fro past a ball that somebody moves by hand.

    python -m benchmarks.arm_demo [--runs N] [--seed FIRST] [--virtual] [--stiff] [--json FILE]

Live: one process per service on emulated boards, the ball told of at a camera's rate with noise.
Judged on what the plant really did, by pinocchio and coal, and where the ball really was.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.arm_demo_job import ArmDemo, Shown
from services.config import load_robot
from services.core.clock import RealClock
from services.core.errors import ProcessDiedError
from services.core.live import robot_name
from services.core.loop import LiveExecutor
from services.emulated.simulation import Simulation
from services.experiments.rows import Row, at_least, at_most, publish
from services.stack import Stack
from services.stack_choice import choose_can, rows_for

ROBOT = "icub:reach"
RUNS = 20
LONGEST_S = 200.0
CHECK_EVERY_STEPS = 10
REACHED_PERCENT = 75.0  # a hand that never moves touches nothing, too


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--virtual", action="store_true", help="in virtual time")
    parser.add_argument("--stiff", action="store_true", help="position-controlled joints")
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.runs)
    rows = demo_rows(seeds, virtual=given.virtual, stiff=given.stiff)
    where = "in virtual time" if given.virtual else "live"
    return publish(f"arm demo, {where}", rows, given.json)


def demo_rows(seeds: range, *, virtual: bool, stiff: bool = False) -> list[Row]:
    """All runs, and whether they hold."""
    found = []
    for seed in seeds:
        shown = run_virtual(seed, stiff=stiff) if virtual else run_live(seed, stiff=stiff)
        _say(line(shown))
        found.append(shown)
    return rows_of(found, "virtual" if virtual else "live")


def rows_of(found: Sequence[Shown], where: str) -> list[Row]:
    """What the runs have in common, and its bars."""
    what = f"arm demo, {where}, {len(found)} runs"
    nearest = [1e3 * shown.verdict.obstacle.distance_m for shown in found]
    asked, reached = (sum(getattr(shown, name) for shown in found) for name in ("asked", "reached"))
    times = [t for shown in found for t in shown.times_s]
    return [
        at_most(f"{what}: runs with a contact", sum(n <= 0.0 for n in nearest), "", 0),
        at_most(f"{what}: runs that failed", sum(bool(shown.problem) for shown in found), "", 0),
        Row(f"{what}: runs with a joint made stiff", sum(bool(s.faults) for s in found), ""),
        Row(f"{what}: plant time over the clock's, slowest", min(s.realtime for s in found), ""),
        Row(f"{what}: nearest to the ball, of all", min(nearest), "mm"),
        Row(f"{what}: nearest to the ball, median", float(np.median(nearest)), "mm"),
        at_least(
            f"{what}: goals reached to 10 mm",
            100.0 * reached / max(1, asked),
            "%",
            REACHED_PERCENT,
        ),
        Row(f"{what}: time to a goal, median", float(np.median(times)) if times else None, "s"),
    ]


def line(shown: Shown) -> str:
    """One run."""
    near = shown.verdict.obstacle
    states = ", ".join(f"{name} {count}" for name, count in sorted(shown.states.items()))
    text = (
        f"seed {shown.seed}: nearest {1e3 * near.distance_m:.1f} mm ({near.pair[0]}, at "
        f"{shown.verdict.obstacle_s:.2f} s), {shown.reached} of {shown.asked} goals, "
        f"realtime {shown.realtime:.2f}; {states}"
    )
    return "; ".join([text, *shown.faults, *([shown.problem] if shown.problem else [])])


def run_virtual(seed: int, *, stiff: bool = False) -> Shown:
    """One run in virtual time."""
    robot = load_robot(ROBOT)
    job = ArmDemo(robot, seed, stiff=stiff)
    simulation = Simulation(robot, seed, guests={"reach": job})
    simulation.run(job, longest_ticks=LONGEST_S * 1000)
    simulation.close()
    return job.shown


def run_live(seed: int, *, stiff: bool = False) -> Shown:
    """One run on a stack of processes of its own."""
    robot = load_robot(ROBOT)
    job = ArmDemo(robot, seed, stiff=stiff)
    can, _ = choose_can(None, tuple(bus.channel for bus in robot.buses.values()))
    with Stack(ROBOT, can=can, seed=seed, rows=rows_for(robot), report=_say) as stack:
        try:
            _work(stack, job)
        except ProcessDiedError as error:
            job.shown.failure = str(error)
            _say(f"the end of the log of {error.process}:\n{error.log_tail}")
    return job.shown


def _work(stack: Stack, job: ArmDemo) -> None:
    executor = LiveExecutor("reach", job, stack.client.session, robot_name(ROBOT), RealClock())
    steps = 0

    def finished() -> bool:
        nonlocal steps
        steps += 1
        if steps % CHECK_EVERY_STEPS == 0:
            stack.check()
        return job.finished

    executor.run(finished)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
