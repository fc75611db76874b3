"""What STRAIN2 and the IMU board do, bytes written by hand from the sheet (can-protocol 5, 7.2)."""

import math

import pytest

from firmware_sim.boards.imu import Imu
from firmware_sim.boards.inertial_unit import euler_deg, gravity_m_s2
from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.boards.strain2 import Strain2
from firmware_sim.description import BoardSpec
from hal.wire.can import Frame

FULL_SCALE = (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0)


@pytest.fixture
def strain2() -> Strain2:
    return Strain2(BoardSpec(bus=3, address=13, type="strain2", firmware=(1, 0)), FULL_SCALE)


@pytest.fixture
def imu() -> Imu:
    return Imu(BoardSpec(bus=0, address=14, type="imu", firmware=(1, 0)))


def ask(board: SensorBoard, data: str) -> list[Frame]:
    board.on_frame(0x200 | board.addresses[0], bytes.fromhex(data))
    return board.tick()


def test_says_nothing_at_boot_and_acknowledges_no_setting(strain2: Strain2) -> None:
    assert strain2.tick() == []
    for data in ("0801", "0701", "17000100", "13000000", "3310", "EE00"):
        assert not any(len(sent) == 0 for _, sent in ask(strain2, data)), data


def test_unknown_command_gets_no_answer(strain2: Strain2) -> None:
    assert ask(strain2, "EE00") == []
    assert strain2.dropped["unknown"] == 1


def test_handshake_says_type_12(strain2: Strain2) -> None:
    assert ask(strain2, "1C0100") == [(0x2D0, bytes.fromhex("1C0C010000010001"))]


def test_streams_the_frames_of_strain(strain2: Strain2) -> None:
    strain2.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    assert ask(strain2, "0700") == [
        (0x3DA, bytes.fromhex("00803a7f4183")),
        (0x3DB, bytes.fromhex("c4832c7e2a81")),
    ]


def test_a_channel_without_a_set_means_the_set_in_use(strain2: Strain2) -> None:
    assert ask(strain2, "1800") == [(0x2D0, bytes.fromhex("180005F1"))]


def test_the_high_half_of_the_channel_names_a_set(strain2: Strain2) -> None:
    ask(strain2, "1720012C")  # set 2, channel 0: 300 N
    assert ask(strain2, "1820") == [(0x2D0, bytes.fromhex("1820012C"))]
    assert ask(strain2, "1800") == [(0x2D0, bytes.fromhex("180005F1"))]
    ask(strain2, "3D20")  # use set 2 for now
    assert ask(strain2, "1800") == [(0x2D0, bytes.fromhex("1800012C"))]
    assert ask(strain2, "3E00") == [(0x2D0, bytes.fromhex("3E20"))]
    assert ask(strain2, "3E01") == [(0x2D0, bytes.fromhex("3E11"))]


def test_matrix_and_tare_carry_the_set_too(strain2: Strain2) -> None:
    ask(strain2, "0330010123")  # set 3, row 0, column 1
    assert ask(strain2, "0A3001") == [(0x2D0, bytes.fromhex("0A30010123"))]
    assert ask(strain2, "0A0001") == [(0x2D0, bytes.fromhex("0A00010000"))]
    ask(strain2, "1302320007")  # set 3, channel 2
    assert ask(strain2, "1432") == [(0x2D0, bytes.fromhex("14320007"))]
    assert ask(strain2, "1402") == [(0x2D0, bytes.fromhex("14020000"))]


def test_a_set_that_does_not_exist_is_dropped(strain2: Strain2) -> None:
    assert ask(strain2, "1840") == []
    assert ask(strain2, "3D40") == []
    assert strain2.dropped["regulation set"] == 2


def test_save_keeps_every_set_and_the_permanent_choice(strain2: Strain2) -> None:
    ask(strain2, "1720012C")
    ask(strain2, "3D21")
    assert ask(strain2, "1B") == [(0x2D0, bytes.fromhex("1B00"))]
    assert ask(strain2, "09") == [(0x2D0, bytes.fromhex("0901"))]
    assert ask(strain2, "1B") == [(0x2D0, bytes.fromhex("1B01"))]
    ask(strain2, "17100001")
    strain2.power_cycle()
    assert ask(strain2, "1800") == [(0x2D0, bytes.fromhex("1800012C"))]
    assert ask(strain2, "1810") == [(0x2D0, bytes.fromhex("181005F1"))]


