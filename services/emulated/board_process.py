"""One emulated board with bench motors, alone on one bus: what `ulna board run` runs.

The board keeps its own time, as a real one does: one millisecond at a time, by absolute deadlines.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import can

from firmware_sim.boards.warm import warm
from firmware_sim.plants.bench import BenchRig
from hal.buses.bus import FrameBus
from hal.buses.python_can import PythonCanBus
from hal.buses.socketcan import SocketCanBus, interfaces_up
from hal.buses.zenoh import ZenohBus
from hal.wire.can import CLASS_MANAGEMENT, Received, class_of, source_of
from services.board_watch import Watch
from services.core.clock import NS_PER_MS, NS_PER_S, RealClock
from services.core.errors import ServiceError
from services.core.live import StopSignal, robot_name
from services.core.paced import PacedClock
from services.core.realtime import freeze_garbage, request_scheduling
from services.core.rundir import read_record, running
from services.core.session import connect, disconnect
from services.emulated.emulation import rig_spec
from services.emulated.plug import Plugged
from services.processes import process_row

logger = logging.getLogger(__name__)

LISTEN_NS = 200 * NS_PER_MS  # a board that talks does so more often
LOOK_AT_BUS_TICKS = 20
GONE_TICKS = 3000  # a hub that is away for so long has ended, and another one listens elsewhere
STATUS_TICKS = 1000


class AddressTakenError(ServiceError):
    """Somebody else sends with the board's address."""


@dataclass(frozen=True, kw_only=True)
class Wire:
    """How the board is connected; what is empty is found out."""

    can: str = ""  # socketcan or zenoh
    interface: str = ""  # of python-can, then with its channel
    channel: str = ""
    stack: str = ""  # name of the running stack
    hub: str = ""


class PluggedBoard:
    """The board and its bench, one millisecond per step."""

    def __init__(self, plugged: Plugged, bus: FrameBus, seed: int = 0) -> None:
        self._number = plugged.bus.number
        self._bus = bus
        self._rig = BenchRig(rig_spec(plugged.robot, seed))
        self._board = self._rig.board(self._number, plugged.board.address)
        self.watch = Watch(plugged.addresses, self._board.axes, plugged.joints)
        self.ticks = 0
        self.frames = 0
        self.off_ticks = 0  # since when nothing has got through

    def step(self) -> list[str]:
        """One millisecond; sentences about what has changed in it."""
        lines = self._look_at_bus() if self.ticks % LOOK_AT_BUS_TICKS == 0 else []
        self.ticks += 1
        sent = self._rig.step({self._number: self._bus.receive_frames()})[self._number]
        if sent:
            self._bus.send_frames(sent)
            self.frames += len(sent)
        return lines + self.watch.look(sent)

    def status(self) -> str:
        """The board, its traffic and its losses in one line."""
        return f"{self.watch.state()}; {self.frames} frames sent, {self._bus.frames_lost} lost"

    def _look_at_bus(self) -> list[str]:
        was_off = self._board.bus_off
        self._board.bus_off = self._bus.state is can.BusState.ERROR
        self.off_ticks = self.off_ticks + LOOK_AT_BUS_TICKS if self._board.bus_off else 0
        if self._board.bus_off == was_off:
            return []
        return ["the bus is back" if was_off else "the bus is off: no frame gets through"]


