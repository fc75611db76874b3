"""Whole-arm scenes by every law, and each failure with its scene and its cause.

    python -m services.experiments.whole_arm.scenes --n 1,5,wall,cup --scenes 20 --seed 1
        [--laws dforc,ulna] [--from 0] [--processes 1] [--quiet]

To see one again: services.experiments.whole_arm.jobs.replay(kind, number, seed, law).
"""

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from services.experiments.whole_arm.jobs import jobs_of, share
from services.experiments.whole_arm.lineup import LAWS
from services.experiments.whole_arm.run import Outcome


def summary(found: Sequence[Outcome]) -> str:
    """One law on one kind of scene, in a line."""
    count = len(found)
    times = [o.reached_s for o in found if o.reached_s is not None]
    both = sum(o.reached and o.is_clean for o in found)
    turned = sum(o.turned and o.is_clean for o in found)
    touched = sum(not o.is_clean for o in found)
    nearest = min(min(o.verdict.obstacle.distance_m, o.verdict.itself.distance_m) for o in found)
    ticks = np.concatenate([o.ticks_us for o in found])
    return (
        f"{found[0].law:18s} {found[0].family:10s} {count:4d} scenes: reached clean "
        f"{100 * both / count:5.1f} % (turned too {100 * turned / count:5.1f} %), "
        f"contact {100 * touched / count:5.1f} %, nearest {1e3 * nearest:6.1f} mm, "
        f"median {np.median(times) if times else np.nan:5.2f} s, tick "
        f"{np.median(ticks):.0f} us p99.9 {np.percentile(ticks, 99.9):.0f} us"
    )


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--n", default="1,2,5,10", help="kinds of scenes, comma between")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--laws", default="ulna", help=", ".join(LAWS))
    parser.add_argument("--processes", type=int, default=0, help="0: one per core")
    parser.add_argument("--quiet", action="store_true", help="no failures")
    given = parser.parse_args()
    kinds = given.n.split(",")
    numbers = range(given.first, given.first + given.scenes)
    found: dict[tuple[str, str], list[Outcome]] = {}
    for job, outcomes in share(
        jobs_of(kinds, given.laws.split(","), numbers, given.seed), given.processes
    ):
        for outcome in outcomes:
            found.setdefault((job.kind, outcome.law), []).append(outcome)
            cause = outcome.cause()
            if cause and not given.quiet:
                _say(f"  {outcome.law}, {outcome.family}, scene {outcome.number}: {cause}")
    for kind in kinds:
        for key, each in found.items():
            if key[0] == kind:
                _say(summary(each))
    return 0


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    raise SystemExit(main())
