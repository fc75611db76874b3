"""The whole robot in one process: emulated boards, buses, every service of the stack.

In virtual time over memory buses, or by the wall clock over SocketCAN.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from firmware_sim.rig import Rig
from hal.buses.bus import FrameBus, HostClock
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.buses.socketcan import SocketCanBus
from services.boards import Boards
from services.cartesian import Cartesian
from services.core.clock import NS_PER_MS, VirtualClock
from services.core.paced import PacedClock
from services.core.service import Service
from services.core.virtual import VirtualExecutor
from services.dynamics import Dynamics
from services.emulated.emulation import rig_spec
from services.field import Field
from services.guard import GuardService
from services.ik import Ik
from services.learner import Learner
from services.robot import RobotService
from services.robotfile.rates import Rates
from services.robotfile.robot_tables import BusTable, RobotFile
from services.script import ScriptedService

TICKS_PER_REPORT = 100

Progress = Callable[[float, str], None]
"""Is told the seconds that the robot has run, and what it does."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What differs between virtual time and one process that runs by the wall clock."""

    clock: VirtualClock
    open_bus: Callable[[BusTable], FrameBus]
    rates: Rates
    truth_hz: int


def paced_setting(robot: RobotFile, clock: PacedClock, on_bus: HostClock) -> Setting:
    """SocketCAN and the wall clock; `on_bus` stamps the frames."""
    return Setting(
        clock=clock,
        open_bus=lambda bus: SocketCanBus(bus.channel, on_bus),
        rates=Rates.live(robot),
        truth_hz=robot.rates["plant_truth"].live_hz,
    )


class Simulation:
    """Composition and executor.

    Rows in the order of the process table; the guests, such as a job, come last.
    """

    def __init__(
        self,
        robot: RobotFile,
        seed: int = 0,
        hop_ticks: int = 1,
        guests: Mapping[str, Service] | None = None,
        replaced: Mapping[str, Service] | None = None,
        wrapped: Callable[[str, Service], Service] | None = None,
        setting: Setting | None = None,
        learner: bool = False,
    ) -> None:
        """Build everything.

        Args:
            robot: the robot file.
            seed: draws plant masses and levers, sensor noise and offset.
            hop_ticks: what one hop between two processes costs, in ms.
            guests: services beside the stack.
            wrapped: puts something around each service, for experiments that break one.
            replaced: services that take the place of the stack's own, by process name.
            setting: clock, buses and rates; virtual time and memory buses by default.
            learner: whether one learns beside the dynamics; the stack works without it.
        """
        setting = setting or self._virtual(robot, hop_ticks)
        self._setting = setting
        self.clock = setting.clock
        self._opened: list[FrameBus] = []
        self.rig = Rig(rig_spec(robot, seed))
        stack: dict[str, Service] = {
            "boards": Boards(self.rig, self._buses(robot), setting.truth_hz),
            "robot": RobotService(robot, self._buses(robot), setting.rates),
            "guard": GuardService(robot, self._buses(robot)),
        }
        if robot.sensors:
            stack["dynamics"] = Dynamics(robot, setting.rates)
            if learner:
                stack["learner"] = Learner(robot)
        if robot.limbs:
            stack |= {
                "ik": Ik(robot),
                "cartesian": Cartesian(robot),
                "field": Field(robot),
            }
        stack.update(replaced or {})
        stack.update(guests or {})
        self.services = stack
        wrapped = wrapped or _as_it_is
        run = {name: wrapped(name, service) for name, service in stack.items()}
        self.executor = VirtualExecutor(self.clock, run, hop_ticks)

    def run(
        self,
        guest: ScriptedService,
        progress: Progress | None = None,
        longest_ticks: float = math.inf,
        after_tick: Callable[[], None] | None = None,
    ) -> None:
        """Until the guest has finished; `progress` is told ten times a second of the robot."""
        executor = self.executor
        while not guest.finished and executor.ticks < longest_ticks:
            executor.tick()
            if after_tick is not None:
                after_tick()
            if progress is not None and executor.ticks % TICKS_PER_REPORT == 0:
                progress(executor.ticks * 1e-3, guest.progress)

    def close(self) -> None:
        """Every service sends its safe command; the buses are closed."""
        self.executor.close()
        for bus in self._opened:
            bus.shutdown()

    def _virtual(self, robot: RobotFile, hop_ticks: int) -> Setting:
        clock = VirtualClock()
        network = MemoryNetwork(clock, hop_ticks * NS_PER_MS)
        self.network = network  # its switches inject faults
        return Setting(
            clock=clock,
            open_bus=lambda bus: MemoryBus(network, bus.channel),
            rates=Rates.virtual(robot),
            truth_hz=robot.rates["plant_truth"].virtual_hz,
        )

    def _buses(self, robot: RobotFile) -> dict[int, FrameBus]:
        """A handle of its own on every bus, for one service."""
        handles = {bus.number: self._setting.open_bus(bus) for bus in robot.buses.values()}
        self._opened += handles.values()
        return handles


def _as_it_is(name: str, service: Service) -> Service:  # noqa: ARG001
    return service