def run_board(
    plugged: Plugged,
    wire: Wire,
    say: Callable[[str], None],
    *,
    seconds: float = 0.0,
    status: bool = False,
    seed: int = 0,
) -> int:
    """Plug the board in and run it until a stop signal, or for some seconds; the exit status.

    Raises:
        AddressTakenError: another board sends with this address.
        ServiceError, HalError: the bus cannot be opened.
    """
    stop = StopSignal()
    boards = process_row("boards")
    scheduler = request_scheduling(boards.fifo_priority, boards.nice)
    clock = RealClock()
    warm()
    with open_bus(plugged, wire, clock) as (bus, where):
        check_address(plugged, bus, clock)
        board = PluggedBoard(plugged, bus, seed)
        say(f"{plugged.text}; on {where}, {scheduler}; Ctrl-C unplugs it")
        for line in board.step():  # the first millisecond also loads the plant's arithmetic
            say(line)
        freeze_garbage()
        paced = PacedClock(clock)
        last_tick = round(seconds * NS_PER_S / NS_PER_MS) or -1
        while not stop.requested and board.ticks != last_tick:
            paced.advance_ns(NS_PER_MS)
            for line in board.step():
                say(line)
            if status and board.ticks % STATUS_TICKS == 0:
                say(f"{board.status()}; {lateness(paced)}")
            if board.off_ticks > GONE_TICKS and isinstance(bus, ZenohBus):
                say("unplugged: the stack has ended")
                return 1
        say(f"unplugged after {board.ticks / 1000:.1f} s: {board.status()}; {lateness(paced)}")
    return 0


def lateness(paced: PacedClock) -> str:
    """How the loop has kept its time."""
    p50_ns, p99_ns = paced.lateness.percentiles_ns(50, 99)
    return (
        f"ticks late by {p50_ns / 1e3:.0f} us median, {p99_ns / 1e3:.0f} us p99, "
        f"{paced.slips} slipped"
    )


@contextmanager
def open_bus(plugged: Plugged, wire: Wire, clock: RealClock) -> Iterator[tuple[FrameBus, str]]:
    """The bus and what it is called; closed at the end.

    Raises:
        ServiceError, HalError: it cannot be opened; the text says what to do.
    """
    bus: FrameBus
    channel = wire.channel or plugged.bus.channel
    robot = robot_name(str(plugged.robot.path))
    stack = wire.stack or robot
    if wire.interface:
        bus = PythonCanBus(wire.interface, channel, clock)
        with closing(bus):
            yield bus, f"{wire.interface} {channel}"
    elif (wire.can or found_out(stack, channel)) == "socketcan":
        bus = SocketCanBus(channel, clock)
        with closing(bus):
            yield bus, channel
    else:
        endpoint = wire.hub or read_record(stack).endpoint
        session = connect(endpoint)
        try:
            bus = ZenohBus(f"{robot}/can{plugged.bus.number}", session=session, clock=clock)
            with closing(bus):
                yield bus, f"CAN bus {plugged.bus.number} of the stack at {endpoint}"
        finally:
            disconnect(session)


@contextmanager
def closing(bus: FrameBus) -> Iterator[None]:
    """Shut the bus down at the end."""
    try:
        yield
    finally:
        bus.shutdown()


def found_out(stack: str, channel: str) -> str:
    """The transport where the user names none: that of the running stack.

    Raises:
        ServiceError: no stack is up, and the interface is not.
    """
    used = {record.name: record.can for record in running()}.get(stack)
    if used == "zenoh":
        return used
    if interfaces_up((channel,)):
        return "socketcan"
    if used is not None:
        return "zenoh"
    raise ServiceError(
        f"{channel} is not up on this machine (ulna can up makes virtual interfaces), "
        f"and no stack {stack!r} is up whose CAN over Zenoh could be joined"
    )


def check_address(plugged: Plugged, bus: FrameBus, clock: RealClock) -> None:
    """Listen for a moment before we talk.

    Raises:
        AddressTakenError: another board sends with this address.
    """
    give_up_ns = clock.now_ns() + LISTEN_NS
    while clock.now_ns() < give_up_ns:
        clock.sleep_until(clock.now_ns() + NS_PER_MS)
        taken = senders(bus.receive_frames()) & set(plugged.addresses)
        if taken:
            raise AddressTakenError(
                f"somebody else sends as address {min(taken)} on bus {plugged.bus.number}: start "
                f"the stack with a site file in which {plugged.name} is not simulated"
            )


def senders(frames: Sequence[Received]) -> set[int]:
    """Addresses of boards that sent something; the host's virtual torque sensors are none."""
    return {source_of(can_id) for can_id, _, _ in frames if class_of(can_id) != CLASS_MANAGEMENT}
