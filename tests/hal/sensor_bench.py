"""A robot of nothing but sensor boards, all of them emulated, and a third party on its bus."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.description import BoardSpec, SensorSpec
from firmware_sim.network import Network
from hal.boards.board import HostBoard
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.description import Board, ForceTorqueSensor, RobotDescription
from hal.robot import Robot
from hal.wire.can import Received
from tests.hal.emulated import Watch
from tests.hal.scripted import MS, frame

BUS = 1
FULL_SCALE = (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0)

Sample = TypeVar("Sample")

ADDRESSES = {"strain": 13, "strain2": 10, "mais": 14, "mtb": 12, "imu": 11}
FIRMWARE = {
    "strain": (3, 0),
    "strain2": (1, 0),
    "mais": (3, 1),
    "mtb": (2, 0x11),
    "imu": (1, 0),
}
SENSORS = tuple(
    ForceTorqueSensor(
        name=f"{name}_ft", frame=name, bus=BUS, address=ADDRESSES[name], full_scale=FULL_SCALE
    )
    for name in ("strain", "strain2")
)


BOARDS = {
    name: Board(
        name=name,
        bus=BUS,
        address=address,
        type=name,
        firmware=FIRMWARE[name],
        broadcast=(),
        frame="l_hand" if name == "mtb" else "",
    )
    for name, address in ADDRESSES.items()
}
"""One board of each type, named as its type."""


def described(boards: Mapping[str, Board] = BOARDS) -> RobotDescription:
    """A robot of these boards."""
    return RobotDescription(
        name="senses", boards=tuple(boards.values()), joints=(), sensors=SENSORS
    )


class SensorBench:
    """The robot, its boards and their time."""

    def __init__(self, description: RobotDescription | None = None) -> None:
        self.description = description or described()
        self.watch = Watch()
        memory = MemoryNetwork(self.watch)
        self._boards_bus, self._host_bus, self._third = (MemoryBus(memory, "bus") for _ in range(3))
        self.network = Network(
            [
                BoardSpec(bus=b.bus, address=b.address, type=b.type, firmware=b.firmware)
                for b in self.description.boards
            ],
            [
                SensorSpec(
                    name=s.name, frame=s.frame, bus=BUS, address=s.address, full_scale=FULL_SCALE
                )
                for s in SENSORS
            ],
        )
        self.robot = Robot(self.description, {BUS: self._host_bus})
        self.heard: list[Received] = []  # in the last millisecond
        self.noise: Callable[[int], int] = lambda ms: ms & 1

    def emulated(self, name: str) -> SensorBoard:
        """The emulated board of a type."""
        board: object = self.network.board(BUS, ADDRESSES[name])
        assert isinstance(board, SensorBoard)
        return board

    def host(self, name: str) -> HostBoard:
        """The host side of a board."""
        return next(b for b in self.robot._machine.boards if b.board.name == name)

    def tick(self, count: int = 1) -> None:
        """Pass milliseconds."""
        for _ in range(count):
            self.run_boards(1)
            self.robot.step(self.watch.ns)

    def run_boards(self, count: int) -> None:
        """Pass milliseconds without the robot's host; gauges are never still."""
        for _ in range(count):
            self.watch.ns += MS
            self.network.deliver({BUS: self._boards_bus.receive_frames()})
            word = 0x8000 + self.noise(self.watch.ns // MS)
            for name in ("strain", "strain2"):
                self.emulated(name).raw_adc[:] = [word] * 6
            for frames in self.network.tick().values():
                self._boards_bus.send_frames(frames)
            self.heard = self._third.receive_frames()

    def hear_nothing_of_it(self) -> None:
        """Throw away what waits for the robot's host: it was not there yet."""
        self._host_bus.receive_frames()

    def say(self, *frames: str) -> None:
        """Somebody sends frames of that identifier and content."""
        self._third.send_frames([frame(said) for said in frames])

    def open(self) -> "SensorBench":
        """Pass the start-up."""
        for _ in range(12_000):
            if self.robot.phase in ("idle", "failed"):
                return self
            self.tick()
        raise AssertionError(self.robot.phase)

    def take(self, name: str, kind: type[Sample]) -> list[Sample]:
        """New samples of a kind."""
        return self.robot.take_samples(name, kind)

    def close(self) -> None:
        """Leave the bus."""
        for bus in (self._boards_bus, self._host_bus, self._third):
            bus.shutdown()

    @property
    def faults(self) -> tuple[str, ...]:
        """Texts so far."""
        return self.robot.status().faults

    @property
    def drops(self) -> dict[str, int]:
        """Counts so far."""
        return dict(self.robot.status().drops)
