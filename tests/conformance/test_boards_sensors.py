"""What the protocol asks of every sensor board (can-protocol 1, 5, 7, 8)."""

import random

import pytest

from firmware_sim import registry
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES, Board
from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.readings import SkinSample
from hal.wire import analog
from hal.wire.can import Frame, class_of, source_of
from hal.wire.management import BoardType
from tests.hal.sensor_bench import ADDRESSES, SensorBench

FULL_SCALE = (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0)
ADDRESS = 13
REPLY = 0x2D0
FIRMWARE = (2, 0x11)
TYPES = {
    "imu": BoardType.RFE,
    "mais": BoardType.MAIS,
    "mtb": BoardType.SKIN,
    "strain": BoardType.STRAIN,
    "strain2": BoardType.STRAIN2,
}
STARTERS = {  # what starts every stream of a board
    "imu": ("3417800000000000", "3501"),
    "mais": ("0700",),
    "mtb": ("4D0028F0", "4F0C0A", "0700"),
    "strain": ("0700",),
    "strain2": ("0700", "3417800000000000", "3505", "3901", "3A01"),
}
STEPS = 3000


def made(name: str) -> SensorBoard:
    spec = BoardSpec(bus=0, address=ADDRESS, type=name, firmware=FIRMWARE)
    board: Board = make_board(spec, FULL_SCALE if name in registry.SENSOR_BOARDS else None)
    assert isinstance(board, SensorBoard)
    board.tick()  # STRAIN tells why it was reset
    return board


@pytest.fixture(params=sorted(TYPES))
def name(request: pytest.FixtureRequest) -> str:
    """The name of each sensor board in turn."""
    assert isinstance(request.param, str)
    return request.param


def ask(board: SensorBoard, data: str, can_id: int = 0x200 | ADDRESS) -> list[Frame]:
    board.on_frame(can_id, bytes.fromhex(data))
    return board.tick()


def started(name: str) -> SensorBoard:
    board = made(name)
    for data in STARTERS[name]:
        ask(board, data)
    return board


def stream(board: SensorBoard, milliseconds: int = 50) -> list[Frame]:
    return [frame for _ in range(milliseconds) for frame in board.tick()]


def test_every_registered_sensor_board_is_examined_here() -> None:
    assert set(TYPES) == {*registry.SENSOR_BOARDS, *registry.PLAIN_SENSOR_BOARDS}


def test_is_silent_at_boot(name: str) -> None:
    assert stream(made(name), 2000) == []


def test_streams_once_it_is_started(name: str) -> None:
    frames = stream(started(name))
    assert frames
    assert {source_of(can_id) for can_id, _ in frames} == {ADDRESS}
    assert {class_of(can_id) for can_id, _ in frames} <= {3, 4, 5}


def test_handshake_tells_type_and_firmware_and_needs_the_same_protocol(name: str) -> None:
    board = made(name)
    (frame,) = ask(board, "1C0100")
    assert frame[0] == REPLY
    assert frame[1][:4] == bytes((0x1C, TYPES[name], *FIRMWARE))
    assert frame[1][5:] == b"\x01\x00\x01"
    assert ask(board, "1C0101")[0][1][7] == 0
    assert ask(board, "1C0200")[0][1][7] == 0


def test_answers_whoever_asked(name: str) -> None:
    (frame,) = ask(made(name), "1C0100", 0x250 | ADDRESS)
    assert frame[0] == 0x2D5


@pytest.mark.parametrize("to", [0x70F, 0x700 | ADDRESS])
def test_a_discovery_is_answered_and_stops_every_stream(name: str, to: int) -> None:
    board = started(name)
    (frame,) = ask(board, "FF", to)
    assert frame == (0x7D0, bytes((0xFF, TYPES[name], *FIRMWARE, board.build)))
    assert stream(board, 3000) == []


def test_label_is_kept_over_a_power_cycle(name: str) -> None:
    board = made(name)
    ask(board, "0D026B6E6565", 0x700 | ADDRESS)  # piece 2: "knee"
    board.power_cycle()
    board.tick()
    pieces = ask(board, "0C", 0x700 | ADDRESS)
    assert [(can_id, data[:2]) for can_id, data in pieces] == [
        (0x7D0, bytes((0x0C, index))) for index in range(8)
    ]
    assert pieces[2][1][2:] == b"knee"


def test_boot_loader_is_entered_tells_four_bytes_and_leaves_after_five_seconds(name: str) -> None:
    board = started(name)
    assert ask(board, "0000", 0x700 | ADDRESS) == [(0x7D0, b"\x00\x01")]
    assert ask(board, "FF", 0x70F) == [(0x7D0, bytes((0xFF, TYPES[name], *FIRMWARE)))]
    assert ask(board, "1C0100") == []
    assert stream(board, 4900) == []
    stream(board, 200)
    assert len(ask(board, "1C0100")) == 1


def test_boot_loader_stays_after_a_second_board_command_until_end(name: str) -> None:
    board = made(name)
    ask(board, "0000", 0x700 | ADDRESS)
    ask(board, "0000", 0x700 | ADDRESS)
    stream(board, 6000)
    assert ask(board, "1C0100") == []
    assert ask(board, "04", 0x700 | ADDRESS)[0] == (0x7D0, b"\x04\x01")
    board.tick()
    assert len(ask(board, "1C0100")) == 1


