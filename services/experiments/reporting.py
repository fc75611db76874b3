"""What the experiments have in common on the screen: progress, and files that can be written."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from services.core.errors import ConfigError

Tell = Callable[[str], None]


@contextmanager
def working(console: Console, what: str) -> Iterator[Tell]:
    """A line that says what is going on, until the work is done; call what it gives to change it.

    On a terminal the line moves and vanishes at the end; elsewhere `what` is printed once.
    """
    if not console.is_terminal:
        console.print(f"{what} ...")
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as progress:
        task = progress.add_task(what, total=None)
        yield lambda text: progress.update(task, description=text)


def tell_motion(tell: Tell, seed: int, at_s: float, what: str) -> None:
    """Say what the emulated robot of a seed is doing."""
    tell(f"plant {seed}: {what}; robot time {at_s:.0f} s")


def check_folders(*files: Path | None) -> None:
    """Refuse files that cannot be written, before anything takes time.

    Raises:
        ConfigError: a folder is not there.
    """
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ConfigError(f"cannot write {file}: there is no folder {file.parent}")
