"""What `ulna ik` prints."""

import math

from rich import box
from rich.table import Table

from services.messages import ServiceStats
from services.reaching.limb import limb_limits
from services.reaching.messages import IkAnswer, IkReply, IkStatusReport
from services.robotfile.robot_tables import RobotFile

AT_LIMIT_DEG = 0.01


def answer_table(robot: RobotFile, limb: str, reply: IkReply, source: str) -> Table:
    """A row for each joint of the limb: the first answer, where it started, and its range."""
    title = f"{limb}: {source}"
    table = Table(title=title, box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("joint", no_wrap=True)
    for heading in ("deg", "from", "lower", "upper"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("remark")
    limits = limb_limits(robot, limb)
    for i, joint in enumerate(reply.joints):
        angles = (
            reply.answers[0].q_rad[i],
            reply.start_rad[i],
            float(limits.lower_rad[i]),
            float(limits.upper_rad[i]),
        )
        angle, start, lower, upper = (math.degrees(value) for value in angles)
        remark = "at its limit" if min(angle - lower, upper - angle) < AT_LIMIT_DEG else ""
        table.add_row(joint, *(f"{value:.2f}" for value in (angle, start, lower, upper)), remark)
    return table


def verdict(answer: IkAnswer, took_ms: float | None) -> str:
    """Status, errors and cost of an answer in a line, and the reason behind it."""
    text = (
        f"{answer.status}: position {answer.position_error_m * 1000:.2f} mm off, "
        f"orientation {math.degrees(answer.orientation_error_rad):.2f} deg off, "
        f"{answer.iterations} iterations"
    )
    if took_ms is not None:
        text += f", {took_ms:.2f} ms"
    return f"{text}\n{answer.reason}" if answer.reason else text


def status_table(report: IkStatusReport, stats: ServiceStats | None) -> Table:
    """Searches for points and for requests, and how long the service's steps take."""
    title = f"ik: {report.limb}, {report.solver}; newest point: {report.status or 'none yet'}"
    caption = f"{report.waiting} poses wait"
    if stats is not None:
        caption += f"; a step takes {stats.step_ms_p50:.2f} ms, 1 in 100 {stats.step_ms_p99:.2f}"
    table = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("searches", no_wrap=True)
    table.add_column("points", justify="right")
    table.add_column("requests", justify="right")
    rows = (
        ("all", "solves"),
        ("converged", "converged"),
        ("out of reach", "infeasible"),
        ("out of time", "out_of_time"),
        ("used up their budget", "missed"),
        ("refused", "refused"),
        ("iterations, median", "iterations_p50"),
        ("iterations, 1 in 100 more than", "iterations_p99"),
    )
    for heading, name in rows:
        values = (getattr(report.stream, name), getattr(report.requests, name))
        table.add_row(heading, *(f"{value:g}" for value in values))
    return table
