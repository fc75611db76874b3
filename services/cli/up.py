"""`ulna up`: start the processes of the stack, watch them, and bring them down in the safe way."""

import signal
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Annotated, Literal

import cyclopts

from hal.buses.socketcan import interfaces_up
from hal.errors import HalError
from services.board_news import BoardNews
from services.cli.complaint import complain
from services.config import load_robot
from services.core.child import Child
from services.core.client import Client
from services.core.clock import NS_PER_S, RealClock
from services.core.errors import ConfigError, NotReadyError, ProcessDiedError, ServiceError
from services.core.live import GRACE_S, robot_name
from services.core.rundir import Claim
from services.core.stopping import LimbStop, StopRequests
from services.processes import DEFAULT_ROBOT, HUB, PROCESSES, STAGES, Process, stage_of
from services.robotfile.robot_tables import RobotFile
from services.streams import ROBOT_STATUS

LOOK_EVERY_NS = 20_000_000
HUB_START_S = 30.0  # of imports, on a slow and busy machine
READY_S = 180.0  # with compiled code made anew, the field takes a minute on a slow core
FORCE_AFTER_S = GRACE_S + 1.0
LAST_TO_STOP = ("boards", HUB.name)  # the others speak to them until their own end

Can = Literal["zenoh", "socketcan", "mixed"]
StackName = Annotated[str, cyclopts.Parameter(alias="--name")]  # as it was called at first


class Stack:
    """The running processes of one robot. Use it as a context manager, in the main thread.

    Entering returns when all processes are at work; leaving brings the limbs down and ends all
    processes. Call check() now and then in between.
    """

    def __init__(
        self,
        robot: str = DEFAULT_ROBOT,
        *,
        can: Can = "zenoh",
        seed: int = 0,
        name: str = "",
        rows: Sequence[Process] = PROCESSES,
        report: Callable[[str], None] | None = None,
    ) -> None:
        """`name` tells stacks of one robot apart; by default it is the robot's."""
        self.endpoint = ""
        self._robot = robot
        self._can = can
        self._seed = seed
        self._name = name or robot_name(robot)
        self._rows = rows
        self._report = report or _silent
        self._clock = RealClock()
        self._children: dict[str, Child] = {}
        self._ready: set[str] = set()
        self._claim: Claim | None = None
        self._client: Client | None = None

    def __enter__(self) -> "Stack":
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def client(self) -> Client:
        """A client of this stack."""
        if self._client is None:
            raise ServiceError(f"the stack {self._name!r} is not up")
        return self._client

    @property
    def pids(self) -> dict[str, int]:
        """Process numbers by name."""
        return {name: child.pid for name, child in self._children.items()}

    def start(self) -> None:
        """Start everything and wait until it is at work; a failed start leaves nothing behind.

        Raises:
            AlreadyRunningError: a stack of that name is up.
            ProcessDiedError: a process ended before it was ready.
            NotReadyError: a process did not get ready in time.
        """
        complete = False
        self._claim = Claim(self._name, robot_name(self._robot), self._robot)
        try:
            self._start_hub(self._claim)
            for stage in range(STAGES):
                for row in self._rows:
                    if row.name != HUB.name and stage_of(row) == stage:
                        self._children[row.name] = self._start_child(row, self._claim)
                self._wait_ready()
            complete = True
        finally:
            if not complete:
                self.stop()

    def check(self) -> None:
        """Raise ProcessDiedError, naming the process and how it ended, once one has ended."""
        for child in self._children.values():
            if child.ended():
                raise child.death()

    def wait(self, look: Callable[[], None] | None = None) -> None:
        """Watch until a process ends, which raises ProcessDiedError, or somebody interrupts.

        `look` is called each time that the processes were looked at.
        """
        while True:
            self.check()
            if look is not None:
                look()
            self._clock.sleep_until(self._clock.now_ns() + LOOK_EVERY_NS)

    def stop(self) -> None:
        """Bring the limbs down, end all processes, give the name back; Ctrl-C only hastens it."""
        with StopRequests() as presses:
            try:
                if self._client is not None and self._can_move():
                    LimbStop(self._client, self._clock, self._is_dead, self._report).run(presses)
            finally:
                self._end_processes()

    def _can_move(self) -> bool:
        """Whether anybody is left who could bring limbs down that are really there."""
        if "robot" not in self._children:
            return False
        if self._is_dead(HUB.name):
            self._report("the hub is gone: robot and guard idle the boards as they end")
            return False
        return not ("boards" in self._children and self._is_dead("boards"))

    def _is_dead(self, name: str) -> bool:
        child = self._children.get(name)
        return child is None or child.ended()

    def _start_hub(self, claim: Claim) -> None:
        hub = Child(
            HUB.name,
            HUB.module,
            ("--robot", self._robot),
            claim.logs / f"{HUB.name}.log",
            speaks=True,
        )
        self._children[HUB.name] = hub
        self.endpoint = hub.first_line(HUB_START_S)
        claim.publish(self.endpoint, self._can)
        self._client = Client(robot_name(self._robot), self.endpoint, self._clock)

    def _start_child(self, row: Process, claim: Claim) -> Child:
        arguments = ["--robot", self._robot, "--name", self._name, "--hub", self.endpoint]
        arguments += ["--can", self._can, "--seed", str(self._seed)]
        return Child(row.name, row.module, arguments, claim.logs / f"{row.name}.log")

    def _wait_ready(self) -> None:
        give_up_ns = self._clock.now_ns() + round(READY_S * NS_PER_S)
        known = self._ready
        while missing := set(self._children) - known:
            self.check()
            if self._clock.now_ns() > give_up_ns:
                raise NotReadyError(f"not at work after {READY_S:g} s: {sorted(missing)}")
            self._clock.sleep_until(self._clock.now_ns() + LOOK_EVERY_NS)
            alive = self.client.alive() & set(self._children)
            for name in sorted(alive - known):
                self._report(f"{name} is at work")
            known |= alive

    def _end_processes(self) -> None:
        """First those that speak to boards and hub, then these; each group at the same time."""
        if self._client is not None:
            self._client.close()
            self._client = None
        groups = [[name for name in self._children if name not in LAST_TO_STOP]]
        groups += [[name] for name in LAST_TO_STOP if name in self._children]
        for group in groups:
            running = [name for name in group if not self._children[name].ended()]
            for name in running:
                self._children[name].terminate()
            for name in group:
                self._children[name].finish(self._clock, FORCE_AFTER_S)
            for name in running:
                if self._children[name].failed:
                    self._report(f"{name} did not stop well: {self._children[name].status()}")
        self._children.clear()
        self._ready.clear()
        if self._claim is not None:
            self._claim.release()
            self._claim = None


