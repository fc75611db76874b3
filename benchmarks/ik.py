"""Every figure of inverse kinematics: reachable, unreachable, tracking, changes, both arms.

    python -m benchmarks.ik [--only reachable,orientation,...] [--seeds 0,1] [--short] [--json FILE]

One process, everybody in turn on the same target, time of this thread's processor (TRAC-IK has
threads of its own: time on the wall), best of three, percentiles over the targets. What the
targets can at best get is found by many starts of an independent solver and kept in the temporary
folder: the first run takes some minutes more.
"""

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # everything else is imported after BLAS has been told to use one thread
    from benchmarks.ik_setting import Setting
    from services.experiments.rows import Row

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def kinematics(setting: "Setting") -> "list[Row]":
    """The kinematics that judge, against the project's."""
    from benchmarks.ik_kinematics import rows

    return rows(setting)


def poses(setting: "Setting") -> "list[Row]":
    """Poses in reach, cold and near; orientation and position out of reach."""
    from benchmarks.ik_poses import rows

    return rows(setting)


def tracking(setting: "Setting") -> "list[Row]":
    """5 mm per 10 ms: in reach, along a path of the joints, and out of the workspace."""
    from benchmarks.ik_tracking import rows

    return rows(setting)


def changes(setting: "Setting") -> "list[Row]":
    """Another problem from one answer to the next."""
    from benchmarks.ik_changes import rows

    return rows(setting)


def deadline(setting: "Setting") -> "list[Row]":
    """Searches that are cut short."""
    from benchmarks.ik_deadline import rows

    return rows(setting)


def arms(setting: "Setting") -> "list[Row]":
    """Both arms over one waist, and the robot's own arm."""
    from benchmarks.ik_arms import rows

    return rows(setting)


PARTS: "dict[str, Callable[[Setting], list[Row]]]" = {
    "kinematics": kinematics,
    "poses": poses,
    "tracking": tracking,
    "changes": changes,
    "deadline": deadline,
    "arms": arms,
}


def main() -> int:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--only", default=",".join(PARTS), help="some of the parts")
    parser.add_argument("--seeds", default="0", help="of the targets, comma between")
    parser.add_argument("--short", action="store_true", help="fewer of everything, no peers")
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    names = [name for name in given.only.split(",") if name]
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        parser.error(f"--only: unknown {', '.join(unknown)}; known: {', '.join(PARTS)}")
    seeds = [int(seed) for seed in given.seeds.split(",")]
    if any(os.environ.get(name) != "1" for name in ONE_THREAD):
        # read when numpy is loaded; threads on two cores would measure each other
        os.execve(sys.executable, sys.orig_argv, os.environ | ONE_THREAD)
    from benchmarks.ik_setting import setting
    from services.experiments.rows import Row, publish

    rows: list[Row] = []
    for seed in seeds:
        made = setting(seed, given.short, _say)
        rows += made.missing
        for name in names:
            _say(f"{name}, seed {seed} ...")
            found = PARTS[name](made)
            rows += found if len(seeds) == 1 else [made.labelled(row) for row in found]
    return publish(f"inverse kinematics, seeds {given.seeds}", rows, given.json)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
