"""Bytes that nobody would send: neither the HAL nor a board may raise, and a drop is counted."""

import random

import pytest

from firmware_sim.boards.board import Board
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.wire.can import Frame
from tests.hal.scripted import MS, Script

STEPS = 2000
FRAMES_PER_STEP = 6
BOARDS = {
    "bll_ie": BoardSpec(bus=0, address=1, type="bll_ie", firmware=(2, 0x50)),
    "dc4": BoardSpec(bus=0, address=3, type="dc4", firmware=(2, 0x19)),
    "strain": BoardSpec(bus=0, address=13, type="strain", firmware=(3, 0)),
}
FULL_SCALE = (1500.0, 1500.0, 1500.0, 35.0, 35.0, 35.0)
HAL_IDS = (0x001, 0x010, 0x030, 0x040, 0x70F, 0x2D0, 0x3DA, 0x3DB, 0x3CA, *range(0x110, 0x150))
# Commands that get an axis running, so that random ones meet every mode.
OPENERS = ("5B0106", "527D0000003C000D", "5400002003000300", "0403D1070A000000", "0901", "0908")


def noise(draw: random.Random, can_ids: tuple[int, ...]) -> Frame:
    can_id = draw.choice(can_ids) if draw.random() < 0.9 else draw.randrange(0x800)
    return can_id, draw.randbytes(draw.randrange(9))


def made(name: str) -> Board:
    return make_board(BOARDS[name], FULL_SCALE if name == "strain" else None)


@pytest.mark.parametrize("name", sorted(BOARDS))
def test_boards_take_any_frame(name: str) -> None:
    draw = random.Random(name)
    board = made(name)
    polled = 0x000 if board.ports else 0x200
    can_ids = (*(polled | address for address in board.addresses), 0x3CA, 0x3CB, 0x70F)
    sent: list[Frame] = []
    for _ in range(STEPS):
        for _ in range(FRAMES_PER_STEP):
            can_id, data = noise(draw, can_ids)
            if board.ports and draw.random() < 0.2:
                opener = bytearray.fromhex(draw.choice(OPENERS))
                opener[0] |= draw.choice((0, 0x80))
                can_id, data = board.addresses[0], bytes(opener)
            if board.accepts(can_id):
                board.on_frame(can_id, data)
        for port in board.ports:
            port.raw_encoder = draw.randrange(0x1000)
        board.raw_adc[:] = [draw.randrange(0x10000) for _ in board.raw_adc]
        sent += board.tick()

    assert len(sent) > STEPS / 4
    assert all(0 <= can_id < 0x800 and len(data) <= 8 for can_id, data in sent)
    assert min(board.dropped["length"], board.dropped["management"]) > 0


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
