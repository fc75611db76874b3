"""ulna demo: the main job, with progress, a table of what happened, a plot and a report."""

import json
from pathlib import Path
from typing import Annotated, Literal

import cyclopts
import numpy as np
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from services.config import load_robot
from services.core.errors import ConfigError
from services.messages import Vector3
from services.processes import DEFAULT_ROBOT
from services.reaching.reach import ReachOptions
from services.reaching.reach_live import run_live
from services.reaching.reach_one_process import run_one_process
from services.reaching.reach_record import Report
from services.reaching.reach_virtual import Outcome, run_virtual
from services.robotfile.robot_tables import RobotFile

STIFF_BAR_M = 0.0015
COMPLIANT_BAR_M = 0.003
LIVE_BAR_M = 0.005
SUCCESS, FAILURE = 0, 1
MAX_HOP_MS = 20
MOST_NAMES = 4  # of a list in the table


def reach(
    *,
    virtual: bool = False,
    stiff: bool = False,
    seed: int = 0,
    can: str = "",
    one_process: bool = False,
    target: Annotated[str, cyclopts.Parameter(allow_leading_hyphen=True)] = "",
    obstacle: Annotated[str, cyclopts.Parameter(allow_leading_hyphen=True)] = "",
    hop_ms: int = 1,
    field: Literal["", "ulna", "dforc"] = "",
    robot: str = DEFAULT_ROBOT,
    json_file: Annotated[Path, cyclopts.Parameter(name="--json")] = Path("reach.json"),
    plot: Path = Path("reach.png"),
) -> int:
    """Reach a target around a ball with the right hand, through every layer of the stack.

    Without options: live, one process per service, on emulated boards; vcan where it is up, else
    CAN over Zenoh.

    Example: ulna demo reach --virtual --seed 3 --json reach.json

    Args:
        virtual: one process, virtual time, memory bus: deterministic and faster than real time.
        stiff: keep the arm stiff instead of compliant.
        seed: draws plant masses and levers, sensor noise and offset, target and ball.
        can: zenoh or socketcan; live only. Default: what is there.
        one_process: live on SocketCAN, all services in one process: for one slow core.
        target: X,Y,Z of the hand in metres, base frame (x backwards, y right, z up).
        obstacle: X,Y,Z,R of the ball in metres.
        hop_ms: virtual milliseconds that a hop between two processes takes.
        field: mode of the force field. ulna, the default: the whole arm keeps clear; dforc: the
            paper's, the hand alone.
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        json_file: write the report there, as one JSON object.
        plot: write the figure there.
    """
    console = Console()
    if virtual and can not in ("", "memory"):
        raise ConfigError(f"--virtual uses the memory bus; --can {can} is for live runs")
    if one_process and (virtual or can == "zenoh"):
        raise ConfigError("--one-process runs by the wall clock on --can socketcan")
    if not 1 <= hop_ms <= MAX_HOP_MS:
        raise ConfigError(f"--hop-ms: {hop_ms} is outside 1..{MAX_HOP_MS}")
    robot_file = load_robot(robot)
    _check_robot(robot_file, robot)
    for file in (json_file, plot):
        if not file.parent.is_dir():
            raise ConfigError(f"cannot write {file}: there is no folder {file.parent}")
    bar = LIVE_BAR_M if not virtual else STIFF_BAR_M if stiff else COMPLIANT_BAR_M
    options = ReachOptions(
        seed=seed,
        stiff=stiff,
        target_m=_target(target),
        ball=_ball(obstacle),
        position_bar_m=bar,
        field=field,
    )
    with _progress(console) as progress:
        task = progress.add_task("starting", total=None, time="")

        def show(seconds: float, what: str) -> None:
            progress.update(task, description=what, time=f"robot time {seconds:6.1f} s")

        if virtual:
            outcome = run_virtual(robot_file, options, hop_ms, show)
        elif one_process:
            outcome = run_one_process(robot_file, options, show)
        else:
            outcome = run_live(robot, options, can, show, progress.console.print)
    return conclude(console, outcome, json_file, plot)


def conclude(console: Console, outcome: Outcome, json_file: Path, plot: Path) -> int:
    """Print the table, write the files, and return the exit status."""
    from services.reaching.reach_plot import draw

    console.print(table(outcome.report))
    draw(outcome.recording, plot)
    console.print(f"plot:   {plot}")
    json_file.write_text(json.dumps(outcome.report, indent=2) + "\n", encoding="utf-8")
    console.print(f"report: {json_file}")
    console.print(verdict(outcome.report))
    return SUCCESS if succeeded(outcome.report) else FAILURE


