"""Streams of targets, 5 mm and 10 ms apart, each tick from the answer before."""

from collections.abc import Sequence

import numpy as np

from benchmarks.ik_setting import Setting
from services.experiments.ik_contenders import Contender, Nothing
from services.experiments.ik_measure import (
    KEPT_RAD,
    Run,
    Worth,
    follow,
    largest_step_rad,
    percent,
    worth,
)
from services.experiments.ik_paths import Path, joint_path, lemniscate
from services.experiments.ik_poses import OURS, REFERENCE, at
from services.experiments.ik_table import times
from services.experiments.rows import Row, at_least, at_most

IN_REACH, ACROSS = 1500, 1000
LAP = 280  # of the path across, and a little more
MEDIAN_MS, P99_MS = 0.15, 0.3
STEP_DEG, ACROSS_STEP_DEG = 4.0, 5.0
ROUNDED = 1e-9  # deg: the step limit itself, in floating point
SLOW = ("SciPy SLSQP, x = 0",)  # beside ticks of 10 ms


def rows(setting: Setting) -> list[Row]:
    """Two paths in reach and one that leaves it."""
    arm = setting.arm
    inside = (
        lemniscate(arm, setting.ticks(IN_REACH)),
        joint_path(arm, setting.seed, setting.ticks(IN_REACH)),
    )
    found: list[Row] = []
    across = lemniscate(arm, max(LAP, setting.ticks(ACROSS)), far=True)
    for path in (*inside, across):
        setting.say(f"{path.name}, {len(path)} ticks ...")
        field = [c for c in setting.contenders if c.name not in SLOW]
        runs = follow(field, path)
        worths = {name: worth(arm, path.position, path.rotation, run) for name, run in runs.items()}
        step_deg = ACROSS_STEP_DEG if path is across else STEP_DEG
        found += _bars(path, runs[OURS], worths[OURS], step_deg)
        if path is across:
            found += _across(path, runs[OURS], worths[OURS])
        found.append(_faster(path, runs))
        found += _everybody(path, runs, worths, field)
    return found


def _bars(path: Path, run: Run, w: Worth, step_deg: float) -> list[Row]:
    what, reached = f"{path.name} ({len(path)} ticks)", path.reached()
    good = w.feasible()[reached]
    step = float(np.degrees(largest_step_rad(run))) - ROUNDED
    return [
        at_least(f"{what}: 1 mm, limits kept, of those in reach", percent(good), "%", 100.0),
        at_most(f"{what}: largest joint step", step, "deg", step_deg),
        at_most(f"{what}: median (aim 0.03)", run.ms_at(50), "ms", MEDIAN_MS),
        at_most(f"{what}: p99 (aim 0.1)", run.ms_at(99), "ms", P99_MS),
    ]


def _across(path: Path, run: Run, w: Worth) -> list[Row]:
    """Out of the workspace and back."""
    what, out = f"{path.name} ({len(path)} ticks)", ~path.reached()
    excess = 1e3 * (w.distance_m - path.nearest_m)[out]
    return [
        Row(f"{what}: out of reach", percent(out), "%"),
        at_least(f"{what}: limits kept everywhere", percent(w.outside_rad <= KEPT_RAD), "%", 100.0),
        at_least(f"{what}: said so, of those out of reach by 1 mm", _told(path, run), "%", 100.0),
        Row(f"{what}: excess distance out there, p90", at(excess, 90), "mm"),
        Row(f"{what}: excess distance out there, largest", at(excess, 100), "mm"),
    ]


def _told(path: Path, run: Run) -> float:
    beyond = path.nearest_m > 1.1e-3
    return percent(run.said[beyond] == 0.0)


def _faster(path: Path, runs: dict[str, Run]) -> Row:
    share = runs[REFERENCE].ms_at(50) / runs[OURS].ms_at(50)
    return Row(f"{path.name}: reference over ours, median", share, "x")


def _everybody(
    path: Path, runs: dict[str, Run], worths: dict[str, Worth], field: Sequence[Contender]
) -> list[Row]:
    found = []
    for contender in field:
        name = contender.name
        w, run = worths[name], runs[name]
        found.append(Row(f"{path.name}: {name}, median/p99", times(run), "ms"))
        if name == OURS or isinstance(contender, Nothing):
            continue
        reached = percent(w.loosely_feasible()[path.reached()])
        rows_kept = percent(w.outside_rad <= 1e-5)
        step = np.degrees(largest_step_rad(run)) if np.isfinite(run.q).all() else np.inf
        cell = f"{reached:.1f} %, {rows_kept:.1f} %, {step:.3g} deg"
        found.append(Row(f"{path.name}: {name}, reached, limits kept, largest step", cell))
    return found
