"""`ulna can dump`: frames as they come, by name, with joints and physical values."""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from hal.wire.can import Received
from services.cli.can_buses import WHOLE_ROBOT, Tap, arrivals, opened, robot_in_use
from services.cli.can_files import read
from services.cli.can_names import BusNames, NamedFrame, Selection, check_selection
from services.config import load_robot
from services.core.clock import NS_PER_S, Clock, RealClock
from services.core.errors import ConfigError
from services.robotfile.robot_tables import RobotFile


class Dump:
    """Writes one line a frame and counts those that no table can read, per cause."""

    def __init__(self, selection: Selection, say: Callable[[str], None]) -> None:
        self.causes: Counter[str] = Counter()
        self.shown = 0
        self._selection = selection
        self._say = say
        self._first_ns: int | None = None

    def take(self, names: BusNames, received: Received) -> None:
        """Show a frame if it is selected."""
        can_id, data, stamp_ns = received
        frame = names.name(can_id, data)
        if frame.decoded.cause:
            self.causes[frame.decoded.cause] += 1
        if self._first_ns is None:
            self._first_ns = stamp_ns
        if self._selection.takes(frame):
            self.shown += 1
            self._say(line(names, received, stamp_ns - self._first_ns, frame))


def line(names: BusNames, received: Received, age_ns: int, frame: NamedFrame) -> str:
    """Seconds since the first frame, bus, identifier, bytes, board, message and values."""
    can_id, data, _ = received
    return (
        f"{age_ns / NS_PER_S:10.6f} {names.bus:<15} {can_id:03X} {data.hex(' ').upper():<23} "
        f"{frame.board:<16} {names.text(frame)}"
    )


def dump(
    taps: Sequence[Tap],
    clock: Clock,
    show: Dump,
    *,
    count: int = 0,
    until_ns: int | None = None,
) -> None:
    """Show what arrives, until an instant or until `count` frames have been shown (0 = all)."""
    for frames in arrivals(taps, clock, until_ns):
        for tap, received in frames:
            show.take(tap.names, received)
            if count and show.shown >= count:
                return


def dump_file(
    path: Path, robot: RobotFile, buses: Sequence[str], show: Dump, count: int = 0
) -> None:
    """Show the frames of a file, of some of the robot's buses or of all."""
    names = {table.number: BusNames(robot, bus) for bus, table in robot.buses.items()}
    known = {name: table.number for name, table in robot.buses.items()}
    wanted = {known.get(bus, int(bus) if bus.isdigit() else -1) for bus in buses}
    for channel, (can_id, data), time_s in read(path, Counter()):
        if wanted and channel not in wanted:
            continue
        bus = names.setdefault(channel, BusNames(None, f"can{channel}"))
        show.take(bus, (can_id, data, round(time_s * NS_PER_S)))
        if count and show.shown >= count:
            return


def can_dump(
    *,
    robot: str = "",
    stack: str = "",
    bus: tuple[str, ...] = (),
    board: tuple[str, ...] = (),
    joint: tuple[str, ...] = (),
    message: tuple[str, ...] = (),
    bad: bool = False,
    count: int = 0,
    seconds: float = 0.0,
    file: Path | None = None,
) -> int:
    """Show frames by name, with joint and physical value; Ctrl-C stops.

    Examples: ulna can dump --bus right_arm --joint r_elbow --message POSITION;
    ulna can dump --file arm.blf --bad

    Args:
        robot: whose buses, boards and joints they are [the running stack's, else icub].
        stack: name of a running stack [the robot's].
        bus: bus of the robot, its number, an interface, or interface:channel of python-can [all].
        board: board of the robot file; * and ? stand for anything [all].
        joint: joint of the robot file [all].
        message: name in the frame tables; * and ? stand for anything [all].
        bad: only frames that no table can read.
        count: end after so many lines [0 = never].
        seconds: end after so long [0 = never].
        file: show what is in a file of `ulna can log` instead.
    """
    if count < 0 or seconds < 0.0:
        raise ConfigError("--count and --seconds are 0 or more")
    robot_file = load_robot(robot or WHOLE_ROBOT) if file else robot_in_use(robot, stack)
    selection = Selection(board, joint, message, bad)
    check_selection(selection, robot_file)
    clock = RealClock()
    show = Dump(selection, _say)
    if file is not None:
        dump_file(file, robot_file, bus, show, count)
        print(f"{show.shown} shown, {causes_text(show.causes)}", file=sys.stderr)
        return 0
    with opened(robot_file, bus, stack=stack, clock=clock) as taps:
        until_ns = clock.now_ns() + round(seconds * NS_PER_S) if seconds else None
        with suppress(KeyboardInterrupt):
            dump(taps, clock, show, count=count, until_ns=until_ns)
        lost = sum(tap.bus.frames_lost for tap in taps)
    print(f"{show.shown} shown, {lost} lost, {causes_text(show.causes)}", file=sys.stderr)
    return 0


def causes_text(causes: Counter[str]) -> str:
    """Frames that could not be read, by cause."""
    return f"{causes['unknown']} unknown, {causes['length']} of wrong length"


def _say(text: str) -> None:
    print(text, flush=True)