def test_a_running_application_takes_the_end_of_a_download_as_a_ping(name: str) -> None:
    board = made(name)
    assert ask(board, "04", 0x700 | ADDRESS) == [(0x7D0, b"\x04\x01")]
    assert board.dropped == {}


@pytest.mark.parametrize("off", ["bus_off", "powered"])
def test_says_nothing_without_bus_or_power(name: str, off: str) -> None:
    board = started(name)
    setattr(board, off, off == "bus_off")
    assert ask(board, "1C0100") == []
    assert stream(board) == []


def test_a_silent_board_still_answers(name: str) -> None:
    board = started(name)
    board.silent = True
    assert len(ask(board, "1C0100")) == 1
    assert stream(board, 500) == []
    board.silent = False
    assert stream(board)


def test_a_rebooting_board_is_away_and_comes_back_without_its_settings(name: str) -> None:
    board = started(name)
    board.reboot_ms = 300
    assert stream(board, 300) == []
    expected = [(REPLY, bytes.fromhex("010000000000"))] if name == "strain" else []
    assert stream(board, 500) == expected
    assert len(ask(board, "1C0100")) == 1


def test_hears_only_its_own_commands(name: str) -> None:
    board = made(name)
    assert [can_id for can_id in range(0x800) if board.accepts(can_id)] == [
        *(0x200 | source << 4 | ADDRESS for source in range(16)),
        0x700 | ADDRESS,
        0x70F,
    ]
    ask(board, "1C0100", 0x200 | ADDRESS - 1)
    assert board.dropped["address"] == 1


def test_the_receive_queue_holds_thirty_frames(name: str) -> None:
    board = made(name)
    for _ in range(RECEIVE_FIFO_FRAMES + 3):
        board.on_frame(0x200 | ADDRESS, b"\x1c\x01\x00")
    assert len([data for _, data in board.tick() if data]) == 30
    assert board.dropped["overrun"] == 3


def test_a_full_receive_queue_is_told_by_the_boards_that_do(name: str) -> None:
    board = made(name)
    for _ in range(RECEIVE_FIFO_FRAMES + 3):
        board.on_frame(0x200 | ADDRESS, b"\x1c\x01\x00")
    told = [(can_id, data) for can_id, data in board.tick() if not data]
    expected = {"strain": [(0x1D0, b"")], "mais": [(0x1D0, b"")], "mtb": [(0x7D5, b"")]}
    assert told == expected.get(name, [])  # once, however many are lost
    assert board.tick() == []


def test_every_command_of_the_table_is_taken_at_any_length(name: str) -> None:
    board = made(name)
    for row in analog.COMMANDS.values():
        for length in range(8):
            for fill in (0x00, 0x7F, 0xFF):
                for can_id, data in ask(board, bytes((row.code, *[fill] * length)).hex()):
                    assert source_of(can_id) == ADDRESS
                    assert len(data) <= 8


def test_only_strain_and_mais_acknowledge_a_setting_with_an_empty_frame(name: str) -> None:
    board = made(name)
    for setting in ("0701", "0801"):
        expected = [(REPLY, b"")] if name in ("strain", "mais") else []
        assert ask(board, setting) == expected


def test_only_strain_and_mais_answer_what_they_do_not_know(name: str) -> None:
    answer = [(REPLY, b"\xeeBUG")] if name in ("strain", "mais") else []
    assert ask(made(name), "EE00") == answer


def test_random_frames_raise_nothing_and_are_counted(name: str) -> None:
    draw = random.Random(name)
    board = started(name)
    can_ids = (0x200 | ADDRESS, 0x200 | ADDRESS, 0x700 | ADDRESS, 0x70F)
    for _ in range(5000):
        anywhere = draw.random() < 0.1
        can_id = draw.randrange(0x800) if anywhere else draw.choice(can_ids)
        data = draw.randbytes(draw.randrange(9))
        if data[:1] == b"\x00" and can_id >> 8 == 7:
            continue  # the boot loader
        board.on_frame(can_id, data)
        for sent_id, sent in board.tick():
            assert 0 <= sent_id < 0x800
            assert len(sent) <= 8
    assert min(board.dropped["address"], board.dropped["length"]) > 0
    assert board.dropped["management"] > 0


def test_the_hal_takes_any_frame_of_a_sensor_board() -> None:
    draw = random.Random("sensors")
    bench = SensorBench().open()
    periodic = [
        can_class << 8 | address << 4 | kind
        for can_class in (3, 4, 5)
        for address in ADDRESSES.values()
        for kind in range(16)
    ]
    replies = [0x200 | address << 4 for address in ADDRESSES.values()]
    for _ in range(STEPS):
        for _ in range(6):
            can_id = draw.choice(draw.choice((periodic, replies)))
            data = bytearray(draw.randbytes(draw.randrange(9)))
            if data and draw.random() < 0.5:
                data[0] = draw.choice((0x40, 0xC0, 0x1C, 0x18))
            bench.say(f"{can_id:03X} {data.hex()}")
        bench.tick()
    drops = bench.drops
    assert sum(drops.values()) > STEPS
    assert {
        "skin frame of wrong length",
        "FORCE of wrong length",
        "HALL_0_6 of wrong length",
        "GYROSCOPE of wrong length",
        "IMU_TRIPLE of wrong length",
        "THERMOMETER of wrong length",
        "undecodable reply of a sensor",
    } <= set(drops)
    assert len(bench.take("mtb", SkinSample)) > 0
    bench.close()
