"""Torque loop and impedance against the sheet's numbers (can-protocol 6, 9.1 and example 20)."""

import pytest

from firmware_sim.boards.kernel_law import (
    FILTER_3_HZ,
    back_emf,
    impedance_torque,
    low_pass,
    torque_pwm,
)
from firmware_sim.boards.torque import Impedance, TorqueLoop
from tests.firmware_sim.boards.rows import row_of_words


def shoulder() -> TorqueLoop:
    loop = TorqueLoop()
    loop.attach(row_of_words())
    loop.boot()
    loop.pid.kp = 76
    loop.pid.shift = 14
    return loop


def impedance(samples: int = 10) -> Impedance:
    made = Impedance()
    made.attach(row_of_words(samples))
    return made


def test_proportional_and_feed_forward_share_the_shift() -> None:
    loop = shoulder()
    assert torque_pwm(loop.row, 4096, 0) == 76 * 4096 >> 14 == 19
    loop.kff = 19
    loop.kff_shift = 3  # stored, never used
    assert torque_pwm(loop.row, 4096, 0) == 19 + (19 * 4096 >> 14) == 23
    assert torque_pwm(loop.row, -4096, 0) == -19 - 4
    assert torque_pwm(loop.row, 4096, 4096) == 4


def test_torque_errors_saturate_at_sixteen_bits() -> None:
    loop = shoulder()
    torque_pwm(loop.row, 30000, -30000)
    assert loop.pid.error == 32767
    torque_pwm(loop.row, -4_000_000, 30000)
    assert loop.pid.error == -32768


def test_a_desired_torque_saturates_before_it_is_fed_forward() -> None:
    loop = shoulder()
    loop.kff = 19
    assert torque_pwm(loop.row, 4_000_000, 32767) == 19 * 32767 >> 14


def test_the_filter_passes_63_percent_of_a_step_in_its_time_constant() -> None:
    loop = shoulder()
    loop.filter = FILTER_3_HZ
    outputs = [torque_pwm(loop.row, 32000, 0) for _ in range(1000)]  # 148 counts unfiltered
    assert outputs[0] == 3  # 1.87 % of 148
    assert outputs[52] == pytest.approx(0.632 * 148, abs=1)  # 1 / (2 pi 3 Hz) = 53 ms
    assert outputs[-1] == 148


def test_the_filter_settles_from_both_sides_without_a_remainder() -> None:
    for start in (-200, 200):
        loop = shoulder()
        loop.start_filter(start)
        outputs = [low_pass(loop.row, 7) for _ in range(2000)]
        assert outputs[-1] == 7


def test_the_filter_can_start_from_a_running_pwm() -> None:
    loop = shoulder()
    loop.start_filter(150)
    assert [low_pass(loop.row, 150) for _ in range(3)] == [150] * 3


def test_back_emf_gain_of_the_shoulder() -> None:
    loop = shoulder()
    loop.bemf = 18460
    loop.bemf_shift = 7
    # one tick per millisecond is 32 at estimator shift 5: 0.9 x 160 counts
    assert back_emf(loop.row, 32) == 144
    assert back_emf(loop.row, -32) == -144


def test_stiffness_of_the_sheet() -> None:
    spring = impedance(samples=10)
    spring.stiffness = 144  # 0.4 Nm/deg at TorqueMax 8
    assert impedance_torque(spring.row, 11) == -144 * 11
    spring.offset = 1000
    assert impedance_torque(spring.row, -11) == 1000 + 144 * 11


def test_damping_is_one_tick_per_millisecond_times_the_raw_value() -> None:
    spring = impedance(samples=10)
    spring.damping = 10803  # 0.03 Nms/deg at TorqueMax 8
    outputs = [impedance_torque(spring.row, deviation) for deviation in range(1, 21)]
    assert outputs[0] == -1080
    assert outputs[9:] == [-10803] * 11  # ten milliseconds later: the whole speed


def test_one_tick_is_a_tenth_of_the_damping_for_ten_milliseconds() -> None:
    spring = impedance(samples=10)
    spring.damping = 10803
    assert [impedance_torque(spring.row, 1) for _ in range(12)] == [-1080] * 10 + [0, 0]


def test_a_4dc_does_not_average_its_damping() -> None:
    spring = impedance(samples=1)
    spring.damping = 100
    assert [impedance_torque(spring.row, 1) for _ in range(3)] == [-100, 0, 0]
