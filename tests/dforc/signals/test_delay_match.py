"""One filter for motion and wrenches: same delay, same factor."""

import math

import numpy as np
import pytest

from benchmarks.ft_rows import phantom_forces_n
from dforc.arrays import Vector
from dforc.errors import NotFiniteError
from dforc.signals.delay_match import DELAY_S, MatchedFilter, MatchedMotion, NoSampleError
from dforc.signals.differentiation import QUANTUM_RAD

W = 2.0 * math.pi


def uneven_instants(count: int) -> Vector:
    steps: Vector = np.random.default_rng(0).uniform(0.003, 0.013, count)
    return np.cumsum(steps)


def test_straight_line_comes_out_delayed_and_otherwise_unchanged() -> None:
    motion = MatchedMotion(1)
    for t in uneven_instants(100).tolist():
        motion.push([0.2 + 0.3 * t], t)
    q, dq, ddq = motion.motion(t)
    assert q == pytest.approx([0.2 + 0.3 * (t - DELAY_S)], abs=1e-12)
    assert dq == pytest.approx([0.3], abs=1e-10)
    assert ddq == pytest.approx([0.0], abs=1e-8)


def test_parabola_keeps_its_acceleration() -> None:
    motion = MatchedMotion(1)
    for t in (np.arange(100) * 0.01).tolist():
        motion.push([2.0 * t * t], t)
    assert motion.motion(t).ddq_rad_s2 == pytest.approx([4.0], rel=1e-3)


def test_motion_and_wrench_of_a_swing_bear_the_same_delay_and_factor() -> None:
    motion, wrench = MatchedMotion(1), MatchedFilter(2)
    for t in (np.arange(300) * 0.004).tolist():
        motion.push([math.sin(W * t)], t)
        wrench.push([math.sin(W * t), -W * W * math.sin(W * t)], t)
    q, dq, ddq = motion.motion(t)
    late = t - DELAY_S
    factor = q[0] / math.sin(W * late)
    assert 0.98 < factor < 0.99  # 1 - (2 pi 80 ms)^2 / 18
    assert dq[0] == pytest.approx(factor * W * math.cos(W * late), rel=1e-3)
    assert ddq[0] == pytest.approx(-factor * W * W * math.sin(W * late), rel=1e-3)
    assert wrench.value(t) == pytest.approx([q[0], ddq[0]], rel=1e-3)


@pytest.mark.parametrize("frequency_hz", [1.0, 3.0])
@pytest.mark.parametrize("delay_s", [0.05, 0.1])
def test_delay_is_that_asked_for_at_every_frequency(frequency_hz: float, delay_s: float) -> None:
    delayed, at_s = MatchedFilter(1, delay_s=delay_s), 1.5 + delay_s
    for t in np.linspace(1.0, at_s, 600).tolist():
        delayed.push([math.sin(W * frequency_hz * t)], t)
    assert delayed.value(at_s) == pytest.approx([0.0], abs=1e-3)  # the sine's zero at 1.5 s
    assert abs(delayed.value(at_s + 0.02)[0]) > 0.05


def test_first_sample_counts_as_having_been_there_for_ever() -> None:
    motion = MatchedMotion(2)
    motion.push([0.4, -0.4], 5.0)
    q, dq, ddq = motion.motion(5.0)
    assert q == pytest.approx([0.4, -0.4])
    assert dq.tolist() == [0.0, 0.0]
    assert ddq.tolist() == [0.0, 0.0]
    assert not motion.settled


def test_jump_of_an_encoder_enters_no_derivative() -> None:
    smooth, broken = MatchedMotion(1), MatchedMotion(1)
    worst = 0.0
    for tick in range(300):
        t = tick * 0.01
        q = 0.3 * math.sin(W * t)
        smooth.push([q], t)
        broken.push([q + (1.0 if tick >= 200 else 0.0)], t)
        assert broken.jumped[0] == (tick == 200)
        worst = max(worst, abs(smooth.motion(t).ddq_rad_s2[0] - broken.motion(t).ddq_rad_s2[0]))
    assert worst < 0.5  # of the swing's 11.8 rad/s2
    assert broken.motion(t).q_rad[0] == pytest.approx(smooth.motion(t).q_rad[0] + 1.0, abs=2e-3)


