"""What experiments and benchmarks print and write: name, value, unit, bar, whether it holds."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table


@dataclass(frozen=True)
class Row:
    """One figure. `bar` says in words what it is held against; `holds` is None where nothing is."""

    name: str
    value: float | str | None
    unit: str = ""
    bar: str = ""
    holds: bool | None = None


def at_most(name: str, value: float, unit: str, bar: float) -> Row:
    """A figure with an upper bar."""
    return Row(name, value, unit, f"<= {bar:g}", value <= bar)


def at_least(name: str, value: float, unit: str, bar: float) -> Row:
    """A figure with a lower bar."""
    return Row(name, value, unit, f">= {bar:g}", value >= bar)


def within(name: str, value: float, unit: str, low: float, high: float) -> Row:
    """A figure between two bars."""
    return Row(name, value, unit, f"{low:g} .. {high:g}", low <= value <= high)


def publish(title: str, rows: list[Row], json_file: Path | None) -> int:
    """Print the table, write the file, and return the exit status: 0 when every bar holds."""
    table = Table("what", "value", "unit", "bar", "holds", title=title, title_justify="left")
    for row in rows:
        holds = "" if row.holds is None else "yes" if row.holds else "NO"
        table.add_row(row.name, _shown(row.value), row.unit, row.bar, holds)
    Console().print(table)
    if json_file is not None:
        write(rows, json_file)
    return 0 if all(row.holds is not False for row in rows) else 1


def write(rows: list[Row], json_file: Path) -> None:
    """Write the rows as JSON."""
    text = json.dumps({"rows": [_plain(row) for row in rows]}, indent=2)
    json_file.write_text(text + "\n", encoding="utf-8")


def _shown(value: float | str | None) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _plain(row: Row) -> dict[str, object]:
    """The row as JSON has it: no infinity, no NaN."""
    plain = asdict(row)
    if isinstance(row.value, float) and not math.isfinite(row.value):
        plain["value"] = None
    return plain
