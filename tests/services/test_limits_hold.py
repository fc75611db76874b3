"""Nothing that is sent through the HAL makes a joint of the emulated robot pass a limit."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from firmware_sim.rig import Rig
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.robot import Robot
from services.core.clock import NS_PER_MS, VirtualClock
from services.emulated.emulation import rig_spec
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import joint_limits_deg, robot_description

TOLERANCE_DEG = 0.2


@dataclass
class Bench:
    """The HAL and the emulated boards on memory buses; nothing between a test and the HAL."""

    robot: RobotFile
    clock: VirtualClock
    rig: Rig
    buses: dict[int, MemoryBus]
    hal: Robot

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            received = {number: bus.receive_frames() for number, bus in self.buses.items()}
            for number, frames in self.rig.step(received).items():
                self.buses[number].send_frames(frames)
            self.hal.step(self.clock.now_ns())
            self.clock.advance_ns(NS_PER_MS)

    def do(self, action: str, value: str = "", q_rad: tuple[float, ...] = ()) -> None:
        task = self.hal.request(action, self.robot.chain, value, q_rad, 2.0)
        while not task.done:
            self.tick()
        assert task.ok, task.reason

    def outside_deg(self) -> float:
        limits = np.array([joint_limits_deg(self.robot, name) for name in self.robot.chain])
        q = np.degrees(self.rig.q_rad)
        return float(np.maximum(limits[:, 0] - q, q - limits[:, 1]).max())


@pytest.fixture
def bench(robot: RobotFile) -> Iterator[Bench]:
    clock = VirtualClock()
    network = MemoryNetwork(clock)
    boards, host = (
        {bus.number: MemoryBus(network, bus.channel) for bus in robot.buses.values()}
        for _ in range(2)
    )
    hal = Robot(robot_description(robot), host)
    bench = Bench(robot, clock, Rig(rig_spec(robot, 0)), boards, hal)
    while hal.phase != "idle":
        bench.tick()
    bench.do("calibrate")
    bench.do("move", q_rad=tuple(np.radians(robot.reach.home_deg).tolist()))
    yield bench
    for bus in (*boards.values(), *host.values()):
        bus.shutdown()


@pytest.mark.parametrize("upper", [True, False])
def test_set_points_beyond_every_limit(bench: Bench, upper: bool) -> None:
    bench.do("mode", "direct")
    joints = range(len(bench.robot.chain))
    far = (3.0 if upper else -3.0,) * len(joints)
    outside = []
    for _ in range(600):
        assert bench.hal.set_positions(joints, far)
        bench.tick(10)
        outside.append(bench.outside_deg())
    assert max(outside) <= TOLERANCE_DEG
    assert outside[-1] > -1.0  # they did go there
    assert bench.rig.limit_violations == 0


@pytest.mark.parametrize("upper", [True, False])
def test_velocities_into_every_limit(bench: Bench, upper: bool) -> None:
    bench.do("mode", "velocity")
    joints = range(len(bench.robot.chain))
    fast = (2.0 if upper else -2.0,) * len(joints)
    outside = []
    for _ in range(600):
        assert bench.hal.set_velocities(joints, fast)
        bench.tick(10)
        outside.append(bench.outside_deg())
    assert max(outside) <= TOLERANCE_DEG
    assert outside[-1] > -3.0
    assert bench.rig.limit_violations == 0


def test_moves_to_beyond_every_limit(bench: Bench) -> None:
    task = bench.hal.request("move", bench.robot.chain, "", (3.0,) * 10, 1.0)
    outside = []
    for _ in range(800):
        bench.tick(10)
        outside.append(bench.outside_deg())
    assert task.done
    assert max(outside) <= TOLERANCE_DEG
