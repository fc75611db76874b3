"""Torque loop and impedance against the sheet's numbers (can-protocol 6, 9.1 and example 20)."""

import pytest

from firmware_sim.boards.torque import FILTER_3_HZ, Impedance, LowPass, TorqueLoop


def shoulder() -> TorqueLoop:
    loop = TorqueLoop(samples=10)
    loop.pid.kp = 76
    loop.pid.shift = 14
    return loop


def test_proportional_and_feed_forward_share_the_shift() -> None:
    loop = shoulder()
    assert loop.step(4096, 0) == 76 * 4096 >> 14 == 19
    loop.kff = 19
    loop.kff_shift = 3  # stored, never used
    assert loop.step(4096, 0) == 19 + (19 * 4096 >> 14) == 23
    assert loop.step(-4096, 0) == -19 - 4
    assert loop.step(4096, 4096) == 4


def test_torque_errors_saturate_at_sixteen_bits() -> None:
    loop = shoulder()
    loop.step(30000, -30000)
    assert loop.pid.error == 32767
    loop.step(-4_000_000, 30000)
    assert loop.pid.error == -32768


def test_a_desired_torque_saturates_before_it_is_fed_forward() -> None:
    loop = shoulder()
    loop.kff = 19
    assert loop.step(4_000_000, 32767) == 19 * 32767 >> 14


def test_the_filter_passes_63_percent_of_a_step_in_its_time_constant() -> None:
    loop = shoulder()
    loop.filter = FILTER_3_HZ
    outputs = [loop.step(32000, 0) for _ in range(1000)]  # 148 counts unfiltered
    assert outputs[0] == 3  # 1.87 % of 148
    assert outputs[52] == pytest.approx(0.632 * 148, abs=1)  # 1 / (2 pi 3 Hz) = 53 ms
    assert outputs[-1] == 148


def test_the_filter_settles_from_both_sides_without_a_remainder() -> None:
    for start in (-200, 200):
        low_pass = LowPass()
        low_pass.start(start)
        outputs = [low_pass.step(7) for _ in range(2000)]
        assert outputs[-1] == 7


def test_the_filter_can_start_from_a_running_pwm() -> None:
    low_pass = LowPass()
    low_pass.start(150)
    assert [low_pass.step(150) for _ in range(3)] == [150] * 3


def test_back_emf_gain_of_the_shoulder() -> None:
    loop = shoulder()
    loop.bemf = 18460
    loop.bemf_shift = 7
    # one tick per millisecond is 32 at estimator shift 5: 0.9 x 160 counts
    assert loop.back_emf(32, 5) == 144
    assert loop.back_emf(-32, 5) == -144


def test_stiffness_of_the_sheet() -> None:
    spring = Impedance(samples=10)
    spring.stiffness = 144  # 0.4 Nm/deg at TorqueMax 8
    assert spring.torque(11) == -144 * 11
    spring.offset = 1000
    assert spring.torque(-11) == 1000 + 144 * 11


def test_damping_is_one_tick_per_millisecond_times_the_raw_value() -> None:
    spring = Impedance(samples=10)
    spring.damping = 10803  # 0.03 Nms/deg at TorqueMax 8
    outputs = [spring.torque(deviation) for deviation in range(1, 21)]
    assert outputs[0] == -1080
    assert outputs[9:] == [-10803] * 11  # ten milliseconds later: the whole speed


def test_one_tick_is_a_tenth_of_the_damping_for_ten_milliseconds() -> None:
    spring = Impedance(samples=10)
    spring.damping = 10803
    assert [spring.torque(1) for _ in range(12)] == [-1080] * 10 + [0, 0]


def test_a_4dc_does_not_average_its_damping() -> None:
    spring = Impedance(samples=1)
    spring.damping = 100
    assert [spring.torque(1) for _ in range(3)] == [-100, 0, 0]
