"""Every figure of the main job: ten seeds, repeatability, speed, the push, the inner loop.

    python -m benchmarks.reach [--json FILE] [--seeds N] [--short]

Virtual time throughout; the live runs are in benchmarks/live.py, the set-up in benchmarks/setup.py.
"""

import argparse
import json
import sys
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from statistics import median

import msgspec
import numpy as np

from benchmarks.push import push_rows
from dforc.cartesian.outer_correction import CorrectionParams
from dforc.cartesian.params import CartesianParams
from services.cartesian import Cartesian
from services.cli.demo import COMPLIANT_BAR_M, STIFF_BAR_M
from services.config import load_robot
from services.core.service import Inputs, Outputs, Service
from services.core.stream import AnyCall, AnyStream
from services.dynamics import Dynamics
from services.experiments.rows import Row, at_least, at_most, publish
from services.messages import ImpedanceOffset, TorqueEstimate
from services.reaching.reach import ReachOptions
from services.reaching.reach_record import Report
from services.reaching.reach_virtual import Outcome, run_virtual
from services.robotfile.robot_tables import RobotFile

ORIENTATION_BAR_DEG = 1.5
CLEARANCE_BAR_MM = 5.0
SPEED_BAR = 4.0
INNER_LOOP_BAR_US = 80.0
LATE_NS = 10_000_000
HOLD_S = 5.0  # a compliant arm slips its last tick into place in 4 s
REST_S = 0.5  # the last stretch of the hold, in which no joint may move
REST_BAR_DEG_S = 1.0
NO_BAR_M = 1.0  # for runs whose error is the result, not a condition


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--short", action="store_true", help="one seed per row")
    arguments = parser.parse_args()
    robot = load_robot("icub:reach")
    seeds = range(1 if arguments.short else arguments.seeds)
    rows: list[Row] = []
    rows += seed_rows(robot, "compliant", seeds, stiff=False)
    rows += seed_rows(robot, "stiff", seeds, stiff=True)
    rows += repeat_rows(robot)
    rows += slow_hop_rows(robot, range(min(3, len(seeds))))
    rows += late_rows(robot, range(min(3, len(seeds))))
    rows += push_rows(robot, range(min(3, len(seeds))))
    rows += ablation_rows(robot, range(min(5, len(seeds))))
    return publish("reach, virtual time", rows, arguments.json)


def run(
    robot: RobotFile,
    options: ReachOptions,
    what: str,
    hop_ticks: int = 1,
    replaced: Mapping[str, Service] | None = None,
) -> Outcome:
    """One run, announced."""
    print(f"{what}, seed {options.seed} ...", file=sys.stderr, flush=True)
    return run_virtual(robot, options, hop_ticks, replaced=replaced)


def seed_rows(robot: RobotFile, name: str, seeds: Iterable[int], *, stiff: bool) -> list[Row]:
    """All seeds of one mode."""
    bar_m = STIFF_BAR_M if stiff else COMPLIANT_BAR_M
    outcomes = [
        run(robot, ReachOptions(seed=seed, stiff=stiff, position_bar_m=bar_m, hold_s=HOLD_S), name)
        for seed in seeds
    ]
    reports = [outcome.report for outcome in outcomes]
    rows = bars(name, reports, bar_m)
    rest = [rest_speed_deg_s(outcome) for outcome in outcomes]
    rows.append(
        at_most(
            f"{name}: arm joint speed at the end of the hold, largest",
            max(rest),
            "deg/s",
            REST_BAR_DEG_S,
        )
    )
    return rows


