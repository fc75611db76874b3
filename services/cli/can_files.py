"""Files of CAN frames in python-can's own formats."""

import struct
import zlib
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

BLF_MAGIC = b"LOGG"
SUFFIXES = (".log", ".asc", ".blf")


class Logged(NamedTuple):
    """One frame of a file."""

    channel: int
    frame: Frame
    time_s: float


@contextmanager
def writer_of(path: Path) -> Iterator[can.Listener]:
    """python-can's writer for a file; finishes the file on leaving.

    Raises:
        ConfigError: the file cannot be written.
    """
    _check_suffix(path)
    try:
        writer = can.Logger(str(path))
    except OSError as error:
        raise ConfigError(f"cannot write {path}: {error.strerror}") from error
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
        _check_blf(path)
        with can.LogReader(str(path)) as messages:
            for message in messages:
                try:
                    frame = frame_of(message)
                except can.CanOperationError:
                    foreign["foreign"] += 1
                    continue
                yield Logged(_channel(message), frame, message.timestamp)
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror or error}") from error
    except (ValueError, LookupError, EOFError, struct.error, zlib.error, can.CanError) as error:
        raise ConfigError(f"{path} is no {path.suffix} file of CAN frames: {error}") from error


def _channel(message: can.Message) -> int:
    channel = message.channel
    number = channel2int(channel) if isinstance(channel, int | str) else None
    return 0 if number is None else number


def _check_blf(path: Path) -> None:
    """python-can would leave a file open that it finds to be none of its own."""
    if path.suffix == ".blf":
        with path.open("rb") as file:
            if file.read(len(BLF_MAGIC)) != BLF_MAGIC:
                raise ConfigError(f"{path} is no .blf file of CAN frames")


def _check_suffix(path: Path) -> None:
    if path.suffix not in SUFFIXES:
        raise ConfigError(f"{path}: python-can's files end in one of {', '.join(SUFFIXES)}")
