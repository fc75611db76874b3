"""Gravity offsets at the HAL's service: those of another time are refused and counted."""

import math
from collections.abc import Iterator

import pytest

from hal.buses.memory import MemoryBus, MemoryNetwork
from services.config import load_robot
from services.core.clock import VirtualClock
from services.core.testing import Bench
from services.messages import ImpedanceOffset
from services.robot import RobotService
from services.robotfile.rates import Rates
from services.streams import IMPEDANCE_OFFSET, ROBOT_STATUS

ARM = IMPEDANCE_OFFSET["right_arm"]
MS = 1_000_000


class Offsets:
    """A robot without boards, a second old, that is sent offsets with whatever stamp."""

    def __init__(self) -> None:
        robot = load_robot("icub:right_arm")
        clock = VirtualClock()
        network = MemoryNetwork(clock)
        self.buses = {bus.number: MemoryBus(network, bus.channel) for bus in robot.buses.values()}
        service = RobotService(robot, self.buses, Rates.virtual(robot), clock.now_ns)
        self.bench = Bench(service, clock)
        self.count = len(robot.parts["right_arm"])
        self.bench.advance(1.0)

    def send(self, age_ms: int, tau_nm: float = 0.0) -> dict[str, int]:
        """One offset for every joint; what has been refused so far, the HAL's own refusals too."""
        stamp_ns = self.bench.clock.now_ns() - age_ms * MS
        self.bench.put(ARM, ImpedanceOffset(stamp_ns=stamp_ns, tau_nm=(tau_nm,) * self.count))
        self.bench.advance(0.03)
        return dict(self.bench.last(ROBOT_STATUS).refusals)


@pytest.fixture
def offsets() -> Iterator[Offsets]:
    offsets = Offsets()
    yield offsets
    for bus in offsets.buses.values():
        bus.shutdown()


def test_offsets_come_in_the_order_of_their_stamps(offsets: Offsets) -> None:
    assert offsets.send(0) == {}
    assert offsets.send(99) == {"impedance offset out of order": 1}  # the other is 30 ms old
    assert offsets.send(20) == {"impedance offset out of order": 1}


def test_an_offset_that_was_taken_reaches_the_hal_and_a_refused_one_does_not(
    offsets: Offsets,
) -> None:
    assert len(offsets.send(150, math.nan)) == 1
    both = offsets.send(0, math.nan)
    assert both.pop("impedance offset too old") == 1
    assert sum(both.values()) == 1


def test_an_offset_from_the_future_shuts_out_no_other(offsets: Offsets) -> None:
    assert offsets.send(-5000) == {"impedance offset from the future": 1}
    assert offsets.send(0) == {"impedance offset from the future": 1}


def test_the_same_offset_twice_is_refused_once(offsets: Offsets) -> None:
    assert offsets.send(0) == {}
    assert offsets.send(30) == {"impedance offset out of order": 1}
