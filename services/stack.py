"""The running processes of one robot: started, watched, and brought down in the safe way."""

from collections.abc import Callable, Sequence
from types import TracebackType

from services.core.child import Child
from services.core.client import Client
from services.core.clock import NS_PER_S, RealClock
from services.core.errors import NotReadyError, ServiceError
from services.core.live import GRACE_S, robot_name
from services.core.rundir import Claim
from services.core.stopping import LimbStop, StopRequests
from services.processes import DEFAULT_ROBOT, HUB, PROCESSES, STAGES, Process, stage_of
from services.stack_choice import Can

LOOK_EVERY_NS = 20_000_000
HUB_START_S = 30.0  # of imports, on a slow and busy machine
READY_S = 180.0  # with compiled code made anew, the field takes a minute on a slow core
FORCE_AFTER_S = GRACE_S + 1.0
LAST_TO_STOP = ("boards", HUB.name)  # the others speak to them until their own end


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


def _silent(text: str) -> None:
    """Report nothing."""
