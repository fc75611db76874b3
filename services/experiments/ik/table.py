"""The table of solvers: how often each is right, and how long it takes."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass

import numpy as np
from rich.table import Table

from services.experiments.ik.measure import LOOSE_RAD, Run, percent
from services.experiments.ik.poses import COLD, NEAR, ORIENTATION, POSITION, Sample, at


@dataclass(frozen=True)
class Line:
    """One solver. Reached / reached with the best objective in %; times median / p99 in ms."""

    solver: str
    cold: str
    cold_ms: str
    near: str
    near_ms: str
    orientation: str  # position kept %, excess angle median / p90 in degrees
    orientation_ms: str
    position: str  # excess distance median / p90 in mm, limits kept %
    position_ms: str


# Measured before, with the same sizes of sets, on a machine about twice as fast as a shared one;
# CasADi's virtual machine for IPOPT and fatrop. 200 poses of each set for mink and SciPy.
PUBLISHED = (
    Line(
        "IPOPT, eq.11",
        *("100/99.8", "3.47/8.6", "100/99.8", "3.49/9.3"),
        *("100 -0.24/1.22", "3.5/8.2", "0.0/0.0 100", "12.4/21.9"),
    ),
    Line(
        "fatrop, x = 0",
        *("100/99.8", "0.98/1.7", "100/99.8", "0.90/1.6"),
        *("100 0.01/1.27", "0.66/1.3", "12.3/34.4 100", "10.8/11.5"),
    ),
    Line(
        "TRAC-IK (wall)",
        *("86.2/47.8", "0.19/3.9", "95.6/7.2", "0.07/0.7"),
        *("0", "5.1/9.0", "115/176", "5.2/8.1"),
    ),
    Line(
        "KDL NR_JL",
        *("86.4/50.6", "0.08/1.2", "96/7.4", "0.05/0.7"),
        *("0", "1.2/1.3", "167/498 20", "1.2/1.3"),
    ),
    Line(
        "pink + daqp",
        *("87.8/42.4", "0.30/3.3", "87.6/42.8", "0.24/3.2"),
        *("0", "3.2/3.5", "24/109 28", "3.2/3.3"),
    ),
    Line(
        "mink + daqp",
        *("85.5/35.5", "0.24/2.7", "85.5/38.5", "0.19/2.8"),
        *("0", "2.8/3.0", "173/507 30", "2.8/3.1"),
    ),
    Line(
        "SciPy SLSQP, x = 0",
        *("97.5/96", "2.9/19", "100/99", "2.7/5.0"),
        *("100 0.01/1.56", "1.5/5.7", "8.6/27 98", "20/57"),
    ),
)


def lines(samples: Mapping[str, Sample]) -> list[Line]:
    """What was measured now; a set that was not is blank."""
    names = next(iter(samples.values())).runs
    found = []
    for name in names:
        cells = []
        for which, shown in (
            (COLD, _reached),
            (NEAR, _reached),
            (ORIENTATION, _beside),
            (POSITION, _away),
        ):
            sample = samples.get(which)
            known = sample is not None and name in sample.runs
            cells.append(shown(sample, name) if sample is not None and known else "")
            cells.append(times(sample.runs[name]) if sample is not None and known else "")
        found.append(Line(name, *cells))
    return found


def times(run: Run) -> str:
    """Median / p99."""
    return f"{run.ms_at(50):.3g}/{run.ms_at(99):.3g}"


def _reached(sample: Sample, name: str) -> str:
    w = sample.worths[name]
    reached = w.loosely_feasible()
    return f"{percent(reached):.1f}/{percent(reached & w.optimal(sample.targets.best)):.1f}"


def _beside(sample: Sample, name: str) -> str:
    kept = sample.worths[name].loosely_feasible()
    if not kept.any():
        return "0"
    excess = np.degrees(np.where(kept, sample.excess(name), np.inf))
    return f"{percent(kept):.0f} {at(excess, 50):.2f}/{at(excess, 90):.2f}"


def _away(sample: Sample, name: str) -> str:
    excess = 1e3 * sample.excess(name)
    if not np.isfinite(excess).any():
        return "no answer"
    kept = percent(sample.worths[name].outside_rad <= LOOSE_RAD)
    return f"{at(excess, 50):.2f}/{at(excess, 90):.2f} {kept:.0f}"


def tables(title: str, shown: Sequence[Line], *, published: bool = False) -> list[Table]:
    """As text, reachable poses and the others; with the published figures below where wanted."""
    reachable = Table(
        "solver",
        *("cold: reached/best %", "ms med/p99"),
        *("near: reached/best %", "ms med/p99"),
        title=f"{title}: poses in reach",
        title_justify="left",
    )
    others = Table(
        "solver",
        *("orientation: kept %, excess deg med/p90", "ms med/p99"),
        *("position: excess mm med/p90, limits %", "ms med/p99"),
        title=f"{title}: orientation or position out of reach",
        title_justify="left",
    )
    groups = [(shown, "")] + ([(PUBLISHED, "dim")] if published else [])
    for made, first in ((reachable, 1), (others, 5)):
        for group, style in groups:
            made.add_section()
            if group is PUBLISHED:
                made.add_row("published before:", style=style)
            for line in group:
                cells = list(astuple(line))
                made.add_row(cells[0], *cells[first : first + 4], style=style)
    return [reachable, others]
