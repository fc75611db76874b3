"""Skin, inertial and Hall frames against the examples and tables of can-protocol 5.4, 7 and 12."""

import pytest

from hal.wire import inertial, mais, skin
from hal.wire.can import CLASS_ANALOG_PERIODIC, Frame
from hal.wire.inertial import ImuKind
from hal.wire.layout import WireError


def frame(text: str) -> Frame:
    can_id, _, data = text.partition(" ")
    return int(can_id, 16), bytes.fromhex(data)


def test_accelerometer_of_mtb_14_shows_one_g() -> None:
    assert inertial.ACCELEROMETER.frame(14, 0, 0, 16384) == frame("5E1 000000000040")
    assert inertial.ACCELEROMETER.parse(bytes.fromhex("000000000040")) == (0, 0, 16384)


def test_gyroscope_is_little_endian_and_signed() -> None:
    # 100 deg/s is 11429 counts of 8.75 mdeg/s, 0x2CA5
    assert inertial.GYROSCOPE.frame(14, 11429, -11429, 1) == frame("5E0 A52C5BD30100")
    assert pytest.approx(11428.57, abs=0.01) == inertial.MTB_COUNTS_PER_DEG_S * 100.0


def test_analog_accelerometer_has_the_high_byte_first() -> None:
    assert inertial.ANALOG_ACCELEROMETER.frame(5, 0x0102, -2, 0) == frame("552 0102FFFE0000")
    assert inertial.ANALOG_ACCELEROMETER.parse(bytes.fromhex("0102FFFE0000")) == (0x0102, -2, 0)


def test_imu_triple_carries_sequence_and_sensor() -> None:
    # 9.81 m/s2 x 100 = 981 = 0x03D5
    sent = inertial.IMU_TRIPLE.frame(14, 7, ImuKind.ACCELEROMETER, 0, -1, 981)
    assert sent == frame("5E3 07000000FFFFD503")
    assert inertial.IMU_TRIPLE.parse(sent[1]) == (7, 0, 0, -1, 981)


def test_imu_quaternion_of_no_rotation() -> None:
    assert inertial.IMU_QUATERNION.frame(13, 16384, 0, 0, 0) == frame("5D4 0040000000000000")


def test_imu_status_ends_in_the_acquisition_time() -> None:
    sent = inertial.IMU_STATUS.frame(13, 255, 3, 2, 1, 1_000_000)
    assert sent == frame("5D5 FF03020140420F00")
    assert inertial.IMU_STATUS.parse(sent[1]) == (255, 3, 2, 1, 1_000_000)


def test_inertial_frame_of_wrong_length_is_no_message() -> None:
    for kind, message in inertial.MESSAGES.items():
        assert message.parse(bytes(7)) is None, kind
        assert message.layout.dlc == (6 if kind < 3 else 8)


def test_triangle_3_of_mtb_14_at_rest() -> None:
    rest = (0xF0,) * 7
    head = frame("4E3 40F0F0F0F0F0F0F0")
    tail = frame("4E3 C0F0F0F0F0F00000")
    assert skin.HEAD.frame(14, 3, *rest) == head
    assert skin.TAIL.frame(14, 3, *rest[:5], 0, 0) == tail
    assert skin.HEAD.parse(head[1]) == rest
    assert skin.TAIL.parse(tail[1]) == (*rest[:5], 0, 0)


def test_old_style_skin_has_class_three() -> None:
    sent = skin.HEAD.frame(14, 3, *range(7), can_class=CLASS_ANALOG_PERIODIC)
    assert sent == frame("3E3 4000010203040506")


def test_a_frame_with_another_first_byte_or_length_is_no_part_of_a_triangle() -> None:
    assert skin.HEAD.parse(bytes.fromhex("C0F0F0F0F0F0F0F0")) is None
    assert skin.TAIL.parse(bytes.fromhex("40F0F0F0F0F00000")) is None
    assert skin.TAIL.parse(bytes.fromhex("C0F0F0F0F0F000")) is None
    assert skin.HEAD.parse(b"") is None


def test_out_of_range_mask_is_split_over_two_bytes() -> None:
    # taxels 0, 5 and 11: mask 0x821; bits 11..4 = 0x82, bits 3..0 = 1; error 2
    assert skin.tail_state(0x821, 2) == (0x82, 0x12)
    assert skin.out_of_range(0x82, 0x12) == 0x821
    assert skin.error_of(0x12) == skin.TriangleError.NOT_CONNECTED


def test_taxel_that_does_not_fit_is_named() -> None:
    with pytest.raises(WireError, match="TRIANGLE_HEAD: taxel1 = 256 does not fit u8"):
        skin.HEAD.frame(14, 0, 0, 256, 0, 0, 0, 0, 0)


def test_hall_frames_of_the_left_hand() -> None:
    first = mais.HALL_0_6.frame(14, 16, 255, 255, 240, 255, 255, 248)
    assert first == frame("3EC 10FFFFF0FFFFF8")
    assert mais.HALL_0_6.parse(first[1]) == (16, 255, 255, 240, 255, 255, 248)
    assert mais.HALL_7_14.frame(14, *range(7, 15)) == frame("3ED 0708090A0B0C0D0E")


def test_hall_words_are_little_endian_in_four_frames() -> None:
    assert mais.HALL_WORDS_0_3.frame(14, 0x0FFF, 1, 2, 3) == frame("3EC FF0F010002000300")
    assert mais.HALL_WORDS_12_14.frame(14, 12, 13, 14) == frame("3EF 0C000D000E000000")
    assert [message.layout.dlc for message in mais.WORD_MESSAGES.values()] == [8, 8, 8, 8]
    assert sum(len(message.layout.fields) for message in mais.WORD_MESSAGES.values()) == 15
