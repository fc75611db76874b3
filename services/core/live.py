"""Run one service as a process of its own: `python -m services.<name>`.

A stop signal ends it with the service's close() and status 0. An error in step() is logged, close()
sends the safe command, and the status is 1.
"""

import argparse
import logging
import signal
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import zenoh

from hal.buses.bus import FrameBus
from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.buses.zenoh import ZenohBus
from hal.errors import HalError
from services.core.clock import Clock, RealClock
from services.core.errors import ServiceError
from services.core.log import log_to_stderr
from services.core.loop import LiveExecutor
from services.core.realtime import (
    die_with_parent,
    freeze_garbage,
    ordinary_scheduling,
    request_scheduling,
)
from services.core.rundir import read_record
from services.core.service import Service
from services.core.session import connect, disconnect
from services.processes import DEFAULT_ROBOT, process_row

logger = logging.getLogger(__name__)

ROBOT_HELP = "name[:parts][@site] of a robot in robots/, or a robot file"
TRANSPORTS = ("zenoh", "socketcan", "mixed")  # mixed: SocketCAN for the interfaces that are up
HUB_PATIENCE_S = 10.0  # containers start in any order
GRACE_S = 5  # from a stop signal to the end of the process, come what may


@dataclass(frozen=True)
class Context:
    """What a service may need to be built; the same for live and virtual time.

    `robot` is a name below robots/ or a path to a robot file; `opener` opens a bus by its number
    and the interface that the robot file names for it.
    """

    robot: str
    seed: int
    clock: Clock
    opener: Callable[[int, str], FrameBus]

    def open_bus(self, number: int, interface: str = "") -> FrameBus:
        """Open a CAN bus; whoever made the context closes it. `interface` is for SocketCAN only."""
        return self.opener(number, interface or f"vcan{number}")


@dataclass(frozen=True)
class Arguments:
    """The command line of every process."""

    robot: str
    hub: str
    can: str
    seed: int
    name: str
    parent: int

    @property
    def robot_name(self) -> str:
        """What the keys on the bus start with."""
        return robot_name(self.robot)


class LiveBuses:
    """Opens buses over one transport, and closes them all."""

    def __init__(self, can: str, robot: str, session: zenoh.Session, clock: RealClock) -> None:
        self._can = can
        self._robot = robot
        self._session = session
        self._clock = clock
        self._opened: list[FrameBus] = []

    def open(self, number: int, interface: str) -> FrameBus:
        """Open one bus; BusError where it cannot be."""
        bus: FrameBus
        mixed = self._can == "mixed" and interfaces_up((interface,))
        if self._can == "socketcan" or mixed:
            bus = SocketCanBus(interface, self._clock)
        else:
            channel = f"{self._robot}/can{number}"
            bus = ZenohBus(channel, session=self._session, clock=self._clock)
        self._opened.append(bus)
        return bus

    def close(self) -> None:
        """Close what was opened."""
        for bus in self._opened:
            bus.shutdown()


class StopSignal:
    """SIGTERM and SIGINT: the loop ends, and the process with it after the grace at the latest."""

    def __init__(self) -> None:
        self.requested = False
        self._executor: LiveExecutor | None = None
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._arrived)

    def guard(self, executor: LiveExecutor) -> None:
        """Stop this executor when a signal comes, or now if one has come already."""
        self._executor = executor
        if self.requested:
            executor.stop()

    def _arrived(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.requested = True
        signal.alarm(GRACE_S)  # its default action ends the process, also one that hangs
        if self._executor is not None:
            self._executor.stop()


def run_process(
    name: str, build: Callable[[Context], Service], arguments: Sequence[str] | None = None
) -> int:
    """Build a service and run it until a stop signal; returns the exit status."""
    given = read_arguments(name, arguments)
    log_to_stderr(name)
    if given.parent and not die_with_parent(given.parent):
        return 1
    stop = StopSignal()
    row = process_row(name)
    scheduler = request_scheduling(row.fifo_priority, row.nice)
    try:
        session = connect(given.hub or _endpoint_of(given), HUB_PATIENCE_S)
    except ServiceError as error:
        logger.error("%s", error)  # noqa: TRY400  the sentence says it all
        return 1
    try:
        return _serve(name, build, given, session, scheduler, stop)
    finally:
        disconnect(session)


def _serve(
    name: str,
    build: Callable[[Context], Service],
    given: Arguments,
    session: zenoh.Session,
    scheduler: str,
    stop: StopSignal,
) -> int:
    clock = RealClock()
    buses = LiveBuses(given.can, given.robot_name, session, clock)
    try:
        context = Context(given.robot, given.seed, clock, buses.open)
        # Threads of the buses are made here, and inherit what this one has.
        with nullcontext() if process_row(name).on_can else ordinary_scheduling():
            service = build(context)
        freeze_garbage()
        executor = LiveExecutor(name, service, session, given.robot_name, clock, scheduler)
        stop.guard(executor)
        logger.info("at work, %s", scheduler)
        executor.run()
        logger.info("stopped after %d steps", executor.step_times.count)
    except (ServiceError, HalError) as error:
        logger.error("%s", error)  # noqa: TRY400  meant for the user, who has no use for a traceback
        return 1
    except Exception:  # the one broad except: close() has been called, the supervisor takes over
        logger.exception("ended by an error")
        return 1
    finally:
        buses.close()
    return 0


def read_arguments(name: str, arguments: Sequence[str] | None) -> Arguments:
    """Read the command line of a process."""
    parser = argparse.ArgumentParser(prog=f"python -m services.{name}")
    parser.add_argument("--robot", default=DEFAULT_ROBOT, help=ROBOT_HELP)
    parser.add_argument(
        "--hub", default="", help="endpoint of the hub, as tcp/127.0.0.1:7447 [the running stack's]"
    )
    parser.add_argument(
        "--can", default="zenoh", choices=TRANSPORTS, help="what carries CAN frames"
    )
    parser.add_argument("--stack", "--name", dest="name", default="", help="its name [the robot's]")
    parser.add_argument("--seed", type=int, default=0, help="of the emulated robot's random draws")
    parser.add_argument("--parent", type=int, default=0, help=argparse.SUPPRESS)
    return Arguments(**vars(parser.parse_args(arguments)))


def _endpoint_of(given: Arguments) -> str:
    """Where the hub of a stack on this host listens; NotRunningError where there is none."""
    return read_record(given.name or given.robot_name).endpoint


def robot_name(reference: str) -> str:
    """Name of a robot given by name or by the path of its file, robots/<name>/robot.toml.

    What a reference says of parts and site behind the name is left out.
    """
    robot = reference.partition("@")[0].partition(":")[0]
    return Path(robot).resolve().parent.name if robot.endswith(".toml") else robot
