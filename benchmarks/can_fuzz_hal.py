"""Random frames at the HAL of the whole robot, which nobody has asked for any motion."""

import random
from dataclasses import dataclass

from benchmarks.can_noise import EXTENDED_IDS, STANDARD_IDS
from benchmarks.quiet import quiet
from benchmarks.whole_robot import WholeRobot
from firmware_sim.boards.axis import AxisPort
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_ANALOG_POLLING,
    CLASS_INERTIAL_PERIODIC,
    CLASS_MOTOR_PERIODIC,
    CLASS_MOTOR_POLLING,
    CLASS_SKIN_PERIODIC,
    HOST,
    Frame,
    frame_id,
    source_of,
)
from hal.wire.modes import ControlMode
from hal.wire.motor_periodic import STATUS
from services.experiments.rows import Row, at_least, at_most

FRAMES_PER_MS = 20
CALM_MS = 3000
REPLIES = (CLASS_MOTOR_POLLING, CLASS_ANALOG_POLLING)
BROADCASTS = (
    CLASS_MOTOR_PERIODIC,
    CLASS_ANALOG_PERIODIC,
    CLASS_SKIN_PERIODIC,
    CLASS_INERTIAL_PERIODIC,
)
MODES = tuple(ControlMode)


@dataclass
class Noise:
    """Frames that look as if boards of one bus had sent them, and others."""

    draw: random.Random
    sources: tuple[int, ...]

    def frame(self) -> Frame:
        """The next one."""
        draw = self.draw
        chance = draw.random()
        source = draw.choice(self.sources)
        if chance < 0.2:
            modes = draw.choice(MODES), draw.choice(MODES)
            faults = draw.choice((0, 0, draw.randrange(256))), draw.choice((0, draw.randrange(256)))
            trouble = draw.choice(((0, 0), (draw.randrange(256), draw.randrange(256))))
            return STATUS.frame(source, faults[0], modes[0], faults[1], modes[1], *trouble, 0, 0)
        if chance < 0.4:
            can_id = frame_id(draw.choice(REPLIES), source, HOST)
        elif chance < 0.75:
            can_id = frame_id(draw.choice(BROADCASTS), source, draw.randrange(16))
        else:
            can_id = draw.randrange(EXTENDED_IDS if chance > 0.98 else STANDARD_IDS)
        return can_id, draw.randbytes(draw.choice((draw.randrange(9), 8)))

    def is_nobodys(self, can_id: int) -> bool:
        """True for an identifier that neither a board of this bus nor a host has."""
        return can_id >= STANDARD_IDS or source_of(can_id) not in (HOST, *self.sources)


def hal_rows(frames: int, seed: int) -> list[Row]:
    """What became of `frames` random ones between those of the emulated boards."""
    robot = WholeRobot("icub")
    try:
        with quiet():
            robot.open()
            return _rows(robot, frames, random.Random(f"{seed} hal"))
    finally:
        robot.close()


def _rows(robot: WholeRobot, frames: int, draw: random.Random) -> list[Row]:
    ports = _ports(robot)
    noises = {bus: Noise(draw, addresses) for bus, addresses in _addresses(robot).items()}
    buses = tuple(noises)
    before = robot.hal.status()
    useless = moved = 0
    for _ in range(frames // FRAMES_PER_MS):
        for _ in range(FRAMES_PER_MS):
            bus = draw.choice(buses)
            frame = noises[bus].frame()
            useless += noises[bus].is_nobodys(frame[0])
            robot.hal_buses[bus].accept((robot.now_ns, [(*frame, robot.now_ns)]))
        robot.tick()
        moved += sum(port.enabled or port.pwm != 0 for port in ports)
    noisy = robot.hal.status()
    robot.tick(CALM_MS)
    calm = robot.hal.status()
    unwell = [board.name for board in calm.boards if board.state not in WELL]
    return [
        Row("HAL: frames given", frames - frames % FRAMES_PER_MS),
        at_least("HAL: frames received, the boards' among them", noisy.frames_received, "", frames),
        at_least(
            "HAL: drops counted; the bar is what nobody sends",
            noisy.frames_dropped - before.frames_dropped,
            "",
            useless,
        ),
        at_most("HAL: axis-ms that noise moved an axis", moved, "", 0),
        Row(
            f"HAL: boards not well {CALM_MS} ms later",
            ", ".join(unwell) or "none",
            "",
            "none",
            not unwell,
        ),
    ]


WELL = ("ok", "needs calibration", "restarted")


def _addresses(robot: WholeRobot) -> dict[int, tuple[int, ...]]:
    """Addresses in use, by bus."""
    found: dict[int, list[int]] = {bus: [] for bus in robot.hal_buses}
    for board in robot.hal.description.boards:
        found[board.bus] += robot.rig.board(board.bus, board.address).addresses
    return {bus: tuple(addresses) for bus, addresses in found.items()}


def _ports(robot: WholeRobot) -> tuple[AxisPort, ...]:
    boards = [robot.rig.board(one.bus, one.address) for one in robot.hal.description.boards]
    return tuple(port for board in boards for port in board.ports)
