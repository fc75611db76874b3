"""Files of CAN frames in python-can's own formats."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import can
from can.util import channel2int

from hal.buses.bus import frame_of
from hal.wire.can import Frame
from services.core.errors import ConfigError

SUFFIXES = (".log", ".asc", ".blf")


class Logged(NamedTuple):
    """One frame of a file."""

    channel: int
    frame: Frame
    time_s: float


@contextmanager
def writer_of(path: Path) -> Iterator[can.Listener]:
    """python-can's writer for a file; finishes the file on leaving."""
    _check_suffix(path)
    writer = can.Logger(str(path))
    try:
        yield writer
    finally:
        writer.stop()


def read(path: Path, foreign: Counter[str]) -> Iterator[Logged]:
    """Frames of a file in their order; those that the iCub's protocol has not are counted.

    Raises:
        ConfigError: there is no such file, or python-can cannot read it.
    """
    _check_suffix(path)
    try:
        with can.LogReader(str(path)) as messages:
            for message in messages:
                try:
                    frame = frame_of(message)
                except can.CanOperationError:
                    foreign["foreign"] += 1
                    continue
                yield Logged(_channel(message), frame, message.timestamp)
    except (OSError, ValueError, IndexError, EOFError) as error:
        raise ConfigError(f"cannot read {path}: {error}") from error


def _channel(message: can.Message) -> int:
    channel = message.channel
    number = channel2int(channel) if isinstance(channel, int | str) else None
    return 0 if number is None else number


def _check_suffix(path: Path) -> None:
    if path.suffix not in SUFFIXES:
        raise ConfigError(f"{path}: python-can's files end in one of {', '.join(SUFFIXES)}")
