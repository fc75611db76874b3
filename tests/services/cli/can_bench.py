"""Buses of one process and one virtual instant for tests of the `ulna can` verbs."""

from collections.abc import Callable

from hal.buses.memory import MemoryBus, MemoryNetwork
from services.cli.can_buses import Tap
from services.cli.can_names import BusNames
from services.config import load_robot
from services.core.clock import VirtualClock

ROBOT = load_robot("icub")


class Wires:
    """Taps on buses of the robot, and the other end of each: what stands for the boards."""

    def __init__(self, *buses: str) -> None:
        self.clock = VirtualClock()
        network = MemoryNetwork(self.clock, delay_ns=0)
        self.network = network
        self.boards = {name: MemoryBus(network, name) for name in buses}
        self.taps = [
            Tap(ROBOT.buses[name].number, name, MemoryBus(network, name), BusNames(ROBOT, name))
            for name in buses
        ]

    def sends(self, bus: str, *frames: str) -> None:
        """Boards send frames written as 111#38080000C60D0000."""
        self.boards[bus].send_frames([frame_of_text(text) for text in frames])

    def close(self) -> None:
        for tap in self.taps:
            tap.bus.shutdown()
        for bus in self.boards.values():
            bus.shutdown()

    def after(self, milliseconds: int) -> int:
        """An instant in so many ms."""
        return self.clock.now_ns() + milliseconds * 1_000_000


def frame_of_text(text: str) -> tuple[int, bytes]:
    head, _, tail = text.partition("#")
    return int(head, 16), bytes.fromhex(tail)


MakeWires = Callable[..., Wires]
