"""Signals for the whole-body dynamics: derivatives, delay matching, calibration, sensor faults.

python -m benchmarks.dynamics_signals [--short] [--json FILE]
"""

import argparse
from pathlib import Path

from benchmarks.derivative_rows import (
    cost_rows,
    jump_rows,
    move_rows,
    rest_rows,
    sine_rows,
    uneven_rows,
)
from benchmarks.ft_rows import gain_rows, offset_rows, phantom_rows
from benchmarks.sensor_fault_rows import fault_rows
from services.experiments.rows import Row, publish


def rows(short: bool) -> list[Row]:
    """All figures; `short` takes fewer frequencies, runs and faults."""
    return [
        *sine_rows(short),
        *move_rows(),
        *uneven_rows(),
        *rest_rows(short),
        *jump_rows(),
        *cost_rows(short),
        *phantom_rows(),
        *offset_rows(short),
        *gain_rows(short),
        *fault_rows(short),
    ]


def main() -> int:
    """Print and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--short", action="store_true", help="1 Hz only, fewer runs and faults")
    arguments = parser.parse_args()
    return publish("signals", rows(arguments.short), arguments.json)


if __name__ == "__main__":
    raise SystemExit(main())