def succeeded(report: Report) -> bool:
    """Reached, without fault, loss or contact."""
    kept_clear = ["min_clearance_mm"]
    if report["field_mode"] == "ulna":  # the papers' fields know of the hand only
        kept_clear.append("min_arm_clearance_mm")
    clearances = [report[name] for name in kept_clear]
    touched = any(isinstance(one, float) and one <= 0.0 for one in clearances)
    return bool(report["reached"]) and not (
        report["board_faults"] or report["frames_lost"] or touched
    )


def verdict(report: Report) -> str:
    """One sentence."""
    if succeeded(report):
        return "[green]reached[/green]"
    if report["failure"]:
        return f"[red]failed:[/red] {report['failure']}"
    if report["ik_status"] == "infeasible":
        away = report["ik_position_error_mm"]
        return f"[red]out of reach:[/red] the nearest feasible position is {away:.1f} mm away"
    if report["field_state"] == "unreachable":
        away = report["field_distance_mm"]
        return f"[red]out of reach:[/red] {report['field_reason']}; {away:.1f} mm are left"
    return "[red]not reached[/red] within the bars; see the table"


def table(report: Report) -> Table:
    """What happened, in a person's words."""
    rows = Table("what", "value", title="reach", title_justify="left")
    for name, key, unit in (
        ("hand to target, largest of the last second", "position_error_mm", "mm"),
        ("orientation error, the same", "orientation_error_deg", "deg"),
        ("smallest clearance of the hand", "min_clearance_mm", "mm"),
        ("smallest clearance of the whole arm", "min_arm_clearance_mm", "mm"),
        ("time to target", "time_to_target_s", "s"),
        ("ticks outside a joint limit", "limit_violations", ""),
        ("joints whose limits are not counted yet", "joints_not_held_to_limits", ""),
        ("board faults", "board_faults", ""),
        ("CAN frames", "frames_total", ""),
        ("CAN frames lost", "frames_lost", ""),
        ("tick slips", "tick_slips", ""),
    ):
        rows.add_row(name, _cell(report.get(key), unit))
    wall = report["wall"]
    assert isinstance(wall, dict)
    for name, first, second, unit in (
        ("IK, median / p99", "ik_ms_p50", "ik_ms_p99", "ms"),
        ("torque loop, median / p99", "torque_loop_ms_p50", "torque_loop_ms_p99", "ms"),
        ("tick lateness, median / p99", "tick_late_us_p50", "tick_late_us_p99", "us"),
    ):
        rows.add_row(name, f"{_cell(wall[first], '')} / {_cell(wall[second], unit)}")
    rows.add_row("speed", _cell(wall["realtime_factor"], "x real time"))
    return rows


def _cell(value: object, unit: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, list):
        listed = ", ".join(map(str, value[:MOST_NAMES])) or "none"
        value = (
            listed if len(value) <= MOST_NAMES else f"{listed} and {len(value) - MOST_NAMES} more"
        )
    text = f"{value:.2f}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".rstrip()


def _check_robot(robot: RobotFile, reference: str) -> None:
    """Refuse a robot that cannot do the job, before anything is started."""
    if not robot.can_reach:
        missing = ", ".join(part for part in robot.reach.parts if part not in robot.parts)
        raise ConfigError(f"--robot {reference}: reaching needs {missing}, too; icub:reach has it")
    real = [board for board in robot.boards if not robot.is_simulated(board)]
    if real:
        raise ConfigError(
            f"--robot {reference}: {real[0]} is no emulated board, and the demo judges itself by "
            "the emulated robot's true motion; ulna up runs on real boards"
        )


def _progress(console: Console) -> Progress:
    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TextColumn("{task.fields[time]}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
    )


def _target(text: str) -> Vector3 | None:
    if not text:
        return None
    x, y, z = _numbers("--target", text, "X,Y,Z")
    return x, y, z


def _ball(text: str) -> tuple[float, float, float, float] | None:
    if not text:
        return None
    x, y, z, radius = _numbers("--obstacle", text, "X,Y,Z,R")
    if radius <= 0.0:
        raise ConfigError(f"--obstacle: the radius must be positive, not {radius}")
    return x, y, z, radius


def _numbers(option: str, text: str, shape: str) -> list[float]:
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != shape.count(",") + 1 or not np.isfinite(values).all():
        raise ConfigError(f"{option}: expected {shape} in metres, got {text!r}")
    return values
