"""A robot of which some board is not emulated by the stack: rig and HAL, a millisecond at a time.

The missing board is plugged into the same bus from a rig of its own, and pulled again. In virtual
time over memory buses, or by the wall clock over SocketCAN.
"""

from collections.abc import Callable

import msgspec

from firmware_sim.rig import Rig
from hal.buses.bus import TupleBus
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.buses.socketcan import SocketCanBus
from hal.readings import BoardReport
from hal.robot import Robot
from services.config import load_robot
from services.core.clock import NS_PER_MS, RealClock, VirtualClock
from services.core.paced import PacedClock
from services.emulated.board_process import PluggedBoard
from services.emulated.emulation import rig_spec
from services.emulated.plug import Place, plugged
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import robot_description


def without(reference: str, board: str) -> RobotFile:
    """A robot of which one board is real."""
    robot = load_robot(reference)
    real = msgspec.structs.replace(robot.boards[board], simulated=False)
    return msgspec.structs.replace(robot, boards={**robot.boards, board: real})


class Mixed:
    """Emulated boards, HAL, and at times the one board that they lack."""

    def __init__(self, robot: RobotFile, *, on_vcan: bool = False) -> None:
        self.file = robot
        host = RealClock()
        self.clock = PacedClock(host) if on_vcan else VirtualClock()
        network = MemoryNetwork(self.clock)

        def open_bus(channel: str) -> TupleBus:
            return SocketCanBus(channel, host) if on_vcan else MemoryBus(network, channel)

        self.open_bus = open_bus
        self.rig = Rig(rig_spec(robot, seed=0))
        self.board_buses, self.hal_buses = self._buses(), self._buses()
        self.hal = Robot(robot_description(robot), self.hal_buses)
        self.plugged: PluggedBoard | None = None
        self.said: list[str] = []
        self._plug_bus: TupleBus | None = None

    def _buses(self) -> dict[int, TupleBus]:
        return {bus.number: self.open_bus(bus.channel) for bus in self.file.buses.values()}

    @property
    def now_ns(self) -> int:
        return self.clock.now_ns()

    def tick(self, milliseconds: int = 1) -> None:
        for _ in range(milliseconds):
            self.tick_boards()
            self.hal.step(self.now_ns)

    def tick_boards(self) -> None:
        """A millisecond without the HAL."""
        self.clock.advance_ns(NS_PER_MS)
        if self.plugged is not None:
            self.said += self.plugged.step()
        received = {number: bus.receive_frames() for number, bus in self.board_buses.items()}
        for number, frames in self.rig.step(received).items():
            if frames:
                self.board_buses[number].send_frames(frames)

    def until(self, done: Callable[[], bool], limit_ms: int) -> int:
        """Milliseconds until something holds."""
        for passed in range(limit_ms):
            if done():
                return passed
            self.tick()
        raise AssertionError(f"not after {limit_ms} ms: {self.hal.status().faults}")

    def open(self) -> None:
        """Until the HAL has started, with or without the board."""
        self.until(lambda: self.hal.phase in ("idle", "failed"), 5000)
        assert self.hal.phase == "idle", self.hal.status().faults

    def plug(self, bus: str, address: int, firmware: str = "") -> None:
        chosen = plugged(self.file, Place(bus=bus, address=address, firmware=firmware))
        self._plug_bus = self.open_bus(chosen.bus.channel)
        self.plugged = PluggedBoard(chosen, self._plug_bus)

    def pull(self) -> None:
        assert self._plug_bus is not None
        self._plug_bus.shutdown()
        self.plugged = self._plug_bus = None

    def ask(self, action: str, joints: tuple[str, ...], **options: object) -> None:
        """A request to the HAL that ends well."""
        task = self.hal.request(action, joints, **options)  # type: ignore[arg-type]  # passed on
        self.until(lambda: task.done, 30_000)
        assert task.ok, task.reason

    def report(self, board: str) -> BoardReport:
        return next(each for each in self.hal.status().boards if each.name == board)

    def plant_rad(self, joint: str) -> float:
        return self.rig.q_rad[self.rig.joints.index(joint)]

    def hal_rad(self, joint: str) -> float:
        return self.hal.joints.q_rad[self.hal.joint_index(joint)]

    def close(self) -> None:
        for bus in (*self.board_buses.values(), *self.hal_buses.values()):
            bus.shutdown()
        if self.plugged is not None:
            self.pull()
