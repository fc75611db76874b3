"""Streams of targets, 5 mm and 10 ms apart, each tick from the answer before."""

import numpy as np

from benchmarks.ik_setting import Setting
from services.experiments.ik.contenders import Nothing
from services.experiments.ik.measure import (
    KEPT_RAD,
    LOOSE_RAD,
    Run,
    Worth,
    follow,
    largest_step_rad,
    percent,
    worth,
)
from services.experiments.ik.paths import Path, joint_path, lemniscate
from services.experiments.ik.poses import OURS, REFERENCE, at
from services.experiments.ik.table import times
from services.experiments.rows import Row, at_least, at_most

IN_REACH, ACROSS = 1500, 1000
LAP = 280  # ticks of the path across, and a little more
EVERYBODY = 500
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
    across = lemniscate(arm, max(LAP, setting.ticks(ACROSS)), far=True)
    found: list[Row] = []
    for path in (*inside, across):
        setting.say(f"{path.name}, {len(path)} ticks ...")
        run = follow([c for c in setting.contenders if c.name == OURS], path)[OURS]
        w = worth(arm, path.position, path.rotation, run)
        found += _bars(path, run, w, ACROSS_STEP_DEG if path is across else STEP_DEG)
        if path is across:
            found += _across(path, run, w)
        found += _everybody(setting, path.cut(setting.ticks(EVERYBODY)))
    return found


def _bars(path: Path, run: Run, w: Worth, step_deg: float) -> list[Row]:
    what, good = f"{path.name} ({len(path)} ticks)", w.feasible()
    step = float(np.degrees(largest_step_rad(run))) - ROUNDED
    inner = path.well_reached()
    return [
        at_least(f"{what}: 1 mm, limits kept, of those in reach", percent(good[inner]), "%", 100.0),
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
        Row(f"{what}: 1 mm, of those in reach to a hair", percent(w.feasible()[~out]), "%"),
        at_least(f"{what}: limits kept everywhere", percent(w.outside_rad <= KEPT_RAD), "%", 100.0),
        at_least(f"{what}: said so, of those out of reach by 1 mm", _told(path, run), "%", 100.0),
        Row(f"{what}: excess distance out there, p90", at(excess, 90), "mm"),
        Row(f"{what}: excess distance out there, largest", at(excess, 100), "mm"),
    ]


def _told(path: Path, run: Run) -> float:
    beyond = path.nearest_m > 1.1e-3
    return percent(run.said[beyond] == 0.0)


def _everybody(setting: Setting, path: Path) -> list[Row]:
    """All of them in turn, over the first ticks."""
    runs = follow([c for c in setting.contenders if c.name not in SLOW], path)
    what, found = f"{path.name}, {len(path)} ticks", []
    share = runs[REFERENCE].ms_at(50) / runs[OURS].ms_at(50)
    found.append(Row(f"{what}: reference over ours, median", share, "x"))
    for name, run in runs.items():
        found.append(Row(f"{what}: {name}, median/p99", times(run), "ms"))
        if name == Nothing.name:
            continue
        w = worth(setting.arm, path.position, path.rotation, run)
        reached = percent(w.loosely_feasible()[path.reached()])
        kept = percent(w.outside_rad <= LOOSE_RAD)
        step_deg = np.degrees(largest_step_rad(run))
        cell = f"{reached:.1f} %, {kept:.1f} %, {step_deg:.3g} deg"
        found.append(Row(f"{what}: {name}, reached, limits kept, largest step", cell))
    return found