@pytest.mark.parametrize("speed_rad_s", [0.0, 0.4, 2.0])
@pytest.mark.parametrize("late", [False, True], ids=["two parts apart", "one sample late"])
@pytest.mark.parametrize("period_s", [0.004, 0.008])
def test_sample_on_the_heels_of_another_is_no_jump(
    speed_rad_s: float, late: bool, period_s: float
) -> None:
    """Neither in motion nor at rest, where the encoder may flicker just then."""
    motion = MatchedMotion(1)
    worst_rad = 0.0
    for tick in range(100):
        t_s, q_rad = tick * period_s, speed_rad_s * tick * period_s
        if tick == 50:  # what the tick before has told comes late, or is told once more
            motion.push([q_rad - speed_rad_s * period_s], t_s - 5e-5)
            assert not motion.jumped[0]
            q_rad += QUANTUM_RAD
        if tick != 49 or not late:
            motion.push([q_rad], t_s)
            assert not motion.jumped[0]
        if t_s > 2.0 * DELAY_S:
            error_rad = motion.motion(t_s).q_rad[0] - speed_rad_s * (t_s - DELAY_S)
            worst_rad = max(worst_rad, abs(error_rad))
    assert worst_rad < QUANTUM_RAD + 0.1 * speed_rad_s * period_s


def test_jump_is_found_between_samples_that_come_out_of_pace() -> None:
    motion = MatchedMotion(1)
    found = []
    for tick in range(60):
        t, q = tick * 0.008, 0.4 * tick * 0.008 + (0.1 if tick >= 40 else 0.0)
        if tick >= 30:
            motion.push([q - 0.4 * 0.008 - (0.1 if tick == 40 else 0.0)], t)
            found += [tick] * int(motion.jumped[0])
            t += 5e-5
        motion.push([q], t)
        found += [tick] * int(motion.jumped[0])
    assert found == [40]


def test_joint_that_stops_dead_is_at_rest_when_the_window_has_passed() -> None:
    motion = MatchedMotion(1)
    for tick in range(100):
        t = tick * 0.01
        motion.push([4.0 * min(t, 0.5)], t)
    assert not motion.jumped[0]
    assert motion.motion(t).dq_rad_s == pytest.approx([0.0], abs=1e-9)


def test_silence_empties_the_filter() -> None:
    wrench = MatchedFilter(1)
    for tick in range(50):
        wrench.push([5.0], tick * 0.01)
    assert wrench.settled
    assert wrench.add([1.0], 1.0) == pytest.approx([1.0])
    assert wrench.resets == 1


@pytest.mark.parametrize("period_s", [0.001, 0.0016, 0.004, 0.01])
def test_full_memory_stays_full_whatever_instants_round_to(period_s: float) -> None:
    wrench = MatchedFilter(1)
    ticks = round(5.0 / period_s)
    settled = []
    for tick in range(ticks):
        wrench.push([1.0], 0.0013 + tick * period_s)
        settled.append(wrench.settled)
    first = settled.index(True)
    assert first == pytest.approx(0.16 / period_s, abs=1.0)
    assert all(settled[first:])


def test_slope_is_the_derivative_of_the_value() -> None:
    wrench = MatchedFilter(1)
    for tick in range(50):
        wrench.push([math.sin(W * tick * 0.01)], tick * 0.01)
    difference = (wrench.value(0.491) - wrench.value(0.4901)) / 0.0009
    assert wrench.slope(0.49055) == pytest.approx(difference, rel=1e-4)


def test_sample_that_is_not_newer_is_dropped() -> None:
    wrench = MatchedFilter(1)
    for tick in range(50):
        wrench.push([5.0], tick * 0.01)
    wrench.push([1000.0], 0.3)
    assert wrench.value(0.5) == pytest.approx([5.0])
    assert wrench.late_samples == 1


@pytest.mark.parametrize(("bad", "at_s"), [(math.nan, 0.5), (math.inf, 0.5), (1.0, math.nan)])
def test_what_is_not_finite_never_enters(bad: float, at_s: float) -> None:
    wrench = MatchedFilter(2)
    for tick in range(50):
        wrench.push([5.0, 6.0], tick * 0.01)
    with pytest.raises(NotFiniteError):
        wrench.push([5.0, bad], at_s)
    assert wrench.value(0.5) == pytest.approx([5.0, 6.0])


def test_reading_an_empty_filter_says_so() -> None:
    with pytest.raises(NoSampleError):
        MatchedFilter(6).value(0.0)


@pytest.mark.parametrize("at_s", [math.nan, math.inf])
def test_reading_at_no_instant_is_refused(at_s: float) -> None:
    motion = MatchedMotion(1)
    motion.push([1.0], 0.0)
    with pytest.raises(NotFiniteError):
        motion.value(at_s)
    with pytest.raises(NotFiniteError):
        motion.motion(at_s)


def test_memory_is_finite_at_any_rate() -> None:
    wrench = MatchedFilter(1)
    for tick in range(9000):
        wrench.push([float(tick)], tick * 1e-5)
    assert 1024 <= len(wrench._history) <= 2048
    assert 9000 - 2048 <= wrench.value(tick * 1e-5)[0] <= 9000


def test_phantom_force_of_a_swinging_arm_is_less_than_half() -> None:
    found = phantom_forces_n(1.0, seconds=3.5)
    matched = found.pop("matched")
    assert len(found) == 5
    assert matched < 0.5 * min(found.values())
