"""What the experiments have in common on the screen: a line of progress."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

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