def bars(name: str, reports: list[Report], position_bar_m: float) -> list[Row]:
    """The functional bars over several runs."""
    total = len(reports)
    reached = sum(bool(report["reached"]) for report in reports)
    speeds = [_wall(report, "realtime_factor") for report in reports]
    return [
        at_least(f"{name}: reached", reached, f"of {total}", total),
        at_most(
            f"{name}: position error, largest",
            max(_values(reports, "position_error_mm")),
            "mm",
            position_bar_m * 1e3,
        ),
        Row(f"{name}: position error, median", median(_values(reports, "position_error_mm")), "mm"),
        at_most(
            f"{name}: orientation error, largest",
            max(_values(reports, "orientation_error_deg")),
            "deg",
            ORIENTATION_BAR_DEG,
        ),
        at_least(
            f"{name}: clearance, smallest",
            min(_values(reports, "min_clearance_mm")),
            "mm",
            CLEARANCE_BAR_MM,
        ),
        Row(
            f"{name}: whole arm's clearance, smallest",
            min(_values(reports, "min_arm_clearance_mm")),
            "mm",
        ),
        Row(f"{name}: time to target, largest", max(_values(reports, "time_to_target_s")), "s"),
        *(
            at_most(f"{name}: {key}", sum(_values(reports, key)), "", 0)
            for key in ("limit_violations", "board_faults", "frames_lost")
        ),
        at_most(
            f"{name}: joints never held to their limits",
            max(len(_names(report, "joints_not_held_to_limits")) for report in reports),
            "",
            0,
        ),
        at_least(f"{name}: realtime_factor, median", median(speeds), "x", SPEED_BAR),
        at_most(
            f"{name}: inner loop (boards, plant, sensor, memory bus), median",
            median(_wall(r, "boards_us_p50") for r in reports),
            "us per ms",
            INNER_LOOP_BAR_US,
        ),
        Row(f"{name}: HAL step, median", median(_wall(r, "robot_us_p50") for r in reports), "us"),
        Row(
            f"{name}: torque estimate step, median",
            median(_wall(r, "dynamics_us_p50") for r in reports),
            "us",
        ),
        Row(f"{name}: IK step, median", median(_wall(r, "ik_ms_p50") for r in reports), "ms"),
        Row(f"{name}: IK step, p99", max(_wall(r, "ik_ms_p99") for r in reports), "ms"),
    ]


def repeat_rows(robot: RobotFile) -> list[Row]:
    """One seed twice: the same bytes but for the wall times."""
    texts = []
    for _ in range(2):
        report = dict(run(robot, ReachOptions(seed=0), "repeat").report)
        del report["wall"]
        texts.append(json.dumps(report))
    same = texts[0] == texts[1]
    return [Row("same seed twice: identical report", str(same), "", "True", same)]


def slow_hop_rows(robot: RobotFile, seeds: Iterable[int]) -> list[Row]:
    """Twice the delay between processes."""
    reports = [run(robot, ReachOptions(seed=seed), "2 ms a hop", 2).report for seed in seeds]
    reached = sum(bool(report["reached"]) for report in reports)
    return [
        at_least("2 ms a hop: reached", reached, f"of {len(reports)}", len(reports)),
        at_most(
            "2 ms a hop: position error, largest",
            max(_values(reports, "position_error_mm")),
            "mm",
            COMPLIANT_BAR_M * 1e3,
        ),
    ]


def ablation_rows(robot: RobotFile, seeds: Iterable[int]) -> list[Row]:
    """What the compliant arm loses without its outer loop, and without gravity compensation."""
    still = CartesianParams(
        trajectory_time_s=robot.reach.trajectory_time_s,
        correction=CorrectionParams(gain_per_s=0.0),
    )
    cases: tuple[tuple[str, float, float, Callable[[], dict[str, Service]]], ...] = (
        (
            "outer loop off: error shows the friction limit",
            1.0,
            5.0,
            lambda: {"cartesian": Cartesian(robot, still)},
        ),
        (
            "gravity offset off as well: error proves the offset",
            25.0,
            50.0,
            lambda: {"cartesian": Cartesian(robot, still), "dynamics": Weightless(robot)},
        ),
    )
    rows = []
    for name, low, high, replaced in cases:
        errors = []
        for seed in seeds:
            options = ReachOptions(
                seed=seed, position_bar_m=NO_BAR_M, orientation_bar_rad=np.pi, hold_s=8.0
            )
            outcome = run(robot, options, name, replaced=replaced())
            errors.append(float(_values([outcome.report], "position_error_mm")[0]))
        value = median(errors)
        bar = f"{low:g} .. {high:g}"
        rows.append(Row(f"{name}, median", value, "mm", bar, low <= value <= high))
    return rows


