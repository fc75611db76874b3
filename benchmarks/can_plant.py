"""The whole robot without its services: what the plant costs, and how fast boards and buses run.

    python -m benchmarks.can_plant

Every board sends what the robot's own configuration asks of it, nothing is left out and the host
empties its buses each millisecond. Every axis is calibrated and holds its joint.
"""

import gc
from statistics import median

from benchmarks.whole_robot import WholeRobot
from services.core.clock import NS_PER_S, RealClock
from services.experiments.rows import Row, at_least, at_most, publish

PLANT_BAR_US = 120.0
FACTOR_BAR = 2.0
PLANT_STEPS = 5_000
WARM_MS, MEASURED_MS = 500, 10_000
REPEATS = 3
MS_PER_S = 1000.0
NS_PER_US = 1000.0


def plant_rows() -> list[Row]:
    """Figures of plant, boards and buses; the start-up of the robot is not part of them."""
    robot = WholeRobot()
    try:
        robot.calibrated()
        seconds, frames = board_seconds(robot)
        axes = len(robot.rig.joints)
        return [
            at_most(f"plant of {axes} axes, one step", plant_us(robot), "us", PLANT_BAR_US),
            at_least(
                "boards, plant and memory buses, one process",
                MEASURED_MS / MS_PER_S / seconds,
                "x real time",
                FACTOR_BAR,
            ),
            Row("one millisecond of them", seconds / MEASURED_MS * 1e6, "us"),
            Row("frames of the boards", frames / (MEASURED_MS / MS_PER_S), "1/s"),
        ]
    finally:
        robot.close()


def plant_us(robot: WholeRobot) -> float:
    """Median over repeats of the mean cost of a step under the duties that stand now."""
    plant = robot.rig.plant
    pwm, enabled = plant.pwm.copy(), plant.drives.enabled.copy()
    clock, costs = RealClock(), []
    for _ in range(REPEATS):
        gc.collect()
        begin_ns = clock.now_ns()
        for _ in range(PLANT_STEPS):
            plant.step(pwm, enabled)
        costs.append((clock.now_ns() - begin_ns) / PLANT_STEPS)
    return median(costs) / NS_PER_US


def board_seconds(robot: WholeRobot) -> tuple[float, int]:
    """What ten seconds of boards, plant and buses take, and the frames that the boards send."""
    for _ in range(WARM_MS):
        pass_millisecond(robot)
    gc.collect()
    clock = RealClock()
    sent, begin_ns = robot.frames, clock.now_ns()
    for _ in range(MEASURED_MS):
        pass_millisecond(robot)
    return (clock.now_ns() - begin_ns) / NS_PER_S, robot.frames - sent


def pass_millisecond(robot: WholeRobot) -> None:
    """A millisecond of the boards; the host takes its frames and does nothing with them."""
    robot.tick_boards()
    for bus in robot.hal_buses.values():
        bus.receive_frames()


if __name__ == "__main__":
    raise SystemExit(publish("Whole robot on ten buses", plant_rows(), None))
