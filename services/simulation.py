"""The whole robot in one process and in virtual time.

Emulated boards, memory buses, every service of the stack.
"""

from collections.abc import Callable, Mapping

from firmware_sim.rig import Rig
from hal.buses.memory import MemoryBus, MemoryNetwork
from services.boards import Boards
from services.cartesian import Cartesian
from services.core.clock import NS_PER_MS, VirtualClock
from services.core.service import Service
from services.core.virtual import VirtualExecutor
from services.dynamics import Dynamics
from services.emulation import rig_spec
from services.field import Field
from services.guard import GuardService
from services.ik import Ik
from services.robot import Rates, RobotService
from services.robot_tables import RobotFile


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
    ) -> None:
        """Build everything.

        Args:
            robot: the robot file.
            seed: draws plant masses and levers, sensor noise and offset.
            hop_ticks: what one hop between two processes costs, in ms.
            guests: services beside the stack.
            wrapped: puts something around each service, for experiments that break one.
            replaced: services that take the place of the stack's own, by process name.
        """
        self.clock = VirtualClock()
        self.network = MemoryNetwork(self.clock, hop_ticks * NS_PER_MS)
        self._opened: list[MemoryBus] = []
        self.rig = Rig(rig_spec(robot, seed))
        stack: dict[str, Service] = {
            "boards": Boards(self.rig, self._buses(robot), robot.rates["plant_truth"].virtual_hz),
            "robot": RobotService(robot, self._buses(robot), Rates.virtual(robot)),
            "guard": GuardService(robot, self._buses(robot)),
            "dynamics": Dynamics(robot),
            "ik": Ik(robot),
            "cartesian": Cartesian(robot),
            "field": Field(),
        }
        stack.update(replaced or {})
        stack.update(guests or {})
        self.services = stack
        wrapped = wrapped or _as_it_is
        run = {name: wrapped(name, service) for name, service in stack.items()}
        self.executor = VirtualExecutor(self.clock, run, hop_ticks)

    def close(self) -> None:
        """Every service sends its safe command; the buses are closed."""
        self.executor.close()
        for bus in self._opened:
            bus.shutdown()

    def _buses(self, robot: RobotFile) -> dict[int, MemoryBus]:
        """A handle of its own on every bus, for one process."""
        handles = {b.number: MemoryBus(self.network, b.channel) for b in robot.buses.values()}
        self._opened += handles.values()
        return handles


def _as_it_is(name: str, service: Service) -> Service:  # noqa: ARG001
    return service
