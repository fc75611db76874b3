"""The MTB board, bytes written by hand from the sheet (can-protocol 7.1, 7.3 and 12)."""

import pytest

from firmware_sim.boards.mtb import Mtb
from firmware_sim.description import BoardSpec
from hal.wire.can import Frame

NEW_SET_UP = ("4D0028F0", "50000F02010022")  # 40 ms, no-load 240; triangles 0 to 15 enabled


@pytest.fixture
def mtb() -> Mtb:
    return Mtb(BoardSpec(bus=7, address=14, type="mtb", firmware=(2, 0x11)))


@pytest.fixture
def running(mtb: Mtb) -> Mtb:
    for data in (*NEW_SET_UP, "0700"):
        give(mtb, data)
    return mtb


def give(board: Mtb, data: str) -> None:
    board.on_frame(0x20E, bytes.fromhex(data))


def period(board: Mtb, periods: int = 1) -> list[Frame]:
    return [frame for _ in range(40 * periods) for frame in board.tick()]


def pair(board: Mtb, triangle: int) -> list[str]:
    frames = period(board)
    return [data.hex().upper() for can_id, data in frames if can_id & 0xF == triangle]


def test_is_silent_until_it_is_started_and_acknowledges_nothing(mtb: Mtb) -> None:
    for data in NEW_SET_UP:
        give(mtb, data)
    assert period(mtb, 3) == []


def test_sends_two_frames_of_each_triangle_each_period(running: Mtb) -> None:
    period(running)
    for _ in range(3):
        frames = period(running)
        assert sorted({can_id for can_id, _ in frames}) == list(range(0x4E0, 0x4F0))
        assert len(frames) == 32


def test_triangle_3_at_rest_is_the_worked_example(running: Mtb) -> None:
    assert pair(running, 3) == ["40F0F0F0F0F0F0F0", "C0F0F0F0F0F00000"]


def test_pressure_lowers_a_taxel_and_only_its_triangle(running: Mtb) -> None:
    running.taxels[3 * 12 + 2] = 200
    running.taxels[3 * 12 + 11] = 100
    assert pair(running, 3) == ["40F0F0C8F0F0F0F0", "C0F0F0F0F0640000"]
    assert pair(running, 4) == ["40F0F0F0F0F0F0F0", "C0F0F0F0F0F00000"]


def test_a_taxel_beyond_its_range_is_cut_and_marked(running: Mtb) -> None:
    running.taxels[0] = -5
    running.taxels[5] = 300
    running.taxels[11] = 256
    # bits 0, 5 and 11: 0x821 is 82 in byte 6 and 1 in the high half of byte 7
    assert pair(running, 0) == ["4000F0F0F0F0FFF0", "C0F0F0F0F0FF8210"]


def test_an_error_stands_in_the_last_nibble_and_repeats_the_last_values(running: Mtb) -> None:
    running.taxels[12] = 200
    period(running)
    running.triangle_errors[1] = 2
    running.taxels[12] = 100
    assert pair(running, 1) == ["40C8F0F0F0F0F0F0", "C0F0F0F0F0F00002"]
    running.triangle_errors[1] = 0
    assert pair(running, 1) == ["4064F0F0F0F0F0F0", "C0F0F0F0F0F00000"]


def test_five_read_errors_running_recalibrate_the_board(running: Mtb) -> None:
    period(running)
    running.taxels[0] = 180
    running.triangle_errors[7] = 1
    period(running, 4)
    running.triangle_errors[7] = 0
    period(running)
    assert running.patch.recalibrations == 0
    running.triangle_errors[7] = 1
    period(running, 5)
    running.triangle_errors[7] = 0
    assert running.patch.recalibrations == 1
    period(running, 3)
    assert pair(running, 0)[0] == "40F0F0F0F0F0F0F0"  # the press of 60 is the new no-load


def test_a_calibration_lasts_two_periods(running: Mtb) -> None:
    running.triangle_errors[0] = 1
    period(running, 4)
    while running.patch.recalibrations == 0:
        running.tick()
    assert [running.tick() for _ in range(80)] == [[]] * 80
    assert period(running) != []


def test_only_enabled_triangles_are_sent(running: Mtb) -> None:
    give(running, "50010E02000022")  # 1 to 14 off
    assert {can_id & 0xF for can_id, _ in period(running)} == {0, 15}


def test_no_load_defaults_to_245(mtb: Mtb) -> None:
    give(mtb, "0700")
    assert pair(mtb, 0)[0] == "40F5F5F5F5F5F5F5"


def test_old_style_set_up_sends_class_three(mtb: Mtb) -> None:
    give(mtb, "4C01010100220000")
    give(mtb, "4E0202F00003000A")  # triangles 0 and 1
    give(mtb, "0700")
    frames = period(mtb)
    assert frames[0] == (0x3E0, bytes.fromhex("40F0F0F0F0F0F0F0"))
    assert {can_id for can_id, _ in frames} == {0x3E0, 0x3E1}


def test_period_is_the_one_that_was_set(mtb: Mtb) -> None:
    give(mtb, "4D0014F0")  # 20 ms
    give(mtb, "0700")
    mtb.tick()
    assert len(period(mtb)) == 2 * 32


def test_accelerometer_and_gyroscope_of_the_worked_example(mtb: Mtb) -> None:
    mtb.acceleration_g[:] = [0.0, 0.0, 1.024]
    mtb.gyro_deg_s[:] = [100.0, -100.0, 0.0]
    give(mtb, "4F0C0A")
    sent = [mtb.tick() for _ in range(20)]
    sample = [
        (0x5E0, bytes.fromhex("A52C5BD30000")),
        (0x5E1, bytes.fromhex("000000000040")),
    ]
    assert sent == [*[[]] * 9, sample, *[[]] * 9, sample]


def test_analog_accelerometer_is_big_endian(mtb: Mtb) -> None:
    give(mtb, "4F0101")
    assert mtb.tick() == [(0x5E2, bytes.fromhex("000000003E80"))]


def test_mask_zero_stops_the_inertial_sensors(mtb: Mtb) -> None:
    give(mtb, "4F0C01")
    assert len(mtb.tick()) == 2
    give(mtb, "4F0001")
    assert mtb.tick() == []


def test_handshake_says_fw_2_11_0(mtb: Mtb) -> None:
    give(mtb, "1C0100")
    assert mtb.tick() == [(0x2E0, bytes.fromhex("1C05021100010001"))]


def test_a_discovery_stops_skin_and_inertial_sensors(running: Mtb) -> None:
    give(running, "4F0C0A")
    period(running)
    running.on_frame(0x70F, b"\xff")
    assert running.tick() == [(0x7E0, bytes.fromhex("FF05021100"))]
    assert period(running, 2) == []


def test_unchanged_taxels_are_not_packed_again(running: Mtb) -> None:
    period(running)
    assert running.patch.pair(3) is running.patch.pair(3)
