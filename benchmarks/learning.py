"""Figures of the learner: cost, accuracy, safety against contacts, endurance.

    python -m benchmarks.learning --only update,fig7 --data icubdyn.tgz --json learning.json

Parts: update, fig7, gate, unseen, change; endurance takes a minute and is run by name only.
"""

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # everything else is imported after BLAS has been told to use one thread
    from services.experiments.rows import Row

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
BY_NAME_ONLY = ("endurance",)


def update(_: Path | None) -> "list[Row]":
    """Cost of a sample, and of a snapshot."""
    from benchmarks.learning_update import kernel_ridge_rows, snapshot_rows, update_rows

    return [*update_rows(), *kernel_ridge_rows(), *snapshot_rows()]


def fig7(data: Path | None) -> "list[Row]":
    """Accuracy on the recording."""
    from services.experiments.forces.arm_learning import load_task
    from services.experiments.forces.fig7 import measure, rows_of

    return rows_of(measure(load_task(data), 25, (200, 1000), False, _say))


def gate(data: Path | None) -> "list[Row]":
    """Pushes injected into the recording."""
    from benchmarks.learning_gate import gate_rows
    from services.experiments.forces.arm_learning import load_task

    return gate_rows(load_task(data), _say)


def unseen(_: Path | None) -> "list[Row]":
    """Unseen motion of a made arm; the whole comparison is `ulna experiment force-fig6`."""
    from services.experiments.forces.fig6 import Sizes, measure, rows_of
    from services.experiments.forces.made_arm import made_arm

    sizes = Sizes(features=(200, 500))
    arm = made_arm(0, sizes.rollouts, sizes.rows, sizes.unseen, sizes.unseen_rows)
    rows = rows_of(measure(arm, sizes, 1, _say), short=False)
    return [row for row in rows if ":" not in row.name]  # not joint by joint


def change(data: Path | None) -> "list[Row]":
    """A load in the hand."""
    from benchmarks.learning_change import change_rows
    from services.experiments.forces.arm_learning import load_task

    return change_rows(load_task(data), _say)


def endurance(_: Path | None) -> "list[Row]":
    """A million updates."""
    from benchmarks.learning_endurance import endurance_rows

    return endurance_rows(1_000_000, 500, _say)


PARTS: dict[str, Callable[[Path | None], "list[Row]"]] = {
    "update": update,
    "fig7": fig7,
    "gate": gate,
    "unseen": unseen,
    "change": change,
    "endurance": endurance,
}


def _say(what: str) -> None:
    print(what, file=sys.stderr, flush=True)


def main() -> int:
    """Run the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--only", default="", help=f"of {', '.join(PARTS)}; comma between")
    parser.add_argument("--data", type=Path, default=None, help="the recording icubdyn.tgz")
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    wanted = given.only.split(",") if given.only else [n for n in PARTS if n not in BY_NAME_ONLY]
    unknown = sorted(set(wanted) - set(PARTS))
    if unknown:
        parser.error(f"no part {unknown[0]}; there are {', '.join(PARTS)}")
    if any(os.environ.get(name) != "1" for name in ONE_THREAD):
        # read when numpy is loaded; threads on two cores would measure each other
        os.execve(sys.executable, sys.orig_argv, os.environ | ONE_THREAD)
    from services.core.errors import ConfigError
    from services.experiments.rows import Row, publish

    rows = []
    for name in wanted:
        _say(f"{name} ...")
        try:
            rows += PARTS[name](given.data)
        except ConfigError as error:  # no recording here
            rows.append(Row(name, None, "", str(error), False))
    return publish("Learning of internal dynamics", rows, given.json)


if __name__ == "__main__":
    raise SystemExit(main())
