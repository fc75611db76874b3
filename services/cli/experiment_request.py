"""What all verbs of `ulna experiment` ask of their options, before minutes of work."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from services.core.errors import ConfigError

MOST_RUNS = 100
Json = Annotated[Path | None, Parameter(name="--json")]


def check(runs: int, *files: Path | None) -> None:
    """Refuse a number of runs that is none, and a file that cannot be written.

    Raises:
        ConfigError: which, and why.
    """
    if not 1 <= runs <= MOST_RUNS:
        raise ConfigError(f"--runs: {runs} is outside 1..{MOST_RUNS}")
    for file in files:
        if file is None:
            continue
        if not file.parent.is_dir():
            raise ConfigError(f"cannot write {file}: there is no folder {file.parent}")
        is_new = not file.exists()
        try:  # now, and not after minutes of work
            file.open("ab").close()
        except OSError as error:
            raise ConfigError(f"cannot write {file}: {error.strerror}") from error
        if is_new:
            file.unlink()
