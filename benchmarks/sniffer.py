"""Listens to the buses of a whole robot beside its HAL: when each board was last heard."""

from collections.abc import Mapping

from benchmarks.whole_robot import WholeRobot
from hal.buses.memory import MemoryBus
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_INERTIAL_PERIODIC,
    CLASS_MOTOR_PERIODIC,
    CLASS_SKIN_PERIODIC,
)

STREAMS = frozenset(
    (
        CLASS_MOTOR_PERIODIC,
        CLASS_ANALOG_PERIODIC,
        CLASS_SKIN_PERIODIC,
        CLASS_INERTIAL_PERIODIC,
    )
)
NS_PER_MS = 1_000_000


class Sniffer:
    """`look` once per millisecond; `take` gives the longest gap of each board since the last."""

    def __init__(self, robot: WholeRobot, boards: Mapping[tuple[int, int], str]) -> None:
        """`boards`: name by bus and address."""
        self._buses = {
            number: MemoryBus(robot.network, bus.channel) for number, bus in robot.hal_buses.items()
        }
        self._boards = dict(boards)
        self.heard_ns = dict.fromkeys(self._boards.values(), robot.now_ns)
        self._longest_ns = dict.fromkeys(self._boards.values(), 0)

    def look(self) -> None:
        """Take what has arrived."""
        boards, heard, longest = self._boards, self.heard_ns, self._longest_ns
        for number, bus in self._buses.items():
            for can_id, _, stamp_ns in bus.receive_frames():
                if can_id >> 8 in STREAMS:
                    name = boards.get((number, can_id >> 4 & 0xF))
                    if name is not None:
                        gap_ns = stamp_ns - heard[name]
                        heard[name] = stamp_ns
                        if gap_ns > longest[name]:
                            longest[name] = gap_ns

    def take(self) -> dict[str, float]:
        """Longest gap of each board, milliseconds."""
        taken = {name: gap_ns / NS_PER_MS for name, gap_ns in self._longest_ns.items()}
        self._longest_ns = dict.fromkeys(taken, 0)
        return taken

    def close(self) -> None:
        """Leave the buses."""
        for bus in self._buses.values():
            bus.shutdown()
