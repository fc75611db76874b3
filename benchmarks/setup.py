"""How long a fresh checkout takes: clone, `./ulna demo reach --virtual`, `./check`.

    python -m benchmarks.setup [--json FILE] [--skip-check]

The clone has no .venv; pip's cache is off, so that everything is really fetched.
"""

import argparse
import os
import re
import subprocess
import tempfile
from pathlib import Path

from services.core.clock import wall_ns
from services.experiments.rows import Row, at_most, publish

ROOT = Path(__file__).resolve().parent.parent
DEMO_BAR_S = 180.0
CHECK_BAR_S = 600.0
SET_UP = re.compile(r"set up in (\d+) s: (\d+) MB downloaded in (\d+) s")


def main() -> int:
    """Clone and run both commands."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--skip-check", action="store_true")
    arguments = parser.parse_args()
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "ulna"
        subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
        rows += timed(clone, ["./ulna", "demo", "reach", "--virtual"], DEMO_BAR_S)
        rows += timed(clone, ["./ulna", "--version"], 2.0)
        if not arguments.skip_check:
            rows += timed(clone, ["./check"], CHECK_BAR_S)
    return publish("set-up of a fresh checkout", rows, arguments.json)


def timed(clone: Path, command: list[str], bar_s: float) -> list[Row]:
    """Run one command; what it downloaded is in its own words."""
    name = " ".join(command)
    environment = {**os.environ, "PIP_NO_CACHE_DIR": "1"}
    environment.pop("PYTHONPATH", None)
    start_ns = wall_ns()
    done = subprocess.run(
        command, cwd=clone, env=environment, check=False, capture_output=True, text=True
    )
    seconds = (wall_ns() - start_ns) * 1e-9
    print(done.stdout[-2000:], done.stderr[-2000:])
    rows = [
        Row(f"{name}: exit status", float(done.returncode), "", "0", done.returncode == 0),
        at_most(f"{name}: from nothing", seconds, "s", bar_s),
    ]
    found = SET_UP.search(done.stdout + done.stderr)
    if found:
        rows.append(Row(f"{name}: downloaded", float(found[2]), "MB"))
        rows.append(Row(f"{name}: download", float(found[3]), "s"))
    return rows


if __name__ == "__main__":
    raise SystemExit(main())
