"""The whole-arm scenes as one table: a line for each kind of scene and law."""

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from services.experiments.whole_arm.rows import EMPTY, NOTED, Found, in_order, percent
from services.experiments.whole_arm.run import Outcome

COLUMNS = (
    "scenes",
    "law",
    "reached, no contact %",
    "notes %",
    "and 3 deg %",
    "touched obstacle %",
    "notes %",
    "itself %",
    "limits left %",
    "nearest mm",
    "time s",
    "path m",
)


def arm_table(found: Found, seed: int) -> Table:
    """Percent of the scenes; `notes`: the figure of the literature notes."""
    table = Table(*COLUMNS, title=f"whole arm, seed {seed}", title_justify="left")
    before = ""
    for (kind, law), outcomes in in_order(found):
        if law == EMPTY:
            continue
        if before not in ("", kind):
            table.add_section()
        first = f"{kind}, {len(outcomes)}" if kind != before else ""
        table.add_row(first, law, *_figures(kind, law, outcomes))
        before = kind
    return table


def _figures(kind: str, law: str, outcomes: Sequence[Outcome]) -> list[str]:
    reached, touched = (str(n) for n in NOTED.get((kind, law), ("", "")))
    nearest = min(min(o.verdict.obstacle.distance_m, o.verdict.itself.distance_m) for o in outcomes)
    times = [o.reached_s for o in outcomes if o.reached_s is not None]
    paths = [o.path_m for o in outcomes if o.reached]
    return [
        f"{percent(outcomes, lambda o: o.reached and o.is_clean):.0f}",
        reached,
        f"{percent(outcomes, lambda o: o.turned and o.is_clean):.0f}",
        f"{percent(outcomes, lambda o: o.verdict.obstacle.distance_m <= 0.0):.0f}",
        touched,
        f"{percent(outcomes, lambda o: o.verdict.itself.distance_m <= 0.0):.0f}",
        f"{percent(outcomes, lambda o: not o.keeps_limits):.0f}",
        f"{1e3 * nearest:.1f}",
        f"{np.median(times):.1f}" if times else "-",
        f"{np.median(paths):.2f}" if paths else "-",
    ]