def test_amplifier_settings_are_little_endian_and_told(strain2: Strain2) -> None:
    assert ask(strain2, "2001") == [(0x2D0, bytes.fromhex("200140060080"))]  # 16.00, half scale
    ask(strain2, "2101002C010010")  # gain 3.00, offset 0x1000
    assert ask(strain2, "2001") == [(0x2D0, bytes.fromhex("20012C010010"))]
    assert ask(strain2, "2002") == [(0x2D0, bytes.fromhex("200240060080"))]
    ask(strain2, "1D0F")  # every channel reset
    assert ask(strain2, "2001") == [(0x2D0, bytes.fromhex("200140060080"))]


def test_amplifier_registers_and_offset_calibration(strain2: Strain2) -> None:
    ask(strain2, "2B0034120305CDAB")
    assert ask(strain2, "2A00") == [(0x2D0, bytes.fromhex("2A0034120305CDAB"))]
    assert ask(strain2, "220F000080640000") == [(0x2D0, bytes.fromhex("220F003F3F000000"))]


def test_thermometer_sends_each_so_many_seconds(strain2: Strain2) -> None:
    strain2.temperature_degc = 31.5
    ask(strain2, "3901")
    assert ask(strain2, "38") == [(0x2D0, bytes.fromhex("3801"))]
    ask(strain2, "3A02")  # 2 s
    sent = [strain2.tick() for _ in range(4000)]
    readings = [i for i, frames in enumerate(sent) if frames]
    assert readings == [1998, 3998]
    assert sent[1998] == [(0x3DE, bytes.fromhex("013B010000"))]


def test_strain2_has_an_imu_beside_its_gauges(strain2: Strain2) -> None:
    ask(strain2, "3401000000000000")
    sent = ask(strain2, "3501")
    assert sent == [(0x5D3, bytes.fromhex("010000000000D503"))]


def test_imu_sends_what_its_mask_selects_with_one_number_per_acquisition(imu: Imu) -> None:
    imu.gyro_deg_s[:] = [10.0, -10.0, 0.0]
    imu.magnetic_ut[:] = [20.0, 0.0, -40.0]
    ask(imu, "3417800000000000")
    assert ask(imu, "33") == [(0x2E0, bytes.fromhex("3317800000000000"))]
    sent = ask(imu, "350A") + [frame for _ in range(19) for frame in imu.tick()]
    assert sent[:5] == [
        (0x5E3, bytes.fromhex("010000000000D503")),  # 9.81 m/s2
        (0x5E3, bytes.fromhex("01014001000080FD")),  # 320, 0, -640
        (0x5E3, bytes.fromhex("0102A00060FF0000")),  # 160, -160, 0
        (0x5E4, bytes.fromhex("0040000000000000")),
        (0x5E5, bytes.fromhex("0103030308070000")),
    ]
    assert [data[0] for can_id, data in sent if can_id == 0x5E3] == [1, 1, 1, 2, 2, 2]
    assert ask(imu, "3500") == []
    assert [imu.tick() for _ in range(30)] == [[]] * 30


def test_imu_number_wraps_after_255(imu: Imu) -> None:
    ask(imu, "3401000000000000")
    numbers = [ask(imu, "3501")[0][1][0], *(imu.tick()[0][1][0] for _ in range(300))]
    assert numbers[254:257] == [255, 0, 1]


def test_imu_board_reports_the_type_of_rfe(imu: Imu) -> None:
    assert ask(imu, "1C0100") == [(0x2E0, bytes.fromhex("1C0D010000010001"))]
    imu.on_frame(0x70F, b"\xff")
    assert imu.tick() == [(0x7E0, bytes.fromhex("FF0D010000"))]


def test_gravity_and_euler_angles_follow_from_the_quaternion() -> None:
    half = math.sqrt(0.5)
    quarter_about_x = [half, half, 0.0, 0.0]
    assert gravity_m_s2(quarter_about_x) == pytest.approx([0.0, 9.80665, 0.0], abs=1e-9)
    assert euler_deg(quarter_about_x) == pytest.approx([0.0, 90.0, 0.0], abs=1e-9)
    quarter_back_about_z = [half, 0.0, 0.0, -half]
    assert euler_deg(quarter_back_about_z) == pytest.approx([270.0, 0.0, 0.0])
