"""Single poses: the bars on our answers, their times beside everybody's, and the table of all."""

import sys
from collections.abc import Mapping
from dataclasses import asdict

from rich.console import Console

from benchmarks.ik_setting import Setting
from services.experiments.ik.poses import (
    COLD,
    NEAR,
    OURS,
    POSITION,
    REFERENCE,
    SETS,
    TRAC,
    Sample,
    bars,
    sample,
)
from services.experiments.ik.table import lines, tables, times
from services.experiments.rows import Row, at_least, at_most

FASTER, P99_FASTER = 15.0, 10.0
OUT_P99_MS = 1.5


def rows(setting: Setting) -> list[Row]:
    """All four sets."""
    arm, seed = setting.arm, setting.seed
    samples = {
        name: sample(name, arm, setting.contenders, seed, setting.sizes, setting.say)
        for name in SETS
    }
    found: list[Row] = []
    for name, part in samples.items():
        found += bars(part)
        found += _times(part)
        if name in (COLD, NEAR):
            found += _ratios(part)
        if name == POSITION:
            what = "position out of reach: p99"
            found.append(at_most(what, part.runs[OURS].ms_at(99), "ms", OUT_P99_MS))
    for table in tables(f"{arm.name}, seed {seed}", lines(samples)):
        Console(file=sys.stderr, width=120).print(table)
    return found + _cells(samples)


def _times(part: Sample) -> list[Row]:
    """Of everybody; the empty call is what measuring costs."""
    return [
        Row(f"{part.name}: {name}, median/p99", times(run), "ms") for name, run in part.runs.items()
    ]


def _ratios(part: Sample) -> list[Row]:
    ours, reference = part.runs[OURS], part.runs[REFERENCE]
    faster = [reference.ms_at(p) / ours.ms_at(p) for p in (50, 99)]
    found = [
        at_least(f"{part.name}: reference over ours, median (aim 40)", faster[0], "x", FASTER),
        at_least(f"{part.name}: reference over ours, p99", faster[1], "x", P99_FASTER),
    ]
    if TRAC in part.runs:
        share = part.runs[TRAC].ms_at(50) / ours.ms_at(50)
        found.append(Row(f"{part.name}: TRAC-IK (wall) over ours, median", share, "x", "aim 1"))
    return found


def _cells(samples: Mapping[str, Sample]) -> list[Row]:
    """The table's cells that are no times."""
    found = []
    for line in lines(samples):
        for column, cell in asdict(line).items():
            if column != "solver" and not column.endswith("_ms") and cell:
                found.append(Row(f"table, {column}: {line.solver}", cell))
    return found
