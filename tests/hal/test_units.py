"""Conversions, checked with the worked examples of the CAN protocol's fact sheet, section 12."""

import math

import pytest

from hal.description import TorqueSource
from hal.units import AxisUnits, move_duration_ns, move_speed_counts
from tests.hal.arm import joint

RIGHT_PITCH = AxisUnits(joint("pitch", 1, 0), velocity_shift=8)
LEFT_PITCH = AxisUnits(joint("pitch", 1, 0, ticks_per_deg=-11.375, zero_deg=-185.0), 8)
SOURCE = TorqueSource(address=12, channel=0, full_scale_nm=8.0)
TORQUE = AxisUnits(joint("pitch", 1, 0, torque_source=SOURCE), 8)
NEGATIVE = AxisUnits(joint("pitch", 1, 0, torque_source=SOURCE, ticks_per_deg=-11.375), 8)


def test_reads_zero_degrees_of_the_left_shoulder_pitch_at_2104_ticks() -> None:
    assert LEFT_PITCH.q_rad(2104) == pytest.approx(0.0, abs=math.radians(0.05))


def test_turns_an_angle_into_ticks_rounded_half_away_from_zero() -> None:
    assert LEFT_PITCH.ticks(0.0) == 2104
    assert LEFT_PITCH.ticks(math.radians(20.0)) == 1877  # 1876.875


def test_turns_the_ticks_and_angles_of_the_left_arm_of_examples_15_and_17() -> None:
    roll = AxisUnits(joint("roll", 1, 1, ticks_per_deg=-11.375, zero_deg=-330.0), 8)
    elbow = AxisUnits(joint("elbow", 2, 1, ticks_per_deg=-11.375, zero_deg=-181.0), 8)
    assert roll.q_rad(3526) == pytest.approx(math.radians(20.0), abs=math.radians(0.05))
    assert elbow.ticks(math.radians(60.0)) == 1376


def test_swaps_the_limits_of_a_negative_factor() -> None:
    assert (LEFT_PITCH.low_ticks, LEFT_PITCH.high_ticks) == (1991, 3191)


def test_keeps_the_limits_of_a_positive_factor() -> None:
    assert (RIGHT_PITCH.low_ticks, RIGHT_PITCH.high_ticks) == (927, 2127)


def test_limits_an_angle_outside_the_range() -> None:
    assert RIGHT_PITCH.limited_ticks(math.radians(90.0)) == 2127
    assert RIGHT_PITCH.limited_ticks(math.radians(-100.0)) == 927


def test_turns_10_deg_s_into_29_counts_of_velocity_with_shift_8() -> None:
    assert RIGHT_PITCH.velocity_counts(math.radians(10.0)) == 29


def test_turns_1_nm_into_4096_torque_units_for_a_full_scale_of_8() -> None:
    assert TORQUE.torque_counts(1.0) == 4096
    assert TORQUE.torque_counts(-8.0) == -32768
    assert TORQUE.torque_counts(8.0) == 32767


def test_turns_stiffness_and_damping_into_the_bytes_of_example_20() -> None:
    assert TORQUE.stiffness_counts(0.4) == 144
    assert TORQUE.damping_counts(0.03) == 10803


def test_gives_stiffness_the_sign_of_the_ticks_and_torque_the_sign_of_the_joint() -> None:
    assert NEGATIVE.stiffness_counts(0.4) == -144
    assert NEGATIVE.torque_counts(1.0) == 4096


def test_never_moves_faster_at_its_peak_than_the_joint_may() -> None:
    assert RIGHT_PITCH.max_move_speed_counts == 36  # 60 deg/s: 364 ticks/s on average


def test_moves_113_ticks_in_one_second_with_speed_11() -> None:
    assert move_speed_counts(114, 1.0) == 11
    assert move_speed_counts(-114, 1.0) == 11
    assert move_duration_ns(-114, 11) == 1_036_363_636


def test_moves_a_little_with_speed_1_and_never_beyond_the_word() -> None:
    assert move_speed_counts(3, 10.0) == 1
    assert move_speed_counts(10_000_000, 0.1) == 0x7FFF
    assert move_speed_counts(5, 0.0) == 0x7FFF
