"""`ulna can stats`: frames a second, bus load, losses and what could not be read."""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Literal

import can
from rich import box
from rich.console import Console
from rich.table import Table

from hal.buses.python_can import PythonCanBus
from hal.wire.can import Received
from services.cli.can_buses import Tap, arrivals, opened, robot_in_use
from services.core.clock import NS_PER_S, Clock, RealClock
from services.core.errors import ConfigError

BIT_RATE = 1_000_000  # bit/s of the iCub's buses
FRAME_BITS = 47  # around the data bytes of an 11-bit frame, without stuffing (can-protocol 11.3)

PIPE_WIDTH = 160

By = Literal["bus", "board", "message", "id"]


@dataclass
class Count:
    """What has arrived under one name."""

    frames: int = 0
    bits: int = 0

    def add(self, data: bytes) -> None:
        """One more frame."""
        self.frames += 1
        self.bits += FRAME_BITS + 8 * len(data)


@dataclass
class BusCount:
    """What has arrived on one bus: in all, and by board, message and identifier."""

    tap: Tap
    all: Count = field(default_factory=Count)
    by: dict[By, dict[str, Count]] = field(
        default_factory=lambda: {"bus": {}, "board": {}, "message": {}, "id": {}}
    )
    causes: Counter[str] = field(default_factory=Counter)
    lost_before: int = 0

    def take(self, received: Received) -> None:
        """Count one frame."""
        can_id, data, _ = received
        frame = self.tap.names.name(can_id, data)
        if frame.decoded.cause:
            self.causes[frame.decoded.cause] += 1
        self.all.add(data)
        keys: tuple[tuple[By, str], ...] = (
            ("board", frame.board),
            ("message", frame.message),
            ("id", f"{can_id:03X} {frame.board} {frame.message}"),
        )
        for by, key in keys:
            self.by[by].setdefault(key, Count()).add(data)

    @property
    def lost(self) -> int:
        """Frames known to be lost since the count began."""
        return self.tap.bus.frames_lost - self.lost_before


def load_percent(bits: int, seconds: float) -> float:
    """Share of the bus's time that so many bits take."""
    return 100.0 * bits / BIT_RATE / seconds


def count_frames(taps: Sequence[Tap], clock: Clock, until_ns: int | None) -> list[BusCount]:
    """Count what arrives until an instant or Ctrl-C."""
    counts = {id(tap): BusCount(tap, lost_before=tap.bus.frames_lost) for tap in taps}
    with suppress(KeyboardInterrupt):
        for frames in arrivals(taps, clock, until_ns):
            for tap, received in frames:
                counts[id(tap)].take(received)
    return list(counts.values())


def summary_table(counts: Sequence[BusCount], seconds: float) -> Table:
    """One line a bus; "other" are error frames and those with 29-bit identifiers."""
    columns = (
        "bus",
        "frames",
        "frames/s",
        "load %",
        "lost",
        "unknown",
        "wrong length",
        "other",
        "state",
    )
    table = Table(*columns, box=box.SIMPLE_HEAD)
    for count in counts:
        is_off = count.tap.bus.state == can.BusState.ERROR
        table.add_row(
            count.tap.name,
            str(count.all.frames),
            f"{count.all.frames / seconds:.0f}",
            f"{load_percent(count.all.bits, seconds):.1f}",
            str(count.lost),
            str(count.causes["unknown"]),
            str(count.causes["length"]),
            str(count.tap.bus.foreign if isinstance(count.tap.bus, PythonCanBus) else 0),
            "off" if is_off else "on",
        )
    return table


def detail_table(counts: Sequence[BusCount], seconds: float, by: By) -> Table:
    """One line a board, message or identifier of each bus, the busiest first."""
    table = Table("bus", by, "frames", "frames/s", "load %", box=box.SIMPLE_HEAD)
    for count in counts:
        busiest = sorted(count.by[by].items(), key=lambda item: -item[1].bits)
        for key, one in busiest:
            table.add_row(
                count.tap.name,
                key,
                str(one.frames),
                f"{one.frames / seconds:.1f}",
                f"{load_percent(one.bits, seconds):.2f}",
            )
    return table


def can_stats(
    *,
    robot: str = "",
    stack: str = "",
    bus: tuple[str, ...] = (),
    seconds: float = 5.0,
    by: By = "bus",
) -> int:
    """Count frames for a while: rate, bus load, losses, unreadable ones; Ctrl-C ends it early.

    The load counts 47 bits and the data bytes of each frame at 1 Mbit/s, without stuffing.

    Example: ulna can stats --seconds 2 --by board

    Args:
        robot: whose buses and boards they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        bus: bus of the robot, its number, an interface, or interface:channel of python-can [all].
        seconds: how long.
        by: a second table by board, message or id.
    """
    if seconds <= 0.0:
        raise ConfigError(f"--seconds {seconds:g}: must be above 0")
    clock = RealClock()
    with opened(robot_in_use(robot, stack), bus, stack=stack, clock=clock) as taps:
        begin_ns = clock.now_ns()
        counts = count_frames(taps, clock, begin_ns + round(seconds * NS_PER_S))
        taken_s = (clock.now_ns() - begin_ns) / NS_PER_S
        report(counts, taken_s, by, wide_console().print)
    return 0


def wide_console() -> Console:
    """The terminal; where there is none, lines are wide enough for every name."""
    return Console() if sys.stdout.isatty() else Console(width=PIPE_WIDTH)


def report(
    counts: Sequence[BusCount], seconds: float, by: By, show: Callable[[Table], None]
) -> None:
    """Show the tables that were asked for."""
    show(summary_table(counts, seconds))
    if by != "bus":
        show(detail_table(counts, seconds, by))
