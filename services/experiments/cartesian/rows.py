"""What the Cartesian experiment found: tables of all controllers, and this project's bars."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from services.experiments.cartesian.course import Course
from services.experiments.cartesian.figures import KEPT, Metric, metrics_of, shown_metrics
from services.experiments.cartesian.metrics import Estimate
from services.experiments.rows import Row, at_most, within

OWN = "ulna"
LAG_SHARE = 0.05 * 0.564  # of T times speed: a twentieth of what iKin's law lags behind
LEAST_SHOWN = 5e-4
SLOW_M_S = 0.025  # the prototype's lemniscate
WIDE = 150  # columns of a whole table, and of one that no terminal shows
STANDS = {"ideal": "ideal arm", "lagged": "lagging arm", "boards": "boards"}

# A prototype that was run before this code was written, on the model iCubGazeboV2_5 with the ideal
# arm, T = 1 s: on this pair of poses where a number exists, else the median of ten random moves.
# Lemniscate: T = 0.6 s, 23 mm/s.
PROTOTYPE: dict[tuple[str, str, str], Mapping[str, str]] = {
    ("point to point", "ideal", "ulna"): {
        "perpendicular": "0.7",
        "deviation": "0.8",
        "profile": "0.24",
        "t98_s": "0.88 T",
        "peak": "0.56",
        "jerk": "0.91",
        "row_deg": "0",
    },
    ("point to point", "ideal", "reference"): {
        "perpendicular": "12.4",
        "deviation": "14.6",
        "profile": "5.8",
        "t98_s": "1.42 T",
        "peak": "0.27",
        "jerk": "1.86",
        "row_deg": "0",
    },
    ("point to point", "ideal", "vite"): {
        "perpendicular": "1.6",
        "deviation": "16.0",
        "profile": "10.3",
        "t98_s": "1.50",
        "peak": "0.17",
        "jerk": "29",
        "row_deg": "2.4",
    },
    ("point to point", "ideal", "dls"): {
        "perpendicular": "7-13",
        "deviation": "16.7",
        "profile": "10.1",
        "t98_s": "4.2",
        "peak": "0.12",
        "jerk": "370",
        "row_deg": "11.6",
    },
    ("point to point", "lagged", "reference"): {"jerk": "1.7", "row_deg": "2"},
    ("point to point", "lagged", "vite"): {"jerk": "2.6"},
    ("point to point", "lagged", "dls"): {"jerk": "66"},
    ("lemniscate", "ideal", "ulna"): {"tracking_mm": "0.2"},
    ("lemniscate", "ideal", "reference"): {"tracking_mm": "7.4"},
    ("lemniscate", "ideal", "vite"): {"tracking_mm": "11"},
    ("lemniscate", "ideal", "dls"): {"tracking_mm": "137"},
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One controller on one plant along one course: means over the repetitions."""

    course: Course
    degrees_of_freedom: int
    plant: str
    controller: str
    figures: Mapping[str, Estimate]


def print_tables(console: Console, cells: Sequence[Cell]) -> None:
    """One table for each course and number of joints."""
    wide = console if console.is_terminal else Console(width=max(console.width, WIDE))
    kinds = dict.fromkeys((cell.course.name, cell.degrees_of_freedom) for cell in cells)
    for kind in kinds:
        chosen = [cell for cell in cells if (cell.course.name, cell.degrees_of_freedom) == kind]
        wide.print(_table(chosen, whole=wide.width >= WIDE))


def _table(cells: Sequence[Cell], *, whole: bool) -> Table:
    course = cells[0].course
    metrics = [metric for metric in shown_metrics(course) if whole or metric.first]
    title = f"{course.name}, {cells[0].degrees_of_freedom} DoF, T = {course.trajectory_time_s:g} s"
    table = Table(title=title, title_justify="left", caption=_caption(course, metrics))
    table.add_column("arm", no_wrap=True)
    table.add_column("controller", no_wrap=True)
    for metric in metrics:
        table.add_column(f"{metric.heading}\n{metric.unit}", justify="right", no_wrap=True)
    before = ""
    for cell in cells:
        if before and cell.plant != before:
            table.add_section()
        shown = [_shown(cell.figures[metric.key]) for metric in metrics]
        count = max(figure.count for figure in cell.figures.values())
        stands = f"{STANDS[cell.plant]}, n = {count}" if cell.plant != before else ""
        table.add_row(stands, cell.controller, *shown)
        known = PROTOTYPE.get((course.name, cell.plant, cell.controller))
        if known and (course.moves or _speed_m_s(course) < SLOW_M_S):
            beside = [known.get(metric.key, "") for metric in metrics]
            table.add_row("", "prototype", *beside, style="dim")
        before = cell.plant
    return table


