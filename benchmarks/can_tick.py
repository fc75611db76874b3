"""What a millisecond of the emulated motor boards costs: control laws, watchdogs, broadcasts.

Boards of the robot on their buses, without plant and sensor boards: every mode runs somewhere, the
encoders move, torque and Hall frames arrive each tenth millisecond, and the broadcasts are those of
a robot. Beside the figures stands the same loop around nothing.
"""

from collections.abc import Callable
from statistics import median

import numpy as np

from firmware_sim.boards.axis_state import Axis
from firmware_sim.description import BoardSpec
from firmware_sim.network import Network
from hal.wire.analog import FORCE, TORQUE, ZERO_WORD
from hal.wire.can import Received
from hal.wire.mais import FIRST, HALL_0_6, HALL_7_14, SENSORS
from hal.wire.modes import ControlMode
from services.config import load_robot
from services.core.clock import RealClock
from services.emulated.emulation import rig_spec
from services.experiments.rows import Row, at_most, publish

TICK_BAR_US = 60.0
FLAT_BAR = 1.2  # cost per axis of all axes over that of the first two
WARM_UP_TICKS = 1000
TICKS = 5000
FEED_PERIOD_MS = 10
MASK, SHOULDER_MASK = 0x35, 0x37
SHOULDER = {0x50, 0x57}  # minor firmware numbers
VIRTUAL, MAIS = 12, 14  # addresses
RIGHT_LEG_BUS, RIGHT_LEG_VIRTUAL = 4, 11
LEFT_ARM, RIGHT_ARM = (
    {f"{side}_shoulder", f"{side}_elbow", f"{side}_forearm"} for side in ("l", "r")
)
SELECTIONS: dict[int, set[str] | None] = {
    2: {"l_hip"},
    10: LEFT_ARM | {"l_hip"},
    26: LEFT_ARM | RIGHT_ARM | {"l_hip", "l_knee", "l_ankle", "r_hip", "r_knee"},
    53: None,
}
"""Names of the boards by the number of their axes; None = all."""

MODES = (
    ControlMode.POSITION,
    ControlMode.DIRECT,
    ControlMode.IMPEDANCE_POSITION,
    ControlMode.VELOCITY,
    ControlMode.TORQUE,
    ControlMode.IDLE,
)
NEED_TORQUE = {ControlMode.IMPEDANCE_POSITION, ControlMode.TORQUE}


class Boards:
    """Motor boards of the robot with all axes in some mode."""

    def __init__(self, axes: int) -> None:
        robot = rig_spec(load_robot("icub"), seed=0)
        wired = {(axis.bus, axis.address) for axis in robot.axes}
        names = SELECTIONS[axes]
        specs = [
            board
            for board in robot.boards
            if (board.bus, board.address) in wired and (names is None or board.name in names)
        ]
        self.network = Network(specs, ())
        self.axes = self.network.axes()
        self.frames = 0
        self._ms = 0
        self._fed = {bus: feed(bus) for bus in {spec.bus for spec in specs}}
        self._draws = np.random.default_rng(0)
        for spec in specs:
            broadcast(self.network, spec)
        self.move()
        self.tick()
        for number, axis in enumerate(self.axes):
            run(axis, number)

    def move(self) -> None:
        """Change what encoders and current sensors read, as a plant would."""
        bank = self.network.bank
        bank.raw_encoder[:] = self._draws.integers(1990, 2010, len(bank.rows))
        bank.current_ma[:] = self._draws.integers(-400, 400, len(bank.rows))

    def tick(self) -> None:
        """One millisecond of the boards."""
        self.network.deliver({} if self._ms % FEED_PERIOD_MS else self._fed)
        self._ms += 1
        for frames in self.network.tick().values():
            self.frames += len(frames)


def feed(bus: int) -> list[Received]:
    """Virtual torques and Hall values for the boards of a bus."""
    source = RIGHT_LEG_VIRTUAL if bus == RIGHT_LEG_BUS else VIRTUAL
    words = (ZERO_WORD + 100, ZERO_WORD - 200, ZERO_WORD)
    frames = [FORCE.frame(source, *words), TORQUE.frame(source, *words)]
    frames += [FORCE.frame(RIGHT_LEG_VIRTUAL, *words)]  # of the wrists
    hall = range(40, 40 + SENSORS)
    frames += [HALL_0_6.frame(MAIS, *hall[:FIRST]), HALL_7_14.frame(MAIS, *hall[FIRST:])]
    return [(can_id, data, 0) for can_id, data in frames]


def broadcast(network: Network, spec: BoardSpec) -> None:
    """Let a board broadcast what it does on a robot."""
    mask = SHOULDER_MASK if spec.firmware[1] in SHOULDER else MASK
    for axis in network.board(spec.bus, spec.address).axes:
        axis.pair.mask = mask


def run(axis: Axis, number: int) -> None:
    """Put an axis into a mode, with the gains of an arm."""
    mode = MODES[number % len(MODES)]
    if mode in NEED_TORQUE and axis.wiring.torque_source is None:
        mode = ControlMode.DIRECT
    pid, loop, spring = axis.position_pid, axis.torque_loop, axis.impedance
    pid.kp, pid.kd, pid.ki, pid.shift, pid.output_limit = 32000, 50, 60, 13, 700
    loop.pid.kp, loop.pid.shift, loop.pid.output_limit = 76, 14, 700
    loop.bemf, loop.bemf_shift, loop.stiction_up, loop.stiction_down = 18460, 7, 20, 20
    spring.stiffness, spring.damping = 144, 10803
    axis.reference.velocity_timeout_ms = 1 << 30
    if mode != ControlMode.IDLE:
        axis.enter(mode)
        axis.reference.start_move(axis.position + 1000, 1)
        if mode == ControlMode.VELOCITY:
            axis.reference.start_velocity(3, 1)


def measure(step: Callable[[], None], prepare: Callable[[], None], ticks: int) -> float:
    """Median duration of `step` in us, `prepare` not counted."""
    clock = RealClock()
    durations_ns = []
    for _ in range(ticks):
        prepare()
        begin_ns = clock.now_ns()
        step()
        durations_ns.append(clock.now_ns() - begin_ns)
    return median(durations_ns) / 1000.0


def nothing() -> None:
    """An empty step."""


def tick_rows() -> list[Row]:
    """Median cost of a tick by the number of axes."""
    rows = []
    per_axis = {}
    for axes in SELECTIONS:
        boards = Boards(axes)
        measure(boards.tick, boards.move, WARM_UP_TICKS)
        boards.frames = 0
        cost_us = measure(boards.tick, boards.move, TICKS)
        faults = sum(axis.fault_entries for axis in boards.axes)
        per_axis[axes] = cost_us / axes
        name = f"tick of {axes} axes, {boards.frames / TICKS:.1f} frames, median"
        if axes == max(SELECTIONS):
            rows.append(at_most(name, cost_us, "us", TICK_BAR_US))
        else:
            rows.append(Row(name, cost_us, "us"))
        rows.append(at_most(f"faults of {axes} axes meanwhile", faults, "", 0))
    most, least = max(SELECTIONS), min(SELECTIONS)
    ratio = per_axis[most] / per_axis[least]
    rows.append(at_most(f"cost per axis, {most} axes over {least}", ratio, "", FLAT_BAR))
    rows.append(Row("empty loop beside it, median", measure(nothing, nothing, TICKS), "us"))
    return rows


if __name__ == "__main__":
    raise SystemExit(publish("A millisecond of the motor boards", tick_rows(), None))
