"""Opens the CAN buses that a command is to listen to or to send on.

A bus is named as in the robot file (`right_arm`), by its number there (`2`), by an interface of
the kernel (`vcan2`), or as `interface:channel` of any python-can interface (`slcan:/dev/ttyACM0`).
`right_arm=slcan:/dev/ttyACM0` says which bus of the robot that is, so that frames have names.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from hal.buses.bus import FrameBus, HostClock
from hal.buses.python_can import PythonCanBus
from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.errors import HalError
from hal.wire.can import Received
from services.cli.can_names import BusNames
from services.config import load_robot
from services.core.clock import Clock, RealClock
from services.core.errors import ConfigError, NotRunningError, ServiceError
from services.core.live import LiveBuses
from services.core.rundir import RunRecord, read_record
from services.core.session import connect, disconnect
from services.robotfile.robot_tables import RobotFile

WHOLE_ROBOT = "icub"
LOOK_EVERY_NS = 2_000_000
NO_NUMBER = -1


class Tap(NamedTuple):
    """One opened bus; `number` is the robot's, -1 where it is none of them."""

    number: int
    name: str
    bus: FrameBus
    names: BusNames


class _Wanted(NamedTuple):
    """One --bus: the robot's bus that it is, and where it is opened; empty = the robot's own."""

    bus: str
    place: str


def robot_in_use(robot: str, stack: str) -> RobotFile:
    """The robot that was asked for; else what the running stack runs; else the whole iCub.

    Raises:
        ServiceError: no such robot, or no stack of the name.
    """
    if robot:
        return load_robot(robot)
    record = _record(stack or WHOLE_ROBOT, must_run=bool(stack))
    return load_robot(WHOLE_ROBOT if record is None else record.reference or record.robot)


@contextmanager
def opened(
    robot: RobotFile,
    wanted: Sequence[str],
    *,
    stack: str = "",
    clock: RealClock | None = None,
) -> Iterator[list[Tap]]:
    """Open the buses that were asked for, all of the robot's where none was; closes them.

    Over the CAN of the running stack, else over the kernel's interfaces of the robot file.

    Raises:
        ServiceError: no such bus, stack or interface; the text lists what there is.
    """
    clock = clock or RealClock()
    asked = [_parsed(robot, text) for text in wanted] or [_Wanted(name, "") for name in robot.buses]
    own = [want for want in asked if not want.place]
    record = _record(stack or robot.robot.name, must_run=bool(stack)) if own else None
    taps: list[Tap] = []
    session = None
    try:
        live = None
        if record is not None and record.can in ("zenoh", "mixed"):
            session = connect(record.endpoint)
            live = LiveBuses(record.can, record.robot, session, clock)
        elif own and not wanted:
            asked = _interfaces_that_are_up(robot)
        for want in asked:
            taps.append(_tap(robot, want, live, clock))
        yield taps
    except HalError as error:
        raise ServiceError(str(error)) from error
    finally:
        for tap in taps:
            tap.bus.shutdown()
        if session is not None:
            disconnect(session)


def arrivals(
    taps: Sequence[Tap], clock: Clock, until_ns: int | None
) -> Iterator[list[tuple[Tap, Received]]]:
    """What arrives on all buses, oldest first; an empty list where nothing has. None = for ever."""
    while until_ns is None or clock.now_ns() < until_ns:
        frames = [(tap, frame) for tap in taps for frame in tap.bus.receive_frames()]
        frames.sort(key=lambda arrival: arrival[1][2])
        yield frames
        clock.sleep_until(clock.now_ns() + LOOK_EVERY_NS)


def _record(name: str, *, must_run: bool) -> RunRecord | None:
    try:
        return read_record(name)
    except NotRunningError:
        if must_run:
            raise
        return None


def _parsed(robot: RobotFile, text: str) -> _Wanted:
    name, equals, place = text.partition("=")
    if not equals and ":" in text:
        return _Wanted("", text)
    for bus, table in robot.buses.items():
        if name in (bus, str(table.number)):
            return _Wanted(bus, place)
        if name == table.channel and not equals:
            return _Wanted(bus, name if interfaces_up((name,)) else "")
    if equals or not interfaces_up((name,)):
        known = ", ".join(f"{bus} ({table.number})" for bus, table in robot.buses.items())
        raise ConfigError(
            f"{robot.path}: no bus {name!r} here; buses: {known}; else an interface of the kernel "
            "that is up, or interface:channel of python-can"
        )
    return _Wanted("", name)


def _interfaces_that_are_up(robot: RobotFile) -> list[_Wanted]:
    up = [name for name, table in robot.buses.items() if interfaces_up((table.channel,))]
    if not up:
        names = ", ".join(table.channel for table in robot.buses.values())
        raise NotRunningError(
            f"no stack of {robot.robot.name} is up, and none of its interfaces: {names} "
            "(ulna up starts a stack, ulna can up makes virtual interfaces)"
        )
    return [_Wanted(name, "") for name in up]


def _tap(robot: RobotFile, want: _Wanted, live: LiveBuses | None, clock: HostClock) -> Tap:
    table = robot.buses.get(want.bus)
    number = NO_NUMBER if table is None else table.number
    names = BusNames(robot, want.bus or want.place)
    bus: FrameBus
    interface, colon, channel = want.place.partition(":")
    if colon:
        bus = PythonCanBus(interface, channel, clock)
    elif want.place:
        bus = SocketCanBus(want.place, clock)
    elif live is not None and table is not None:
        bus = live.open(table.number, table.channel)
    else:
        assert table is not None
        bus = SocketCanBus(table.channel, clock)
    return Tap(number, want.bus or want.place, bus, names)
