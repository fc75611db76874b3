"""The STRAIN board, bytes written by hand from the sheet (can-protocol 5 and 12)."""

import pytest

from firmware_sim.boards.board import BoardError
from firmware_sim.boards.strain import Strain
from firmware_sim.description import BoardSpec
from hal.wire.can import Frame

SPEC = BoardSpec(bus=2, address=13, type="strain", firmware=(3, 0))
FULL_SCALE = (1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0)
START = bytes.fromhex("0700")
ACK: Frame = (0x2D0, b"")


@pytest.fixture
def strain() -> Strain:
    board = Strain(SPEC, FULL_SCALE)
    board.tick()
    return board


def ask(board: Strain, data: str) -> list[Frame]:
    board.on_frame(0x20D, bytes.fromhex(data))
    return board.tick()


def test_tells_its_reset_once_and_is_silent_then() -> None:
    board = Strain(SPEC, FULL_SCALE)
    assert board.tick() == [(0x2D0, bytes.fromhex("010000000000"))]
    assert [board.tick() for _ in range(100)] == [[]] * 100
    board.power_cycle()
    assert len(board.tick()) == 1


def test_full_scales_are_big_endian_and_from_the_eeprom(strain: Strain) -> None:
    assert ask(strain, "1800") == [(0x2D0, bytes.fromhex("180005f1"))]
    assert ask(strain, "1805") == [(0x2D0, bytes.fromhex("18050016"))]


def test_settings_are_acknowledged_with_an_empty_frame(strain: Strain) -> None:
    assert ask(strain, "0801") == [ACK]
    assert ask(strain, "17000100") == [ACK]
    assert ask(strain, "1800") == [(0x2D0, bytes.fromhex("18000100"))]
    assert ask(strain, "0100") == [ACK]  # IIR: disabled, acknowledged


def test_unknown_commands_are_a_bug(strain: Strain) -> None:
    for code in (0x02, 0x06, 0x10, 0x4D, 0xEE):
        assert ask(strain, f"{code:02x}00") == [(0x2D0, bytes((code, 0x42, 0x55, 0x47)))]


