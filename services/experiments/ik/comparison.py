"""Solvers of inverse kinematics side by side: ours, a stock one, and what others would use."""

import json as json_text
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from services.experiments.ik.arm import Arm, measured_arm, robot_arm
from services.experiments.ik.field import everybody
from services.experiments.ik.plot import draw
from services.experiments.ik.poses import SETS, Sample, bars, sample
from services.experiments.ik.sets import SHORT, Say, Sizes
from services.experiments.ik.table import PUBLISHED, Line, lines, tables
from services.experiments.rows import Row, publish

EXPLANATION = """\
Time of this thread's processor, best of three, everybody in turn on the same pose; TRAC-IK has two
threads: time on the wall. Reached: within 1.1 mm, limits and rows to 1e-5 rad; best: objective of
eq. 11 within 1 % + 1e-3 of many starts. Excess: beyond the smallest angle or distance that many
starts of an independent solver found. Published before: on a machine about twice as fast."""


def measure(arm: Arm, seed: int, sizes: Sizes, say: Say) -> tuple[dict[str, Sample], list[Row]]:
    """Everybody on all four sets, and who is missing."""
    field, missing = everybody(arm)
    return {name: sample(name, arm, field, seed, sizes, say) for name in SETS}, missing


def ik(
    *,
    robot: str = "",
    seed: int = 0,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("ik.png"),
) -> int:
    """The table and the plot: 0 when every bar on our answers holds.

    Bars hold for the arm of the published figures only; another robot's figures have none.
    """
    arm = robot_arm(robot) if robot else measured_arm()
    console = Console()
    with Progress(
        SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), console=console
    ) as progress:
        shown = progress.add_task("loading", total=None)

        def say(what: str) -> None:
            progress.update(shown, description=what)

        samples, missing = measure(arm, seed, SHORT if short else Sizes(), say)
    draw(samples, plot)
    found = lines(samples)
    for table in tables(f"{arm.name}, seed {seed}", found, published=not robot):
        console.print(table)
    console.print(EXPLANATION)
    rows = [] if robot else [row for part in samples.values() for row in bars(part)]
    status = publish("our answers", [*rows, *missing], json)
    if json is not None:
        _add_lines(json, found)
    console.print(f"plot: {plot}")
    return status


def _add_lines(file: Path, found: list[Line]) -> None:
    content = json_text.loads(file.read_text(encoding="utf-8"))
    content["solvers"] = [asdict(line) for line in found]
    content["published"] = [asdict(line) for line in PUBLISHED]
    file.write_text(json_text.dumps(content, indent=2) + "\n", encoding="utf-8")
