"""A robot whose boards are the emulated ones, each axis turning as fast as its PWM says.

The plant is a first-order one on purpose: it needs no model, and these tests are about frames.
"""

import math
from dataclasses import dataclass

from msgspec.structs import replace

from firmware_sim.description import AxisSpec, BoardSpec, SensorSpec
from firmware_sim.network import Network
from hal.buses.memory import MemoryBus, MemoryNetwork
from hal.description import Calibration, PositionPid, RobotDescription
from hal.guarding import Guard
from hal.robot import Robot
from hal.tasks import Task
from tests.hal.arm import BUS, DESCRIPTION, TORQUE_PID
from tests.hal.scripted import MS

PROSUP_PID = PositionPid(kp=-200, ki=-1, kd=-1000, shift=6, integral_limit=1333, output_limit=1333)
WRIST_PID = PositionPid(kp=-1000, ki=-1, kd=-10000, shift=7, integral_limit=1333, output_limit=1333)

UPRIGHT_TORQUE_PID = replace(TORQUE_PID, kp=76)

JOINTS = (
    replace(
        DESCRIPTION.joints[0],
        torque_pid=UPRIGHT_TORQUE_PID,
        calibration=Calibration(type=3, p1=1706.25, p2=100, p3=348.075, startup_pwm=120),
    ),
    replace(
        DESCRIPTION.joints[1],
        torque_pid=UPRIGHT_TORQUE_PID,
        calibration=Calibration(type=3, p1=853.13, p2=100, p3=2.275, startup_pwm=120),
    ),
    replace(DESCRIPTION.joints[2], position_pid=PROSUP_PID, current_limit_ma=1000, pwm_limit=1333),
    replace(
        DESCRIPTION.joints[3],
        position_pid=WRIST_PID,
        current_limit_ma=800,
        pwm_limit=1333,
        calibration=Calibration(type=3, p1=2047.5, p2=100, p3=1057.875, startup_pwm=1333, order=1),
    ),
)
EMULATED = replace(DESCRIPTION, joints=JOINTS)

HOME = [math.radians(angle) for angle in (-30.0, 30.0, 0.0, 0.0)]
START_DEG = (-33.0, 33.0, 72.0, 3.0)
SPEED_DEG_S = (0.5, 0.5, 0.02, 0.1)  # per PWM count
HARD_STOP_DEG = ((-100.0, 15.0), (-5.0, 166.0), (-74.0, 74.0), (-30.0, 30.0))


@dataclass
class Watch:
    """The time of a bench."""

    ns: int = 0

    def now_ns(self) -> int:
        return self.ns


class Bench:
    """A Robot, emulated boards and what turns their axes."""

    def __init__(self, description: RobotDescription = EMULATED) -> None:
        self.watch = Watch()
        self.memory = MemoryNetwork(self.watch)
        self.buses = [MemoryBus(self.memory, "arm") for _ in range(3)]
        sensor = description.sensors[0]
        self.boards = Network(
            [
                BoardSpec(
                    bus=b.bus, address=b.address, type=b.type, firmware=b.firmware, coupled=False
                )
                for b in description.boards
            ],
            [
                SensorSpec(
                    name=sensor.name,
                    frame=sensor.frame,
                    bus=sensor.bus,
                    address=sensor.address,
                    full_scale=sensor.full_scale,
                )
            ],
        )
        self.strain = self.boards.board(BUS, sensor.address)
        self.axes = [
            self.boards.axis(
                AxisSpec(bus=j.bus, address=j.address, axis=j.axis, joint=None, motor=None)
            )
            for j in description.joints
        ]
        self.description = description
        self.angles_deg = list(START_DEG)
        self._show()
        for board in description.boards:
            self.boards.board(BUS, board.address).power_cycle()
        self.robot = Robot(description, {BUS: self.buses[1]})
        self.fed = True  # joint torques of zero are sent each millisecond
        self.running = True  # the host is stepped

    @property
    def now_ns(self) -> int:
        return self.watch.ns

    def tick(self, count: int = 1) -> None:
        """Pass milliseconds."""
        for _ in range(count):
            self.watch.ns += MS
            self.boards.deliver({BUS: self.buses[0].receive_frames()})
            self._move()
            self.strain.raw_adc[:] = [0x8000 + self.watch.ns // MS % 2, *[0x8000] * 5]
            for frames in self.boards.tick().values():
                self.buses[0].send_frames(frames)
            if self.running:
                if self.fed:
                    self.robot.set_joint_torques([0, 1], [0.0, 0.0], self.now_ns)
                self.robot.step(self.now_ns)

    def finish(self, task: Task, limit_ms: int = 20_000) -> None:
        """Pass milliseconds until a task has ended."""
        for _ in range(limit_ms):
            if task.done:
                return
            self.tick()
        raise AssertionError(f"{task.action} not done after {limit_ms} ms")

    def open(self) -> None:
        """Pass the start-up."""
        for _ in range(2000):
            if self.robot.phase in ("idle", "failed"):
                return
            self.tick()
        raise AssertionError(self.robot.phase)

    def calibrated(self) -> None:
        """Pass start-up and calibration."""
        self.open()
        task = self.robot.request("calibrate")
        self.finish(task)
        assert task.ok, task.reason

    def compliant(self, *joints: str) -> None:
        """Switch joints to direct mode and make them compliant."""
        self.finish(self.robot.request("mode", joints, "direct"))
        task = self.robot.request("interaction", joints, "compliant")
        self.finish(task)
        assert task.ok, task.reason

    def guard(self) -> Guard:
        """A guard with a bus handle of its own."""
        return Guard(self.description, {BUS: self.buses[2]})

    def close(self) -> None:
        """Leave the bus."""
        for bus in self.buses:
            bus.shutdown()

    def _move(self) -> None:
        for i, axis in enumerate(self.axes):
            if axis.port.enabled:
                low, high = HARD_STOP_DEG[i]
                moved = self.angles_deg[i] + axis.port.pwm * SPEED_DEG_S[i] / 1000.0
                self.angles_deg[i] = min(max(moved, low), high)
        self._show()

    def _show(self) -> None:
        """Turn the encoders."""
        for axis, one, start, angle in zip(
            self.axes, self.description.joints, START_DEG, self.angles_deg, strict=True
        ):
            if one.calibration.type == 3:
                ticks = math.floor((angle + one.zero_deg) * one.ticks_per_deg)
                axis.port.raw_encoder = ticks + round(one.calibration.p3) & 0xFFF
            else:
                axis.port.raw_encoder = math.floor((angle - start) * one.ticks_per_deg)