def test_sends_force_before_torque_each_period(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    sample = [
        (0x3DA, bytes.fromhex("00803a7f4183")),
        (0x3DB, bytes.fromhex("c4832c7e2a81")),
    ]
    assert ask(strain, "0700") == [ACK, *sample]
    assert [strain.tick() for _ in range(3)] == [sample] * 3
    ask(strain, "0803")
    sent = [strain.tick() for _ in range(9)]
    assert [bool(frames) for frames in sent].count(True) == 3


def test_silent_mode_stops_the_stream(strain: Strain) -> None:
    ask(strain, "0700")
    assert ask(strain, "0701") == [ACK]
    assert strain.tick() == []


def test_a_discovery_stops_the_stream_until_the_next_tx_mode(strain: Strain) -> None:
    ask(strain, "0700")
    strain.on_frame(0x70F, b"\xff")
    assert strain.tick() == [(0x7D0, bytes.fromhex("ff06030005"))]
    assert strain.tick() == []
    assert len(ask(strain, "0700")) == 3


def test_saturation_repeats_the_last_good_sample_in_seven_bytes(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    ask(strain, "0700")
    strain.raw_adc[0] = 999
    assert strain.tick() == [
        (0x3DA, bytes.fromhex("00803a7f418305")),
        (0x3DB, bytes.fromhex("c4832c7e2a8101")),
    ]
    strain.raw_adc[0] = 1000
    strain.raw_adc[5] = 64001
    assert [data[6] for _, data in strain.tick()] == [0x01, 0x81]
    strain.raw_adc[5] = 64000
    assert [len(data) for _, data in strain.tick()] == [6, 6]


def test_raw_and_combined_streams(strain: Strain) -> None:
    strain.memory.matrix[0][0] = 0x4000
    strain.raw_adc[:] = [0x9000] * 6
    (force, _) = ask(strain, "0703")[1:]
    assert force == (0x3DA, bytes.fromhex("009000900090"))
    frames = ask(strain, "0704")[1:]
    assert [can_id for can_id, _ in frames] == [0x3DA, 0x3DB, 0x3D8, 0x3D9]
    assert frames[0][1] == bytes.fromhex("008800900090")  # first row halved
    assert frames[2][1] == bytes.fromhex("009000900090")


@pytest.mark.parametrize("word", [1000, 0x4000, 0x4001, 0x7FFF, 0x8000, 0xC000, 0xC001, 64000])
def test_the_factory_matrix_is_the_same_by_both_ways(strain: Strain, word: int) -> None:
    strain.raw_adc[:] = [word] * 6
    value = word - 0x8000
    expected = (value * 0x7FFF + 0x4000 >> 15) + 0x8000
    assert ask(strain, "0700")[1][1][:2] == expected.to_bytes(2, "little")


def test_matrix_rows_mix_channels(strain: Strain) -> None:
    assert ask(strain, "0A0000") == [(0x2D0, bytes.fromhex("0a00007fff"))]
    assert ask(strain, "030001c000") == [ACK]  # -0.5 of Fy into Fx
    strain.raw_adc[:] = [0x8100, 0x8100, 0x8000, 0x8000, 0x8000, 0x8000]
    force = ask(strain, "0700")[1][1]
    assert force == bytes.fromhex("808000810080")


def test_tares(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8010] * 6
    assert ask(strain, "1301000000") == [ACK]  # minus the present converter value
    assert ask(strain, "1400") == [(0x2D0, bytes.fromhex("1400fff0"))]
    assert ask(strain, "1502000064") == [ACK]  # 100 added to the calibrated Fx
    assert ask(strain, "0700")[1][1] == bytes.fromhex("648000800080")
    assert ask(strain, "0C0001")[0] == (0x2D0, bytes.fromhex("0c00018064"))
    ask(strain, "1300000000")
    ask(strain, "1500000000")
    assert strain.tick()[0][1] == bytes.fromhex("108010801080")


def test_the_eeprom_keeps_what_was_saved_but_no_present_tare(strain: Strain) -> None:
    ask(strain, "17000064")
    ask(strain, "1502000064")
    assert ask(strain, "1B") == [(0x2D0, b"\x1b\x00")]
    assert ask(strain, "09") == [(0x2D0, b"\x09\x01")]
    assert ask(strain, "1B") == [(0x2D0, b"\x1b\x01")]
    ask(strain, "170000c8")
    strain.power_cycle()
    strain.tick()
    assert ask(strain, "1800") == [(0x2D0, bytes.fromhex("18000064"))]
    assert ask(strain, "1600") == [(0x2D0, bytes.fromhex("16000000"))]


def test_handshake_needs_the_same_protocol(strain: Strain) -> None:
    assert ask(strain, "1C0100") == [(0x2D0, bytes.fromhex("1c06030005010001"))]
    assert ask(strain, "1C0106") == [(0x2D0, bytes.fromhex("1c06030005010000"))]


def test_serial_number(strain: Strain) -> None:
    assert ask(strain, "19534E3032330000") == [ACK]
    assert ask(strain, "1A") == [(0x2D0, bytes.fromhex("1a534e3032330000"))]


def test_hears_only_its_own_commands(strain: Strain) -> None:
    assert [can_id for can_id in range(0x800) if strain.accepts(can_id)] == [
        *(0x200 | source << 4 | 13 for source in range(16)),
        0x70D,
        0x70F,
    ]
    strain.on_frame(0x20C, START)
    assert strain.tick() == []


@pytest.mark.parametrize("off", ["bus_off", "powered"])
def test_silent_without_bus_or_power(strain: Strain, off: str) -> None:
    ask(strain, "0700")
    setattr(strain, off, off == "bus_off")
    assert ask(strain, "1800") == []


def test_no_bytes_can_break_it(strain: Strain) -> None:
    for code in range(256):
        for fill in (0x00, 0x7F, 0xFF):
            for length in range(8):
                strain.on_frame(0x20D, bytes((code, *[fill] * length)))
                strain.tick()
    strain.on_frame(0x20D, b"")
    strain.on_frame(0x70D, b"")
    assert strain.tick() is not None


def test_six_full_scales_are_needed() -> None:
    with pytest.raises(BoardError, match="six full scales, not 3"):
        Strain(SPEC, FULL_SCALE[:3])


def test_a_stuck_gauge_saturates_its_channel_whatever_the_others_do(strain: Strain) -> None:
    ask(strain, "0700")
    strain.stuck_words = {4: 65000}
    strain.raw_adc[:] = [0x8100] * 6
    assert [data[6] for _, data in strain.tick()] == [0x01, 0x21]
    strain.stuck_words = {}
    assert [len(data) for _, data in strain.tick()] == [6, 6]


def test_a_frozen_sensor_repeats_its_last_sample_without_a_mark(strain: Strain) -> None:
    strain.raw_adc[:] = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    ask(strain, "0700")
    strain.frozen = True
    strain.raw_adc[:] = [0xFFFF] * 6
    sample = [
        (0x3DA, bytes.fromhex("00803a7f4183")),
        (0x3DB, bytes.fromhex("c4832c7e2a81")),
    ]
    assert [strain.tick() for _ in range(50)] == [sample] * 50
    strain.frozen = False
    assert [data[6] for _, data in strain.tick()] == [0xA9, 0xA9]
