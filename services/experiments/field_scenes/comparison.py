"""Seeded scenes for a bare point and for the whole arm, every law on the same ones."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from services.core.errors import ConfigError
from services.experiments.field_scenes.plot import draw
from services.experiments.field_scenes.table import arm_table
from services.experiments.reporting import working
from services.experiments.rows import Row, publish, write
from services.experiments.whole_arm.jobs import replay, scene_of, setting_for
from services.experiments.whole_arm.rows import (
    HARD,
    LAWS,
    OURS,
    RANDOM,
    Found,
    answer_rows,
    by_law,
    gather,
    percent,
    rate_rows,
    tick_rows,
)

POINT, ARM, ALL = "point", "arm", "all"
LEVELS = (POINT, ARM, ALL)
SCENES, SHORT_SCENES = 100, 4
HARD_SCENES = 25
SHOWN_KIND, SHOWN_NUMBER = "5", 0
CHANGES = ("switch", "passing", "other arm", "enclosed", "both arms")
CHANGE_LAWS = ("dforc", "ulna")

EXPLANATION = """\
Whole arm: right arm and torso, 10 joints (both arms: 17); postures are executed as they come, every
10 ms, and judged, with four between two wherever it may matter, by pinocchio and coal, never by the
law's own distances. A feasible scene has a posture at the goal that is clear of everything by 15
mm; whether a way leads there is not known. dforc and pmp B are the papers' laws with the papers'
constants; notes: figures of the literature notes, of other scenes and three capsules, obstacles
only."""


def dforc_scenes(
    *,
    scenes: int = SCENES,
    level: str = ALL,
    seed: int = 0,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("dforc-scenes.png"),
) -> int:
    """Tables and a plot; 0 when every bar on the project's own law holds."""
    if level not in LEVELS:
        raise ConfigError(f"unknown level {level!r}; there are {', '.join(LEVELS)}")
    count = SHORT_SCENES if short else scenes
    console = Console()
    rows: list[Row] = []
    tables: list[Table] = []
    with working(console, f"scenes, seed {seed}") as tell:
        if level in (POINT, ALL):
            from services.experiments.field_scenes.point_scenes import point_scene_rows

            tell("bare point")
            rows += point_scene_rows(short, seed)
        if level in (ARM, ALL):
            found = gather(RANDOM, ("empty", *LAWS), count, seed, tell)
            hard = gather(HARD, LAWS, min(count, HARD_SCENES), seed, tell)
            changing = gather(CHANGES, CHANGE_LAWS, min(count, HARD_SCENES), seed, tell)
            found |= hard | changing
            rows += rate_rows(found) + tick_rows(found) + answer_rows(found)
            tables.append(arm_table(found, seed))
            _draw(found, seed, plot)
    for table in tables:
        console.print(table)
    barred = [row for row in rows if row.holds is not None or "whole arm, " not in row.name]
    status = publish(f"scenes of the force fields, seed {seed}", barred, None)
    if json is not None:
        write(rows, json)
    console.print(EXPLANATION)
    if level in (ARM, ALL):
        console.print(f"plot: {plot}")
    return status


def _draw(found: Found, seed: int, plot: Path) -> None:
    kinds = [kind for kind in (*RANDOM, *HARD) if (kind, OURS) in found]
    laws = [law for kind, law in found if kind == kinds[0] and law != "empty loop"]
    touched = {
        law: [
            percent(found[kind, law], lambda o: not o.verdict.is_clean)
            if (kind, law) in found
            else float("nan")
            for kind in kinds
        ]
        for law in laws
    }
    scene, _ = scene_of(SHOWN_KIND, SHOWN_NUMBER, seed)
    traces = {law: replay(SHOWN_KIND, SHOWN_NUMBER, seed, law)[1] for law in ("dforc", OURS)}
    example = setting_for(SHOWN_KIND), scene, traces
    draw(kinds, by_law(found, laws, kinds), touched, plot, example)