def _caption(course: Course, metrics: Sequence[Metric]) -> str:
    """What the headings mean, and what could not be reached."""
    unclear = (metric for metric in metrics if metric.heading != "error")
    meanings = "; ".join(f"{metric.heading}: {metric.meaning}" for metric in unclear)
    return f"{_given_up(course)}. {meanings}. prototype: published before"


def _given_up(course: Course) -> str:
    off_deg = math.degrees(course.given_up_rad)
    if course.given_up_m < 2e-4 and off_deg < 1.0:
        return "every pose is within reach"
    return (
        "not every pose is within reach: the nearest stand in, up to "
        f"{course.given_up_m * 1e3:.1f} mm and {off_deg:.1f} deg away; errors are against these"
    )


def _shown(figure: Estimate) -> str:
    mean, half = figure.mean, figure.half_width
    if mean < LEAST_SHOWN:
        return "0"
    text = f"{mean:.3g}" if mean < 1e4 else f"{mean:.1e}"
    return f"{text}\n±{half:.2g}" if half > 0.01 * mean else text


def all_rows(cells: Sequence[Cell]) -> list[Row]:
    """Every figure of every controller, those of this project's with their bars."""
    rows = [
        row for cell in cells for metric in metrics_of(cell.course) for row in _rows(cell, metric)
    ]
    own = [cell for cell in cells if cell.controller == OWN]
    for metric in metrics_of(own[0].course) if own else ():
        if metric.key in KEPT:
            worst = max(cell.figures[metric.key].mean for cell in own)
            rows.append(at_most(f"{OWN}, all of it: {metric.meaning}", worst, metric.unit, 0.0))
    return rows


def _rows(cell: Cell, metric: Metric) -> list[Row]:
    figure = cell.figures[metric.key]
    name = (
        f"{cell.course.name}, {cell.degrees_of_freedom} DoF, {STANDS[cell.plant]}, "
        f"{cell.controller}: {metric.meaning}"
    )
    rows = [_barred(cell, metric, name, figure.mean)]
    if figure.count > 1:
        spread = f"{name}, half of the 95 % confidence interval of {figure.count}"
        rows.append(Row(spread, figure.half_width, metric.unit))
    return rows


def _barred(cell: Cell, metric: Metric, name: str, value: float) -> Row:
    """With the bar that this project's controller is held to, if there is one."""
    if cell.controller == OWN:
        if metric.key == "t98_s" and cell.plant == "ideal":
            share = value / cell.course.trajectory_time_s
            return within(f"{name}, over T", share, "", 0.98 * 0.88, 1.02 * 0.88)
        bar = _bars(cell).get(metric.key)
        if bar is not None:
            return at_most(name, value, metric.unit, bar)
    return Row(name, value, metric.unit)


def _bars(cell: Cell) -> Mapping[str, float]:
    """Upper bars by metric, beside those on limits."""
    if not cell.course.moves:
        lag_mm = LAG_SHARE * cell.course.trajectory_time_s * _speed_m_s(cell.course) * 1e3
        return {"tracking_mm": lag_mm} if cell.plant == "ideal" else {}
    if cell.plant == "boards":
        return {"error_mm": 2.0, "error_deg": 1.0}
    exact = {"error_mm": 0.2, "error_deg": 0.05, "perpendicular": 3.0}
    if cell.plant == "ideal":
        return {**exact, "deviation": 3.0, "profile": 0.5, "jerk": 1.1}
    return {**exact, "jerk": 2.0}


def _speed_m_s(course: Course) -> float:
    """Of a curve."""
    return float(np.linalg.norm(course.velocity_m_s, axis=1).mean())
