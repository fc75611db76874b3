"""Random frames at every board and at the HAL: nobody raises, nothing moves that may not.

    python -m benchmarks.can_fuzz [--json FILE] [--frames N] [--seed N]

Each board type gets N frames, spread over its firmwares, and the HAL of the whole robot N more.
"""

import argparse
import random
import struct
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.can_fuzz_hal import hal_rows
from benchmarks.can_noise import EPISODE, Noise, SensorNoise
from benchmarks.can_oracle import GateOracle, is_useless, is_useless_to_sensor
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES, Board
from firmware_sim.boards.brushless import BODY_VERSIONS, NECK_VERSIONS
from firmware_sim.boards.dc4 import VERSIONS as DC4_VERSIONS
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.wire.can import Frame
from services.experiments.rows import Row, at_least, at_most, publish

FRAMES = 1_000_000
MOTOR_TYPES = {
    "bll": BODY_VERSIONS,
    "bll_ie": BODY_VERSIONS,
    "bll_dc": NECK_VERSIONS,
    "dc4": DC4_VERSIONS,
}
SENSOR_TYPES = ("strain", "strain2", "mais", "mtb", "imu")
FULL_SCALE = (1500.0, 1500.0, 1500.0, 35.0, 35.0, 35.0)
LEG_MINOR, LEG_ADDRESS = 0x51, 6  # x.51 sits at 5 to 10 only
BURST = 40
RAISED = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, struct.error)


@dataclass
class Tally:
    """What became of the frames."""

    given: int = 0
    filtered: int = 0  # let in by no hardware filter
    dropped: Counter[str] = field(default_factory=Counter)
    raised: Counter[str] = field(default_factory=Counter)
    moved_illegally: int = 0  # axis-milliseconds
    ran: int = 0  # axis-milliseconds, legally
    uncounted: int = 0  # frames of no use that no counter shows and no answer tells
    wrong_overruns: int = 0


def fuzz_rows(frames: int = FRAMES, seed: int = 1) -> list[Row]:
    """Every board type and the HAL, `frames` each."""
    rows: list[Row] = []
    for kind, versions in MOTOR_TYPES.items():
        tally = Tally()
        for version in versions:
            fuzz_motor_board(kind, version, frames // len(versions), seed, tally)
        rows += [*_rows(kind, tally), at_least(f"{kind}: ms that axes ran", tally.ran, "", 1)]
        rows.append(at_most(f"{kind}: ms that axes ran illegally", tally.moved_illegally, "", 0))
    for kind in SENSOR_TYPES:
        tally = Tally()
        fuzz_sensor_board(kind, frames, seed, tally)
        rows += _rows(kind, tally)
    return [*rows, *hal_rows(frames, seed)]


def _rows(what: str, tally: Tally) -> list[Row]:
    causes = ", ".join(f"{cause} {count}" for cause, count in sorted(tally.dropped.items()))
    raised = ", ".join(tally.raised)
    return [
        Row(f"{what}: frames given", tally.given, "", "", None),
        Row(f"{what}: filtered", tally.filtered),
        Row(f"{what}: dropped", causes),
        Row(f"{what}: exceptions", raised or "none", "", "none", not tally.raised),
        at_most(f"{what}: useless frames not counted", tally.uncounted, "", 0),
        at_most(f"{what}: receive overruns miscounted", tally.wrong_overruns, "", 0),
    ]


def fuzz_motor_board(
    kind: str, version: tuple[int, int], frames: int, seed: int, tally: Tally
) -> None:
    """Episodes of frames at one board, each from power-up, judged by an oracle of its own."""
    address = LEG_ADDRESS if version[1] == LEG_MINOR else 3
    board = make_board(BoardSpec(bus=0, address=address, type=kind, firmware=version))
    draw = random.Random(f"{seed} {kind} {version}")
    oracle = GateOracle(len(board.axes), version[1])
    noise = Noise(draw, len(board.axes))
    running = [False] * len(board.axes)
    for number in range(frames):
        if number % EPISODE == 0:
            board.power_cycle()
            oracle.boot()
            noise.new_episode()
            running = [False] * len(board.axes)
            for port in board.ports:
                port.raw_encoder = draw.randrange(0x1000)
        elif number % EPISODE == EPISODE // 2:
            _overrun(board, tally)
        frame = noise.frame(board.addresses)
        oracle.hear(board.addresses, *frame)
        useless = is_useless(board.addresses, *frame)
        _give(board, frame, tally, useless=useless)
        _judge(board, oracle, running, tally)
        port = board.ports[number % len(board.ports)]
        port.raw_encoder = port.raw_encoder + draw.randrange(-3, 4) & 0xFFF
    tally.dropped.update(board.dropped)


def fuzz_sensor_board(kind: str, frames: int, seed: int, tally: Tally) -> None:
    """The same at a sensor board; it has nothing to move."""
    spec = BoardSpec(bus=0, address=13, type=kind, firmware=(1, 0))
    board = make_board(spec, FULL_SCALE if kind.startswith("strain") else None)
    draw = random.Random(f"{seed} {kind}")
    noise = SensorNoise(draw)
    for number in range(frames):
        if number % EPISODE == 0:
            board.power_cycle()
        frame = noise.frame(13)
        board.raw_adc[:] = [draw.randrange(0x10000) for _ in board.raw_adc]
        _give(board, frame, tally, useless=is_useless_to_sensor(13, *frame))
    tally.dropped.update(board.dropped)


def _give(board: Board, frame: Frame, tally: Tally, *, useless: bool) -> None:
    """One frame in one millisecond: it must be counted, or answered, when it is of no use."""
    tally.given += 1
    before = board.dropped.total()
    if not board.accepts(frame[0]):
        tally.filtered += 1
    else:
        board.on_frame(*frame)
    answered = False
    try:
        sent = board.tick()
        answered = any(can_id >> 8 in (2, 7) for can_id, _ in sent)
        if any(not 0 <= can_id < 0x800 or len(data) > 8 for can_id, data in sent):
            tally.raised["sends what is no CAN frame"] += 1
    except RAISED as error:
        tally.raised[f"{type(error).__name__}: {error} at {frame[0]:03X} {frame[1].hex()}"] += 1
    if useless and board.dropped.total() == before and not answered:
        tally.uncounted += 1


def _overrun(board: Board, tally: Tally) -> None:
    """More frames in a millisecond than the receive buffer holds: the rest is lost and counted."""
    board.tick()
    before = board.dropped["overrun"]
    for _ in range(BURST):
        frame = (board.addresses[0], b"\x00")  # NO_MESSAGE
        board.on_frame(*frame)
    tally.given += BURST
    tally.wrong_overruns += board.dropped["overrun"] - before != BURST - RECEIVE_FIFO_FRAMES
    board.tick()


def _judge(board: Board, oracle: GateOracle, running: list[bool], tally: Tally) -> None:
    for number, port in enumerate(board.ports):
        runs = port.enabled or port.pwm != 0
        if runs:
            legal = oracle.may_run(number) if running[number] else oracle.may_start(number)
            tally.ran += legal
            tally.moved_illegally += not legal
        running[number] = runs
    oracle.ms += 1


def main() -> int:
    """The whole figure, or fewer frames of it."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rows = fuzz_rows(arguments.frames, arguments.seed)
    return publish("random frames", rows, arguments.json)


if __name__ == "__main__":
    raise SystemExit(main())