def up(
    robot: str = DEFAULT_ROBOT, *, can: Can | None = None, seed: int = 0, stack: StackName = ""
) -> int:
    """Start the stack, watch it, and stop it with Ctrl-C.

    Ctrl-C brings the limbs down and idles them; a second one idles them at once.

    Args:
        robot: name[:parts][@site] of a robot in robots/, or a robot file.
        can: what carries the CAN frames; mixed is socketcan on the interfaces that are up and zenoh
            on the others [socketcan where all are up, mixed where real boards are on those that
            are, else zenoh].
        seed: of the emulated robot's random draws.
        stack: its name, by which the other verbs find it; tells stacks of one robot apart [the
            robot's].

    Returns:
        Exit status: 0 stopped by the user, 1 a process died, 2 could not start.
    """
    try:
        robot_file = load_robot(robot)
        interfaces = tuple(bus.channel for bus in robot_file.buses.values())
        chosen, reason = choose_can(can, interfaces, real_interfaces(robot_file))
        print(f"CAN over {chosen}: {reason}", flush=True)
        rows = rows_for(robot_file)
        running = Stack(robot, can=chosen, seed=seed, name=stack, rows=rows, report=_say)
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.default_int_handler)  # a stop like Ctrl-C
        with running:
            print(f"up, hub at {running.endpoint}; Ctrl-C stops", flush=True)
            running.wait(_board_news(running))
    except KeyboardInterrupt:
        print("stopped", flush=True)
        return 0
    except ProcessDiedError as error:
        complain(f"{error}; the end of its log:\n{error.log_tail}")
        return 1
    except (ServiceError, HalError) as error:
        complain(error)
        return 2
    return 0


def _board_news(stack: Stack) -> Callable[[], None]:
    """What prints a line when a board's state changes."""
    news = BoardNews()

    def look() -> None:
        for status in stack.client.new(ROBOT_STATUS):
            for line in news.lines(status):
                _say(line)

    return look


def choose_can(
    asked: Can | None, interfaces: Sequence[str], real: Sequence[str] = ()
) -> tuple[Can, str]:
    """The transport of a live stack, and why; `real` are the interfaces that have real boards.

    Raises:
        ConfigError: SocketCAN is asked for, and an interface is not up.
    """
    names = ", ".join(interfaces)
    if asked == "socketcan" and not interfaces_up(interfaces):
        raise ConfigError(
            f"--can socketcan: not all of {names} are up; ulna can up makes virtual ones, "
            "--can zenoh needs none"
        )
    if asked is not None:
        return asked, "as asked for"
    if interfaces_up(interfaces):
        return "socketcan", f"the interfaces are up: {names}"
    there = [name for name in real if interfaces_up((name,))]
    if there:
        return (
            "mixed",
            f"real boards are on {', '.join(there)}; the others over zenoh",
        )
    return "zenoh", f"the interfaces are not all up here: {names} (ulna can up makes virtual ones)"


def real_interfaces(robot: RobotFile) -> tuple[str, ...]:
    """Interfaces of the buses that have boards which are not emulated."""
    real = {board.bus for name, board in robot.boards.items() if not robot.is_simulated(name)}
    return tuple(bus.channel for name, bus in robot.buses.items() if name in real)


def rows_for(robot: RobotFile) -> tuple[Process, ...]:
    """The processes to start: boards where some are emulated, controllers where a limb is."""
    emulated = any(robot.is_simulated(board) for board in robot.boards)
    return tuple(
        row
        for row in PROCESSES
        if (emulated or not row.emulated_only)
        and (robot.limbs or not row.reaches)
        and (robot.sensors or not row.feels)
    )


def _silent(text: str) -> None:
    """Report nothing."""


def _say(text: str) -> None:
    print(text, flush=True)
