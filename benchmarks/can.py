"""Every figure of the CAN side: codec, boards, whole robot, live buses, random frames, plugging.

    python -m benchmarks.can [--json FILE] [--short] [--only codec,tick,...]

The whole run takes some ten minutes; --short shortens the live, random-frame and plugging parts.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from benchmarks.can_codec import codec_rows
from benchmarks.can_fuzz import fuzz_rows
from benchmarks.can_hal import hal_rows
from benchmarks.can_live import live_rows
from benchmarks.can_plant import plant_rows
from benchmarks.can_plug import plug_rows
from benchmarks.can_services import services_rows
from benchmarks.can_tick import tick_rows
from services.experiments.rows import Row, publish

FUZZ_FRAMES, SHORT_FUZZ_FRAMES = 1_000_000, 50_000
LIVE_S, SHORT_LIVE_S = 60.0, 5.0


def main() -> int:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--short", action="store_true", help="seconds instead of minutes")
    parser.add_argument("--only", default="", help="some of the parts, comma-separated")
    arguments = parser.parse_args()
    parts = chosen(arguments.only, parts_of(short=arguments.short))
    rows: list[Row] = []
    for name, measure in parts.items():
        print(f"{name} ...", file=sys.stderr, flush=True)
        rows += measure()
    return publish("CAN, boards and HAL", rows, arguments.json)


def parts_of(*, short: bool) -> dict[str, Callable[[], list[Row]]]:
    """Every part by name, in the order in which it runs: the quiet ones before the long ones."""
    return {
        "codec": codec_rows,
        "tick": tick_rows,
        "hal": hal_rows,
        "robot": plant_rows,
        "services": services_rows,
        "live": lambda: live_rows(SHORT_LIVE_S if short else LIVE_S),
        "fuzz": lambda: fuzz_rows(SHORT_FUZZ_FRAMES if short else FUZZ_FRAMES),
        "plug": lambda: plug_rows(short=short),
    }


def chosen(
    only: str, parts: dict[str, Callable[[], list[Row]]]
) -> dict[str, Callable[[], list[Row]]]:
    """The parts that the command line names, all of them when it names none."""
    names = [name for name in only.split(",") if name]
    unknown = [name for name in names if name not in parts]
    if unknown:
        raise SystemExit(f"--only: unknown {', '.join(unknown)}; known: {', '.join(parts)}")
    return {name: parts[name] for name in names} if names else parts


if __name__ == "__main__":
    raise SystemExit(main())
