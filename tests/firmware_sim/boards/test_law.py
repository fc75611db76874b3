"""Integer arithmetic of the boards' laws (can-protocol 9.3)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.boards.fields import DERIVATIVE, MEAN_LIVE, POSITION_PID
from firmware_sim.boards.kernel_law import Row, step_mean, step_pid
from firmware_sim.boards.law import clamp, divide, saturate_i16, saturate_i32, shift_right
from firmware_sim.boards.pid import Pid
from tests.firmware_sim.boards.rows import row_of_words

MEAN = POSITION_PID + DERIVATIVE
BIG = st.integers(-(2**40), 2**40)


def pid(samples: int = 10, **gains: int) -> Pid:
    made = Pid(POSITION_PID)
    made.attach(row_of_words(samples))
    made.boot(kp=0, kd=0, ki=0, shift=0)
    made.output_limit = 0x7FFF
    for name, value in gains.items():
        setattr(made, name, value)
    return made


def step(loop: Pid, error: int) -> int:
    return step_pid(loop.row, POSITION_PID, error, error - loop.error)


@pytest.mark.parametrize(
    ("value", "bits", "shifted"), [(7, 1, 3), (-7, 1, -3), (-1, 13, 0), (-8192, 13, -1), (5, 0, 5)]
)
def test_shifts_go_towards_zero(value: int, bits: int, shifted: int) -> None:
    assert shift_right(value, bits) == shifted


@given(BIG, st.integers(0, 31))
def test_shifts_are_sign_symmetric(value: int, bits: int) -> None:
    assert shift_right(-value, bits) == -shift_right(value, bits) == -int(value / 2**bits)


@given(BIG, st.integers(1, 100))
def test_divisions_go_towards_zero(value: int, divisor: int) -> None:
    assert divide(value, divisor) == int(value / divisor)


def test_saturation() -> None:
    assert [saturate_i16(v) for v in (40000, 32767, -32768, -40000)] == [
        32767,
        32767,
        -32768,
        -32768,
    ]
    assert [saturate_i32(v) for v in (2**31, -(2**31) - 1)] == [2**31 - 1, -(2**31)]
    assert [clamp(v, 10) for v in (11, -11, 3)] == [10, -10, 3]
    assert clamp(5, -1) == 0


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=60), st.integers(1, 10))
def test_mean_of_the_last_samples(values: list[int], samples: int) -> None:
    row: Row = row_of_words(samples)
    padded = [0] * samples + values
    for index, value in enumerate(values, 1):
        expected = int(sum(padded[index : index + samples]) / samples)
        # the shortcut that the loops take
        assert (step_mean(row, MEAN, value) if value or row[MEAN + MEAN_LIVE] else 0) == expected


def test_shoulder_gain_gives_its_pwm_per_tick() -> None:
    assert step(pid(kp=32000, shift=13), 1) == 3  # 3.9 towards zero
    assert step(pid(kp=32000, shift=13), -1) == -3
    assert step(pid(kp=-32000, shift=13), 10) == -39


def test_a_small_derivative_gain_vanishes_in_the_shift() -> None:
    assert step(pid(kd=50, shift=13), 163) == 0
    assert step(pid(kd=50, shift=13), 1640) == 1  # 10 counts over 10 ms


def test_the_derivative_is_a_mean_of_shifted_terms() -> None:
    loop = pid(kd=6000, shift=13)
    # 2 ticks: 12000 >> 13 = 1, and 1 / 10 is 0 for its ten milliseconds
    assert [step(loop, 2) for _ in range(12)] == [0] * 12
    loop = pid(kd=6000, shift=13)
    # 40 ticks: 29 spread over ten milliseconds
    assert [step(loop, 40) for _ in range(12)] == [2] * 10 + [0] * 2


def test_the_derivative_of_a_4dc_is_one_pulse() -> None:
    loop = pid(samples=1, kd=10000, shift=7)
    assert [step(loop, error) for error in (1, 1, 0)] == [78, 0, -78]


def test_the_integral_drops_when_it_reaches_its_limit() -> None:
    loop = pid(ki=4096, shift=8, integral_limit=40)
    # 16 counts a millisecond; beyond 40 the accumulator itself becomes 40, unshifted
    assert [step(loop, 1) for _ in range(7)] == [16, 32, 40, 16, 32, 40, 16]


def test_a_limited_output_does_not_charge_the_integral() -> None:
    loop = pid(kp=100, ki=256, shift=8)
    loop.output_limit = 50
    for _ in range(100):
        assert loop.step_limited(1000) == 50
    assert loop.integral == 0
    assert loop.step_limited(10) == 13  # 3 and 10: charges again within the limit


def test_a_limited_output_lets_the_integral_unwind() -> None:
    loop = pid(ki=256, shift=8)
    loop.output_limit = 50
    loop.integral = 100 << 8
    assert loop.step_limited(-5) == 50
    assert loop.integral == 95 << 8


def test_offset_and_extra_term_are_inside_the_limit() -> None:
    loop = pid(kp=1)
    loop.offset = 7
    loop.output_limit = 20
    assert loop.step_limited(3, 5) == 15
    assert loop.step_limited(3, 50) == 20
