"""Bytes that nobody would send: neither the HAL nor a board may raise, and a drop is counted.

On a motor board one axis never gets its integral gain: whatever else comes, it may not move.
"""

import random

import pytest

from firmware_sim.boards.board import Board
from firmware_sim.registry import make_board
from hal.wire.can import Frame
from tests.firmware_sim.boards.bench import VERSIONS, spec_of
from tests.hal.scripted import MS, Script

STEPS = 2000
BOARD_STEPS = 400
FRAMES_PER_STEP = 6
MOTOR_BOARDS = {
    f"{kind} {major}.{minor:02X}": spec_of(kind, major, minor, coupled=True)
    for kind, versions in VERSIONS.items()
    for major, minor in versions
}
HAL_IDS = (0x001, 0x010, 0x030, 0x040, 0x70F, 0x2D0, 0x3DA, 0x3DB, 0x3CA, *range(0x110, 0x150))
# What a board hears of others: torques, a shoulder's partner, the hand's Hall sensors, a discovery.
HEARD_IDS = (0x3CA, 0x3CB, 0x3BA, 0x111, 0x112, 0x122, 0x3EC, 0x3ED)
# Commands that get an axis running, so that random ones meet every mode.
OPENERS = (
    "5B0106",
    "527D0000003C000D",
    "5400002003000300",
    "0403D1070A000000",
    "0404D1070A000A00",
    "0901",
    "0908",
    "0909",
)
GAINS = tuple(bytes((code,)) for code in (0x22, 0x52))  # SET_I_GAIN and SET_POS_PID
LOCKED = 0  # the axis that does not get them
BOOT = b"\x00"


def noise(draw: random.Random, can_ids: tuple[int, ...]) -> Frame:
    can_id = draw.choice(can_ids) if draw.random() < 0.9 else draw.randrange(0x800)
    return can_id, draw.randbytes(draw.randrange(9))


def motor_noise(draw: random.Random, board: Board) -> Frame:
    """A command, an opener or another board's frame; only a few jump to the boot loader."""
    chance = draw.random()
    if chance < 0.3:
        opener = bytearray.fromhex(draw.choice(OPENERS))
        opener[0] |= draw.choice((0, 0x80))
        return draw.choice(board.addresses), bytes(opener)
    if chance < 0.5:
        return draw.choice(HEARD_IDS), draw.randbytes(draw.choice((6, 7, 8, 8)))
    can_id, data = noise(draw, (*board.addresses, 0x70F))
    if can_id >> 8 == 7 and data[:1] == BOOT and draw.random() < 0.95:
        data = b"\x04"
    return can_id, data


def unlocks(board: Board, frame: Frame) -> bool:
    """True for a command that would give the locked axis its integral gain."""
    can_id, data = frame
    return can_id & 0xF == board.addresses[0] and can_id < 0x100 and data[:1] in GAINS


def storm(board: Board, draw: random.Random, steps: int) -> tuple[list[int], int]:
    """Random frames for so many milliseconds: how often each axis had power, and frames sent."""
    moved = [0] * len(board.axes)
    sent = 0
    for _ in range(steps):
        for _ in range(FRAMES_PER_STEP):
            frame = motor_noise(draw, board)
            if board.accepts(frame[0]) and not unlocks(board, frame):
                board.on_frame(*frame)
        for port in board.ports:
            port.raw_encoder = draw.randrange(0x1000)
        for can_id, data in board.tick():
            assert 0 <= can_id < 0x800
            assert len(data) <= 8
            sent += 1
        for number, port in enumerate(board.ports):
            moved[number] += port.enabled or port.pwm != 0
    return moved, sent


@pytest.mark.parametrize("name", sorted(MOTOR_BOARDS))
def test_no_frames_move_an_axis_that_did_not_pass_the_gate(name: str) -> None:
    board = make_board(MOTOR_BOARDS[name])
    moved, sent = storm(board, random.Random(name), BOARD_STEPS)
    locked = {board.axes[LOCKED], *board.axes[LOCKED].peers}
    for axis in board.axes:
        assert (moved[axis.number] == 0) == (axis in locked), moved
    assert sent > BOARD_STEPS / 4
    assert min(board.dropped[cause] for cause in ("length", "unknown", "management", "mode")) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(MOTOR_BOARDS))
def test_a_million_frames_do_not_either(name: str) -> None:
    board = make_board(MOTOR_BOARDS[name])
    steps = 1_000_000 // FRAMES_PER_STEP // len(MOTOR_BOARDS) + 1
    moved, _ = storm(board, random.Random(f"long {name}"), steps)
    for axis in (board.axes[LOCKED], *board.axes[LOCKED].peers):
        assert moved[axis.number] == 0


@pytest.mark.parametrize("name", sorted(MOTOR_BOARDS))
def test_without_a_handshake_nothing_moves(name: str) -> None:
    draw = random.Random(name)
    board = make_board(MOTOR_BOARDS[name])
    for _ in range(BOARD_STEPS // 2):
        for _ in range(FRAMES_PER_STEP):
            can_id, data = motor_noise(draw, board)
            if board.accepts(can_id) and data[:1] not in (b"\x5b", b"\xdb"):
                board.on_frame(can_id, data)
        board.tick()
        assert not any(port.enabled or port.pwm for port in board.ports)
    assert any(axis.fault_entries for axis in board.axes)  # it was tried


def test_the_hal_takes_any_frame() -> None:
    draw = random.Random("hal")
    script = Script()
    script.ready()
    for step in range(STEPS):
        script.bus.inbox += [noise(draw, HAL_IDS) for _ in range(FRAMES_PER_STEP)]
        script.robot.set_positions([0, 1], [draw.uniform(-9.0, 9.0), draw.uniform(-9.0, 9.0)])
        if step % 3 == 0:
            script.torques()
        script.robot.step(script.now_ns + MS)

    status = script.robot.status()
    assert status.frames_dropped > STEPS / 4
    assert status.foreign_frames > STEPS / 8
