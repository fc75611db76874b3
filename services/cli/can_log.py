"""`ulna can log` and `ulna can replay`: frames in python-can's own files (.log, .asc, .blf).

A file names a bus by its number on the robot; a bus that is none of the robot's follows behind.
Times in a file are those of the day's clock.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import can

from hal.buses.bus import HostClock
from hal.wire.can import Frame
from services.cli.can_buses import NO_NUMBER, Tap, arrivals, opened, robot_in_use
from services.cli.can_danger import danger
from services.cli.can_files import Logged, read, writer_of
from services.core.clock import NS_PER_S, Clock, RealClock
from services.core.errors import ConfigError
from services.robotfile.robot_tables import RobotFile


def log(
    taps: Sequence[Tap],
    clock: HostClock,
    writer: can.Listener,
    pace: Clock,
    until_ns: int | None,
) -> int:
    """Write what arrives until an instant or Ctrl-C; returns how many frames there were."""
    written = 0
    day_ns = clock.since_day_clock_ns()
    channels = channels_of(taps)
    with suppress(KeyboardInterrupt):
        for frames in arrivals(taps, pace, until_ns):
            for tap, (can_id, data, stamp_ns) in frames:
                writer.on_message_received(
                    can.Message(
                        arbitration_id=can_id,
                        data=data,
                        is_extended_id=False,
                        timestamp=(stamp_ns - day_ns) / NS_PER_S,
                        channel=channels[id(tap)],
                    )
                )
                written += 1
    return written


def channels_of(taps: Sequence[Tap]) -> dict[int, int]:
    """Number of each bus in a file."""
    used = {tap.number for tap in taps}
    free = (number for number in range(len(taps) + len(used) + 1) if number not in used)
    return {id(tap): next(free) if tap.number == NO_NUMBER else tap.number for tap in taps}


def replay(
    logged: Iterable[Logged], taps: Mapping[int, Tap], clock: Clock, speed: float = 1.0
) -> Counter[str]:
    """Send the frames of a file in their time; those of buses that no tap stands for are skipped.

    Frames of one instant go out together. Returns what became of them: "sent", "skipped".
    """
    outcome: Counter[str] = Counter()
    begin_ns, first_s = clock.now_ns(), None
    waiting: dict[int, list[Frame]] = {}
    due_ns = begin_ns
    for channel, frame, time_s in logged:
        first_s = time_s if first_s is None else first_s
        this_ns = begin_ns + round((time_s - first_s) / speed * NS_PER_S)
        if this_ns > due_ns:
            _flush(waiting, taps)
            due_ns = this_ns
            clock.sleep_until(due_ns)
        if channel in taps:
            waiting.setdefault(channel, []).append(frame)
            outcome["sent"] += 1
        else:
            outcome["skipped"] += 1
    _flush(waiting, taps)
    return outcome


def _flush(waiting: dict[int, list[Frame]], taps: Mapping[int, Tap]) -> None:
    for channel, frames in waiting.items():
        taps[channel].bus.send_frames(frames)
    waiting.clear()


def bus_map(texts: Sequence[str], robot: RobotFile, channels: set[int]) -> dict[int, str]:
    """Where each bus of a file goes to: `2=vcan7` by number; else the robot's bus of the number.

    Raises:
        ConfigError: not of that form.
    """
    mapped = {table.number: name for name, table in robot.buses.items() if table.number in channels}
    if texts:
        mapped = {}
    for text in texts:
        number, equals, place = text.partition("=")
        if not equals or not number.isdigit() or not place:
            raise ConfigError(f"--bus {text}: write number of the file = bus, as 2=right_arm")
        mapped[int(number)] = place
    return mapped


def refuse_danger(logged: Iterable[Logged], channels: set[int]) -> None:
    """Refuse a file that has a dangerous frame for one of these buses.

    Raises:
        ConfigError: naming the first of them.
    """
    for channel, (can_id, data), _ in logged:
        reason = danger(can_id, data) if channel in channels else ""
        if reason:
            text = f"{can_id:03X}#{data.hex().upper()}"
            raise ConfigError(f"not sent: {text} {reason}; --yes sends such frames")


def can_log(
    file: Path,
    *,
    robot: str = "",
    stack: str = "",
    bus: tuple[str, ...] = (),
    seconds: float = 0.0,
) -> int:
    """Write every frame into a file of python-can's: .log, .asc or .blf; Ctrl-C stops.

    Example: ulna can log arm.log --bus right_arm --seconds 10

    Args:
        file: what to write; it is overwritten.
        robot: whose buses they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        bus: bus of the robot, its number, an interface, or interface:channel of python-can [all].
        seconds: end after so long [0 = never].
    """
    if seconds < 0.0:
        raise ConfigError(f"--seconds {seconds:g}: must be 0 or more")
    clock = RealClock()
    with (
        opened(robot_in_use(robot, stack), bus, stack=stack, clock=clock) as taps,
        writer_of(file) as sink,
    ):
        until_ns = clock.now_ns() + round(seconds * NS_PER_S) if seconds else None
        written = log(taps, clock, sink, clock, until_ns)
        lost = sum(tap.bus.frames_lost for tap in taps)
    print(f"{written} frames in {file}, {lost} lost", file=sys.stderr)
    return 0


def can_replay(
    file: Path,
    *,
    robot: str = "",
    stack: str = "",
    bus: tuple[str, ...] = (),
    speed: float = 1.0,
    yes: bool = False,
) -> int:
    """Send the frames of a file (.log, .asc, .blf) in the time in which they came.

    Example: ulna can replay arm.log --bus 2=vcan7 --speed 0.5

    Args:
        file: what `ulna can log` or any other tool of python-can's wrote.
        robot: whose buses they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        bus: number in the file = bus; others are left out [the robot's bus of that number].
        speed: 2 = twice as fast.
        yes: send also what is dangerous, what moves a joint for instance.
    """
    if speed <= 0.0:
        raise ConfigError(f"--speed {speed:g}: must be above 0")
    robot_file, clock = robot_in_use(robot, stack), RealClock()
    foreign: Counter[str] = Counter()
    channels = {logged.channel for logged in read(file, Counter())}
    targets = bus_map(bus, robot_file, channels)
    if not yes:
        refuse_danger(read(file, Counter()), set(targets))
    with opened(robot_file, tuple(targets.values()), stack=stack, clock=clock) as opened_taps:
        taps = dict(zip(targets, opened_taps, strict=True))
        with suppress(KeyboardInterrupt):
            outcome = replay(read(file, foreign), taps, clock, speed)
            print(
                f"{outcome['sent']} sent, {outcome['skipped']} of other buses, "
                f"{foreign['foreign']} that are no frames of the iCub's",
                file=sys.stderr,
            )
    return 0
