"""Every figure of the whole-body dynamics: exactness, speed, signals, contacts, faults.

    python -m benchmarks.dynamics [--only exactness,speed,...] [--data icubdyn.tgz] [--json FILE]
                                  [--short]

The whole run takes some minutes, most of them for a million ticks with faults; --short takes fewer
of everything.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from services.experiments.rows import Row, publish

Part = Callable[[Path | None, bool], list[Row]]


def exactness(_data: Path | None, short: bool) -> list[Row]:
    """Against Newton and Euler by the book, and against idyntree."""
    from benchmarks.dynamics_exactness import rows

    return rows(2 if short else 12)


def speed(_data: Path | None, short: bool) -> list[Row]:
    """One whole estimate from Python, beside idyntree's."""
    from benchmarks.dynamics_speed import ROUNDS, rows

    return rows(50 if short else ROUNDS)


def service(_data: Path | None, _short: bool) -> list[Row]:
    """The tick of the dynamics service, beside the empty loop's."""
    from benchmarks.dynamics_service import rows

    return rows()


def contacts(data: Path | None, _short: bool) -> list[Row]:
    """Detection and location of contacts."""
    from benchmarks.dynamics_contacts import rows

    return rows(data)


def signals(_data: Path | None, short: bool) -> list[Row]:
    """Derivatives, filters, calibration and sensor faults."""
    from benchmarks.dynamics_signals import rows

    return rows(short)


def recording(data: Path | None, _short: bool) -> list[Row]:
    """CAD and a constant offset on a real right arm; a model of another robot is found out."""
    from services.experiments.forces.recorded_arm import recorded_rows

    return recorded_rows(data)


def endurance(_data: Path | None, short: bool) -> list[Row]:
    """Random ticks with faults in one limb."""
    from benchmarks.dynamics_endurance import rows

    return rows(short=short, say=_say)


PARTS: dict[str, Part] = {
    "exactness": exactness,
    "speed": speed,
    "service": service,
    "contacts": contacts,
    "signals": signals,
    "recording": recording,
    "endurance": endurance,
}


def main() -> int:
    """Measure what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--data", type=Path, default=None, help="the recording icubdyn.tgz")
    parser.add_argument("--short", action="store_true", help="fewer of everything")
    parser.add_argument("--only", default=",".join(PARTS), help="some of the parts")
    given = parser.parse_args()
    names = [name for name in given.only.split(",") if name]
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        raise SystemExit(f"--only: unknown {', '.join(unknown)}; known: {', '.join(PARTS)}")
    rows: list[Row] = []
    for name in names:
        _say(f"{name} ...")
        rows += PARTS[name](given.data, given.short)
    return publish("whole-body dynamics", rows, given.json)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