def late_rows(robot: RobotFile, seeds: Iterable[int]) -> list[Row]:
    """Torques at 100 Hz and 10 ms late."""
    reports = [
        run(
            robot,
            ReachOptions(seed=seed, hold_s=HOLD_S),
            "late torques",
            replaced={"dynamics": Late(robot)},
        ).report
        for seed in seeds
    ]
    reached = sum(bool(report["reached"]) for report in reports)
    return [
        at_least(
            "torques 10 ms apart, 10 ms late: reached", reached, f"of {len(reports)}", len(reports)
        ),
        at_most(
            "torques 10 ms apart, 10 ms late: position error, largest",
            max(_values(reports, "position_error_mm")),
            "mm",
            COMPLIANT_BAR_M * 1e3,
        ),
    ]


class Tampered(Dynamics):
    """Dynamics whose messages pass through `send` before they leave; also their Carrier."""

    def __init__(self, robot: RobotFile) -> None:
        super().__init__(robot)
        self.outputs: Outputs
        self._own = Outputs("dynamics", self, self.writes, self.serves)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """As ever."""
        self.outputs = outputs
        super().step(now_ns, inputs, self._own)

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Carrier: publish."""
        self.outputs.put(stream, message)

    def send_reply(self, call: AnyCall, token: int, reply: msgspec.Struct) -> None:
        """Carrier: answer."""
        self.outputs.reply(call, token, reply)

    def send_request(self, call: AnyCall, token: int, request: msgspec.Struct) -> None:
        """Carrier: dynamics asks nobody."""


class Late(Tampered):
    """Dynamics whose torques come every 10 ms only, and 10 ms after they were estimated."""

    def __init__(self, robot: RobotFile) -> None:
        super().__init__(robot)
        self._waiting: deque[tuple[AnyStream, TorqueEstimate]] = deque()
        self._due_ns = 0

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Every 10 ms let out the newest torques that are 10 ms old."""
        super().step(now_ns, inputs, outputs)
        if now_ns < self._due_ns:
            return
        self._due_ns = now_ns + LATE_NS
        late: dict[AnyStream, TorqueEstimate] = {}
        while self._waiting and self._waiting[0][1].stamp_ns <= now_ns - LATE_NS:
            stream, estimate = self._waiting.popleft()
            late[stream] = estimate
        for stream, estimate in late.items():
            outputs.put(stream, msgspec.structs.replace(estimate, stamp_ns=now_ns))

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Keep torques back."""
        if isinstance(message, TorqueEstimate):
            self._waiting.append((stream, message))
        else:
            super().send(stream, message)


class Weightless(Tampered):
    """Dynamics that forgets gravity in the boards' impedance offset."""

    def send(self, stream: AnyStream, message: msgspec.Struct) -> None:
        """Take the gravity out."""
        if isinstance(message, ImpedanceOffset):
            nothing = (0.0,) * len(message.tau_nm)
            message = msgspec.structs.replace(message, tau_nm=nothing)
        super().send(stream, message)


def rest_speed_deg_s(outcome: Outcome) -> float:
    """Fastest arm joint of the last half second of the hold: a limit cycle would show."""
    trace = outcome.recording.trace
    since = trace.time_s[-1] - REST_S
    first = int(np.searchsorted(trace.time_s, since))
    arm = [i for i, joint in enumerate(outcome.recording.joints) if not joint.startswith("torso")]
    return float(np.degrees(np.abs(np.array(trace.dq_rad_s[first:])[:, arm]).max()))


def _names(report: Report, key: str) -> list[object]:
    value = report[key]
    assert isinstance(value, list)
    return value


def _values(reports: list[Report], key: str) -> list[float]:
    """One figure of every run; a run without it counts as infinitely bad."""
    values = [report[key] for report in reports]
    return [float(v) if isinstance(v, int | float) else float("inf") for v in values]


def _wall(report: Report, key: str) -> float:
    wall = report["wall"]
    assert isinstance(wall, dict)
    return float(wall[key])


if __name__ == "__main__":
    raise SystemExit(main())
