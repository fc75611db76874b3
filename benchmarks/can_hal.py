"""What the HAL costs: one step of a robot in direct mode, and one received frame of it.

The boards are the emulated ones; only the HAL's own step is timed. Every axis follows position
references, so that each step decodes, watches and sends what it does in use.
"""

from statistics import median

from benchmarks.whole_robot import WholeRobot
from services.core.clock import RealClock
from services.experiments.rows import Row, at_most, publish

STEP_BAR_US = 150.0
STARTUP_BAR_MS = 3000.0
WARM_UP_MS = 300
MEASURED_MS = 3000
CYCLE_MS = 10
ROBOTS = {10: "icub:reach", 53: "icub"}
"""Robot references by the number of their axes."""


def hal_rows() -> list[Row]:
    """Median cost of a step, and of what one frame adds to it."""
    rows: list[Row] = []
    for axes, reference in ROBOTS.items():
        robot = WholeRobot(reference)
        startup_ms = robot.open()
        steps_us, frames = measured(robot)
        robot.close()
        step_us = median(steps_us)
        name = f"HAL step, {axes} axes in direct mode"
        rows.append(
            at_most(name, step_us, "us", STEP_BAR_US) if axes == 53 else Row(name, step_us, "us")
        )
        name = f"start-up with {axes} axes, virtual time"
        rows.append(at_most(name, startup_ms, "ms", STARTUP_BAR_MS))
        per_step = frames / len(steps_us)
        rows.append(Row(f"frames decoded per step, {axes} axes", per_step))
        rows.append(Row(f"HAL step per frame, {axes} axes", step_us / per_step, "us"))
    return rows


def measured(robot: WholeRobot) -> tuple[list[float], int]:
    """Cost of each step in microseconds, and the frames received in them."""
    clock = RealClock()
    robot.finish(robot.hal.request("calibrate"))
    robot.finish(robot.hal.request("mode", value="direct"))
    joints = list(range(len(robot.hal.joints.names)))
    posture = list(robot.hal.joints.q_rad)
    steps_us: list[float] = []
    received = 0
    for ms in range(WARM_UP_MS + MEASURED_MS):
        if ms == WARM_UP_MS:
            received = robot.hal.status().frames_received
        if ms % CYCLE_MS == 0:
            robot.hal.set_positions(joints, posture)
        robot.tick_boards()
        began_ns = clock.now_ns()
        robot.hal.step(robot.now_ns)
        if ms >= WARM_UP_MS:
            steps_us.append((clock.now_ns() - began_ns) / 1e3)
    frames = robot.hal.status().frames_received - received
    return steps_us, frames


if __name__ == "__main__":
    raise SystemExit(publish("HAL", hal_rows(), None))
