"""What `ulna field` prints."""

import math
from collections.abc import Iterator, Sequence

from rich import box
from rich.table import Table

from services.fields.lateness import LATE_MS
from services.fields.messages import FieldInfo, FieldState, FieldStatus, ModeInfo, Preview
from services.messages import Floats, WorldObject


def millimetres(length_m: float) -> str:
    """A length for a cell."""
    if math.isnan(length_m):
        return "-"
    return "none near" if math.isinf(length_m) else f"{1e3 * length_m:.1f} mm"


def status_lines(status: FieldStatus) -> Iterator[str]:
    """State, and what it is due to."""
    gains = ", ".join(f"{name} {value:g}" for name, value in status.gains)
    yield f"mode {status.mode}: {gains}"
    goal = f"goal {status.goal} of {status.limb}" if status.goal else f"no goal, {status.limb}"
    away = "" if math.isnan(status.goal_distance_m) else f", {millimetres(status.goal_distance_m)}"
    if away and not math.isnan(status.goal_angle_rad):
        away += f" and {math.degrees(status.goal_angle_rad):.1f} deg"
    yield f"{goal}: {status.state}{away and away + ' away'}"
    if status.reason:
        yield status.reason
    if not math.isnan(status.clearance_m):
        between = " - ".join(part for part in status.nearest if part)
        yield f"clearance {millimetres(status.clearance_m)}{between and ': ' + between}"
    if not math.isnan(status.lag_m):
        yield f"hand behind the point {millimetres(status.lag_m)}"
    if status.budget:
        yield (
            f"search {status.iterations} of {status.budget} iterations, "
            f"{status.nodes} nodes; speed held in {status.held} periods"
        )
    if status.late_ms > LATE_MS:
        yield (
            f"periods began up to {status.late_ms:.0f} ms late: the processor has too much to do, "
            "and the arm gets out of the way so much later"
        )
    elif status.late_count:
        yield f"periods began over {LATE_MS:.0f} ms late; times so far: {status.late_count}"
    if status.assumed:
        yield f"not heard, taken to be where they were: {', '.join(status.assumed)}"
    if status.refused:
        yield f"refused {status.refused}, the newest: {status.refusal}"


def fields_table(fields: Sequence[FieldState]) -> Table:
    """A row for each field."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("field", no_wrap=True)
    table.add_column("kind")
    table.add_column("on")
    for heading in ("distance", "force N", "speed m/s", "sigma", "age s"):
        table.add_column(heading, justify="right", no_wrap=True)
    for field in fields:
        table.add_row(
            _full_name(field),
            field.kind,
            "on" if field.on else "off",
            millimetres(field.distance_m),
            "-" if math.isnan(field.force_n) else f"{field.force_n:.2f}",
            f"{math.hypot(*field.velocity_m_s):.3f}",
            millimetres(field.sigma_m),
            f"{field.age_s:.1f}",
        )
    return table


def field_remarks(fields: Sequence[FieldState]) -> Iterator[str]:
    """What is odd about a field: too long for a cell."""
    for field in fields:
        if field.note:
            yield f"{_full_name(field)}: {field.note}"


def gains_table(mode: ModeInfo) -> Table:
    """The constants of a mode."""
    table = Table(title=mode.name, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False)
    for heading in ("gain", "value", "unit", "default", "paper", "from", "to", "meaning"):
        table.add_column(heading)
    for gain in mode.gains:
        numbers = (gain.default, gain.paper, gain.lowest, gain.highest)
        table.add_row(
            gain.name,
            f"{gain.value:g}",
            gain.unit,
            *("-" if math.isnan(number) else f"{number:g}" for number in numbers),
            gain.meaning,
        )
    return table


def objects_table(info: FieldInfo) -> Table:
    """What the sources have sent."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    for heading in ("source", "name", "shape", "size m", "at m", "role", "on", "age s"):
        table.add_column(heading)
    for source in info.sources:
        for item in source.objects:
            table.add_row(
                source.source or "-",
                item.name,
                item.shape,
                size_text(item),
                numbers_text(item.position_m),
                item.role,
                "on" if item.on else "off",
                f"{source.age_s:.1f}",
            )
    return table


def preview_table(previews: Sequence[Preview]) -> Table:
    """A row for each mode that was looked at."""
    table = Table(title="preview", title_justify="left", box=box.SIMPLE_HEAD, show_edge=False)
    for heading in ("mode", "arrives", "closest", "to", "at s", "left", "state"):
        table.add_column(heading)
    for found in previews:
        table.add_row(
            found.mode,
            f"after {found.arrival_s:.2f} s" if found.arrives else "no",
            millimetres(found.closest_m),
            found.closest_to or "-",
            f"{found.closest_s:.2f}" if found.closest_to else "-",
            millimetres(found.final_distance_m),
            found.state,
        )
    return table


def preview_remarks(previews: Sequence[Preview]) -> Iterator[str]:
    """What a path's end is due to: too long for a cell."""
    for found in previews:
        if found.reason:
            yield f"{found.mode}: {found.reason}"


def progress_line(status: FieldStatus) -> str:
    """A status in one line."""
    text = status.state
    if not math.isnan(status.goal_distance_m):
        text += f", {millimetres(status.goal_distance_m)} to go"
    if not math.isnan(status.clearance_m):
        text += f", clearance {millimetres(status.clearance_m)}"
    return f"{text}: {status.reason}" if status.reason else text


def _full_name(field: FieldState) -> str:
    return f"{field.source}/{field.name}" if field.source else field.name


def size_text(item: WorldObject) -> str:
    """Of an object."""
    return f"{len(item.vertices_m)} vertices" if item.vertices_m else numbers_text(item.size_m)


def numbers_text(values: Floats) -> str:
    """As a command line takes them."""
    return " ".join(f"{value:g}" for value in values)
