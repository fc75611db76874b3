"""`ulna field preview`: paths that are not gone."""

from pathlib import Path
from typing import Annotated, Literal

import cyclopts
import msgspec
from rich.console import Console

from services.cli.complaint import complain
from services.cli.field_tables import preview_remarks, preview_table
from services.core.errors import ConfigError, ServiceError
from services.fields.client_blocking import BlockingFieldControl
from services.fields.messages import MODES, Preview
from services.reaching.client_types import RequestRefusedError

REFUSED = 1
FAILED = 2

Triple = tuple[float, float, float]


def field_preview(
    position: Triple | None = None,
    /,
    *,
    rotation: Triple | None = None,
    limb: str = "",
    mode: tuple[Literal["ulna", "dforc", "pmp", "all"], ...] = (),
    paper: bool = False,
    duration: float = 0.0,
    plot: Path | None = None,
    json_file: Annotated[Path | None, cyclopts.Parameter(name="--json")] = None,
    stack: str = "icub",
) -> int:
    """Show the path to a place without moving: whether it arrives, when, and how close it comes.

    Example: ulna field preview -0.4 0.1 0.1 --mode all --plot preview.png

    Args:
        position: X Y Z of the hand, m, base frame. Default: the goal in use.
        rotation: its orientation as a rotation vector, rad. None: any.
        limb: right_arm, left_arm or both_arms. Default: the main job's.
        mode: of those, or all; may be given more than once. Default: the one in use.
        paper: with the gains of the papers.
        duration: at most, s. 0: 15 s.
        plot: write a figure there.
        json_file: write the paths there.
        stack: name of the running stack.

    Returns:
        Exit status: 0 it arrives in every mode, 1 refused or not, 2 without an answer.
    """
    modes: tuple[str, ...] = MODES if "all" in mode else mode or ("",)
    try:
        for file in (plot, json_file):
            if file is not None and not file.parent.is_dir():
                raise ConfigError(f"cannot write {file}: there is no folder {file.parent}")
        with BlockingFieldControl(stack) as control:
            found = [
                control.preview(
                    position,
                    rotation,
                    limb=limb,
                    mode=one,
                    preset="paper" if paper else "",
                    duration_s=duration,
                )
                for one in modes
            ]
            if plot is not None:
                _draw(found, control, plot)
    except ServiceError as error:
        return _complain(error)
    Console().print(preview_table(found))
    for remark in preview_remarks(found):
        print(remark)
    if json_file is not None:
        json_file.write_bytes(preview_json(found))
    for file in (plot, json_file):
        if file is not None:
            print(f"written: {file}")
    return 0 if all(one.arrives for one in found) else REFUSED


def preview_json(found: list[Preview]) -> bytes:
    """Previews by the names of their fields; what is not finite is null."""
    rows = []
    for one in found:
        path = [msgspec.structs.asdict(point) for point in one.path]
        rows.append(msgspec.structs.asdict(one) | {"path": path})
    return msgspec.json.format(msgspec.json.encode(rows), indent=2) + b"\n"


def _draw(found: list[Preview], control: BlockingFieldControl, plot: Path) -> None:
    from services.cli.field_plot import draw_previews  # matplotlib takes a second to load

    draw_previews(found, control.info(), plot)


def _complain(error: ServiceError) -> int:
    complain(error)
    return REFUSED if isinstance(error, RequestRefusedError) else FAILED
