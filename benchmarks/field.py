"""Every figure of the force fields: papers' laws, scenes, whole arm, moving obstacles, live runs.

    python -m benchmarks.field [--only paper,pmp,...] [--short] [--seed N] [--json FILE]

All laws on the same scenes and seeds. Times are of this thread's processor, the empty loop's beside
them. The live runs start processes of their own, 20 runs of about a minute.
"""

import argparse
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # everything else is imported after BLAS has been told to use one thread
    from services.experiments.rows import Row

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
SCENES, HARD_SCENES, SHORT_SCENES = 100, 25, 4
LIVE_RUNS, SHORT_LIVE_RUNS = 20, 2


@dataclass(frozen=True)
class Given:
    """What was asked for."""

    short: bool
    seed: int


def paper(given: Given) -> "list[Row]":
    """The paper's field: force, free reach, tails, head-on."""
    from services.experiments.field_figures.paper import paper_rows

    return paper_rows(given.short, given.seed)


def pmp(given: Given) -> "list[Row]":
    """The Passive Motion Paradigm on its 200 targets a row."""
    from services.experiments.field_figures.pmp import pmp_rows

    return pmp_rows(given.short, given.seed)


def targets(given: Given) -> "list[Row]":
    """DForC through virtual point and inverse kinematics on the same targets."""
    from services.experiments.field_figures.targets import dforc_targets_rows

    return dforc_targets_rows(given.short, given.seed, _say)


def point(given: Given) -> "list[Row]":
    """A bare point among balls and in the hard families, every mode."""
    from services.experiments.field_scenes.point_scenes import point_scene_rows

    return point_scene_rows(given.short, given.seed)


def moving(given: Given) -> "list[Row]":
    """A target that moves, an obstacle that descends, noise on both."""
    from services.experiments.field_scenes.moving import moving_rows

    return moving_rows(given.short, given.seed)


def arm(given: Given) -> "list[Row]":
    """The whole arm, every law; time of a tick; answers to new goals."""
    from services.experiments.whole_arm.rows import (
        HARD,
        LAWS,
        RANDOM,
        answer_rows,
        gather,
        rate_rows,
        tick_rows,
    )

    count = SHORT_SCENES if given.short else SCENES
    hard = min(count, HARD_SCENES)
    found = gather(RANDOM, ("empty", *LAWS), count, given.seed, _say)
    found |= gather(HARD, LAWS, hard, given.seed, _say)
    found |= gather(("switch",), ("dforc", "ulna"), count, given.seed, _say)
    return rate_rows(found) + tick_rows(found) + answer_rows(found)


def changing(given: Given) -> "list[Row]":
    """The whole arm while something else moves: balls, the other arm, a cage; both arms at once."""
    from services.experiments.whole_arm.rows import gather, rate_rows

    count = SHORT_SCENES if given.short else HARD_SCENES
    kinds = ("passing", "other arm", "enclosed", "both arms")
    return rate_rows(gather(kinds, ("dforc", "ulna"), count, given.seed, _say))


def live(given: Given) -> "list[Row]":
    """The arm demo, by the wall clock."""
    from benchmarks.arm_demo import demo_rows

    runs = SHORT_LIVE_RUNS if given.short else LIVE_RUNS
    return demo_rows(range(given.seed, given.seed + runs), virtual=False)


def virtual(given: Given) -> "list[Row]":
    """The same in virtual time."""
    from benchmarks.arm_demo import demo_rows

    runs = SHORT_LIVE_RUNS if given.short else LIVE_RUNS
    return demo_rows(range(given.seed, given.seed + runs), virtual=True)


PARTS: "dict[str, Callable[[Given], list[Row]]]" = {
    "paper": paper,
    "pmp": pmp,
    "targets": targets,
    "point": point,
    "moving": moving,
    "arm": arm,
    "changing": changing,
    "virtual": virtual,
    "live": live,
}


def main() -> int:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--only", default=",".join(PARTS), help="some of the parts")
    parser.add_argument("--seed", type=int, default=0, help="of the scenes")
    parser.add_argument("--short", action="store_true", help="fewer of everything")
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    names = [name for name in given.only.split(",") if name]
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        parser.error(f"--only: unknown {', '.join(unknown)}; known: {', '.join(PARTS)}")
    if any(os.environ.get(name) != "1" for name in ONE_THREAD):
        # read when numpy is loaded; threads on two cores would measure each other
        os.execve(sys.executable, sys.orig_argv, os.environ | ONE_THREAD)
    from services.experiments.rows import Row, publish

    rows: list[Row] = []
    for name in names:
        _say(f"{name} ...")
        rows += PARTS[name](Given(given.short, given.seed))
    return publish(f"force fields, seed {given.seed}", rows, given.json)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
