"""Emulated boards, plant and HAL on memory buses, without services: for benchmarks and tests."""

from collections.abc import Callable

from firmware_sim.rig import Rig
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.robot import Robot
from hal.tasks import Task
from services.config import load_robot
from services.core.clock import NS_PER_MS, VirtualClock
from services.emulated.emulation import rig_spec
from services.robotfile.wiring import robot_description

STARTUP_MS = 20_000


class WholeRobot:
    """One robot in virtual time; `tick` passes a millisecond on both sides of the buses."""

    def __init__(self, reference: str = "icub", seed: int = 0) -> None:
        """`reference` as for services.config.load_robot."""
        self.file = load_robot(reference)
        self.clock = VirtualClock()
        self.network = MemoryNetwork(self.clock)
        numbered = {bus.number: bus.channel for bus in self.file.buses.values()}
        self.board_buses = {n: MemoryBus(self.network, name) for n, name in numbered.items()}
        self.hal_buses = {n: MemoryBus(self.network, name) for n, name in numbered.items()}
        self.rig = Rig(rig_spec(self.file, seed))
        self.hal = Robot(robot_description(self.file), self.hal_buses)
        self.frames = 0  # that the boards have sent

    @property
    def now_ns(self) -> int:
        """Virtual time."""
        return self.clock.now_ns()

    def tick_boards(self) -> None:
        """A millisecond of boards and plant."""
        self.clock.advance_ns(NS_PER_MS)
        received = {number: bus.receive_frames() for number, bus in self.board_buses.items()}
        for number, frames in self.rig.step(received).items():
            if frames:
                self.board_buses[number].send_frames(frames)
                self.frames += len(frames)

    def tick(self, milliseconds: int = 1) -> None:
        """Milliseconds of boards, plant and HAL."""
        for _ in range(milliseconds):
            self.tick_boards()
            self.hal.step(self.now_ns)

    def until(self, done: Callable[[], bool], limit_ms: int = STARTUP_MS) -> int:
        """Pass time until something holds; the milliseconds that it took.

        Raises:
            TimeoutError: it never did.
        """
        for passed in range(limit_ms):
            if done():
                return passed
            self.tick()
        raise TimeoutError(f"not after {limit_ms} ms: {self.hal.status().faults}")

    def open(self) -> int:
        """Pass the HAL's start-up; the milliseconds that it took."""
        passed = self.until(lambda: self.hal.phase in ("idle", "failed"))
        if self.hal.phase == "failed":
            raise TimeoutError(f"start-up failed: {self.hal.status().faults}")
        return passed

    def finish(self, task: Task, limit_ms: int = 60_000) -> int:
        """Pass time until a task has ended well."""
        passed = self.until(lambda: task.done, limit_ms)
        if not task.ok:
            raise TimeoutError(f"{task.action}: {task.reason}")
        return passed

    def calibrated(self) -> None:
        """Pass start-up and the calibration of every axis."""
        self.open()
        self.finish(self.hal.request("calibrate"))

    def close(self) -> None:
        """Leave the buses."""
        for bus in (*self.board_buses.values(), *self.hal_buses.values()):
            bus.shutdown()
