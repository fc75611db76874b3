"""Worked examples 1 to 4, 24 to 29 and 34 to 36 (can-protocol 12) with emulated sensor boards."""

import pytest

from firmware_sim.boards.mais import Mais
from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.boards.strain import Strain
from firmware_sim.description import BoardSpec
from firmware_sim.registry import make_board
from hal.wire.can import Frame
from tests.firmware_sim.boards.bench import Bench

FULL_SCALE = (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0)


def frame(text: str) -> Frame:
    """`ID bytes`, hexadecimal."""
    can_id, _, data = text.partition(" ")
    return int(can_id, 16), bytes.fromhex(data)


def sensor(kind: str, address: int, firmware: tuple[int, int]) -> SensorBoard:
    """A board that has told why it was reset."""
    spec = BoardSpec(bus=1, address=address, type=kind, firmware=firmware)
    board: object = make_board(spec, FULL_SCALE if kind == "strain" else None)
    assert isinstance(board, SensorBoard)
    board.tick()
    return board


def tell(board: SensorBoard, *texts: str) -> list[Frame]:
    """Frames to the board; what it sends in that millisecond."""
    for text in texts:
        board.on_frame(*frame(text))
    return board.tick()


@pytest.fixture
def strain() -> Strain:
    board = sensor("strain", 13, (3, 0))
    assert isinstance(board, Strain)
    return board


def test_1_discovery_of_a_strain_and_a_4dc() -> None:
    board = sensor("strain", 14, (2, 3))
    ((can_id, data),) = tell(board, "70F FF")
    # Build 6 in the log; the emulated build is that of the sheet's present STRAIN, 5.
    assert (can_id, data[:4], data[4:]) == (0x7E0, bytes.fromhex("FF060203"), b"\x05")
    bench = Bench("dc4 1.11")
    bench.give(frame("70F FF"))
    # Build 23 in the log; here 87, of the latest release.
    assert bench.tick() == [frame("730 FF03011157")]


def test_3_serial_number_of_a_strain() -> None:
    board = sensor("strain", 14, (3, 0))
    tell(board, "20E 19534E3032330000")
    assert tell(board, "20E 1A") == [frame("2E0 1A534E3032330000")]


def test_4_and_29_firmware_download_to_board_13_and_its_restart(strain: Strain) -> None:
    idle = sensor("strain", 12, (3, 0))
    assert tell(strain, "70D 0000") == [frame("7D0 0001")]
    lines = ("70F 01100002000000", "70F 03CFBB200080F0", "70F 03200000018800")
    for board in (strain, idle):
        assert [tell(board, line) for line in lines] == [[], [], []]
    assert tell(strain, "70F 0300000000") == [frame("7D0 0301")]
    assert tell(idle, "70F 0300000000") == []
    assert tell(strain, "70D 04") == [frame("7D0 0401")]
    assert strain.tick() == [frame("2D0 000000010000")]
    strain.power_cycle()
    assert strain.tick() == [frame("2D0 010000000000")]


def test_24_full_scale_is_big_endian(strain: Strain) -> None:
    assert tell(strain, "20D 1800") == [frame("2D0 180005F1")]


def test_25_to_27_start_and_calibrated_sample(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    assert tell(strain, "20D 0801") == [frame("2D0 ")]
    sample = [frame("3DA 00803A7F4183"), frame("3DB C4832C7E2A81")]
    assert tell(strain, "20D 0700") == [frame("2D0 "), *sample]
    assert strain.tick() == sample


def test_28_a_saturated_channel_repeats_the_sample(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    tell(strain, "20D 0700")
    strain.raw_adc[0] = 999
    assert strain.tick() == [frame("3DA 00803A7F418305"), frame("3DB C4832C7E2A8101")]


def test_28_the_sample_that_is_repeated_may_have_been_taken_silently(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    tell(strain, "20D 0701")
    strain.raw_adc[0] = 999
    strain.tick()
    assert frame("3DA 00803A7F418305") in tell(strain, "20D 0700")


def test_34_accelerometer_and_gyroscope_each_10_ms() -> None:
    board = sensor("mtb", 14, (2, 0x11))
    assert isinstance(board, Mtb)
    board.acceleration_g[:] = [0.0, 0.0, 1.024]
    frames = tell(board, "20E 4F0C0A")
    for _ in range(29):
        frames += board.tick()
    assert frames == [frame("5E0 000000000000"), frame("5E1 000000000040")] * 3


def test_35_triangle_3_at_rest() -> None:
    board = sensor("mtb", 14, (2, 0x11))
    frames = tell(board, "20E 4D0028F0", "20E 0700")
    for _ in range(39):
        frames += board.tick()
    triangle = [sent for sent in frames if sent[0] == 0x4E3]
    assert triangle == [frame("4E3 40F0F0F0F0F0F0F0"), frame("4E3 C0F0F0F0F0F00000")]
    assert len(frames) == 32


def test_36_hall_sensors_of_a_mais() -> None:
    board = sensor("mais", 14, (3, 1))
    assert isinstance(board, Mais)
    board.hall[:7] = [0x10, 0xFF, 0xFF, 0xF0, 0xFF, 0xFF, 0xF8]
    assert frame("3EC 10FFFFF0FFFFF8") in tell(board, "20E 0801", "20E 0700")
