"""The main job live: CAN over Zenoh, and over SocketCAN where there is any, or a guest kernel.

    python -m benchmarks.live [--json FILE] [--can zenoh|socketcan|all] [--seeds N]

Every latency stands beside that of an idle 1 kHz process of the same priority at the same time.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from hal.buses.socketcan import interfaces_up
from services.config import load_robot
from services.experiments.rows import Row, at_most, publish

ROOT = Path(__file__).resolve().parent.parent
GUEST = ROOT.parent / "shared" / "tools" / "run-with-vcan"
POSITION_BAR_MM = 5.0
GUEST_TIMEOUT_S = 900


def main() -> int:
    """Measure what was asked for; what is not here is named."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--can", choices=("zenoh", "socketcan", "all"), default="all")
    parser.add_argument("--seeds", type=int, default=1)
    arguments = parser.parse_args()
    rows: list[Row] = []
    for can in ("zenoh", "socketcan") if arguments.can == "all" else (arguments.can,):
        rows += measure(can, arguments.seeds)
    return publish("reach, live", rows, arguments.json)


def measure(can: str, seeds: int) -> list[Row]:
    """All runs over one transport."""
    if can == "socketcan" and not interfaces_up(interfaces()):
        return in_guest(seeds)
    ways: tuple[tuple[str, ...], ...] = ((),)
    if can == "socketcan":
        ways = (("--one-process",), ())
    return [row for way in ways for seed in range(seeds) for row in one_run(can, seed, way)]


def interfaces() -> tuple[str, ...]:
    """SocketCAN interfaces of the robot's buses."""
    return tuple(bus.channel for bus in load_robot("icub:reach").buses.values())


def in_guest(seeds: int) -> list[Row]:
    """The SocketCAN runs inside a guest kernel that has vcan, with one CPU."""
    if not GUEST.exists():
        why = f"not run: {', '.join(interfaces())} are not up, and no guest kernel is here"
        return [Row("socketcan: reached", why)]
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "rows.json"
        command = [str(GUEST), "-t", str(GUEST_TIMEOUT_S), "--", sys.executable]
        command += ["-m", "benchmarks.live", "--can", "socketcan"]
        command += ["--seeds", str(seeds), "--json", str(result)]
        subprocess.run(command, cwd=ROOT, check=False)
        if not result.exists():
            return [Row("socketcan: reached", "no result from the guest kernel", "", "1", False)]
        return [Row(**row) for row in json.loads(result.read_text(encoding="utf-8"))["rows"]]


def one_run(can: str, seed: int, options: tuple[str, ...]) -> list[Row]:
    """One `ulna demo reach`, with an empty loop beside it."""
    name = f"{can}{', one process' if options else ''}, seed {seed}"
    print(f"live over {name} ...", file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory() as folder:
        report_file = Path(folder) / "report.json"
        empty = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.empty_loop"], cwd=ROOT, stdout=subprocess.PIPE
        )
        try:
            command = [sys.executable, "-m", "services.cli.main", "demo", "reach"]
            command += ["--can", can, *options, "--seed", str(seed), "--json", str(report_file)]
            command += ["--plot", str(Path(folder) / "reach.png")]
            status = subprocess.run(command, cwd=ROOT, check=False, stdout=sys.stderr).returncode
        finally:
            empty.terminate()
            empty_loop = json.loads(empty.communicate()[0])
        report = json.loads(report_file.read_text(encoding="utf-8"))
    return rows_of(name, status, report, empty_loop)


def rows_of(
    name: str, status: int, report: dict[str, object], empty: dict[str, object]
) -> list[Row]:
    """Figures of one run."""
    wall = report["wall"]
    assert isinstance(wall, dict)
    error = report["position_error_mm"]
    position_mm = float(error) if isinstance(error, float) else float("inf")
    left = processes_left()
    return [
        Row(f"{name}: reached", str(report["reached"]), "", "True", bool(report["reached"])),
        Row(f"{name}: exit status", float(status), "", "0", status == 0),
        at_most(f"{name}: position error", position_mm, "mm", POSITION_BAR_MM),
        at_most(f"{name}: frames lost", _count(report["frames_lost"]), "", 0),
        at_most(f"{name}: board faults", _count(report["board_faults"]), "", 0),
        at_most(f"{name}: processes left", len(left), "", 0),
        Row(f"{name}: clearance", _number(report["min_clearance_mm"]), "mm"),
        Row(f"{name}: tick slips", _count(report["tick_slips"])),
        Row(f"{name}: torque loop, median", _number(wall["torque_loop_ms_p50"]), "ms"),
        Row(f"{name}: torque loop, p99", _number(wall["torque_loop_ms_p99"]), "ms"),
        Row(f"{name}: tick lateness, median", _number(wall["tick_late_us_p50"]), "us"),
        Row(f"{name}: tick lateness, p99", _number(wall["tick_late_us_p99"]), "us"),
        Row(f"{name}: empty loop's lateness, median", _number(empty["p50_us"]), "us"),
        Row(f"{name}: empty loop's lateness, p99", _number(empty["p99_us"]), "us"),
        Row(f"{name}: IK, median", _number(wall["ik_ms_p50"]), "ms"),
        Row(f"{name}: IK, p99", _number(wall["ik_ms_p99"]), "ms"),
        Row(f"{name}: schedulers", str(wall["schedulers"])),
    ]


def processes_left() -> list[int]:
    """Processes of a stack that still run: python -m services.<name>."""
    left = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            try:
                command = (entry / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue  # it has ended meanwhile
            if b"--hub" in command and any(w.startswith(b"services.") for w in command):
                left.append(int(entry.name))
    return left


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _count(value: object) -> float:
    return float(value) if isinstance(value, int | float) else float("inf")


if __name__ == "__main__":
    raise SystemExit(main())
