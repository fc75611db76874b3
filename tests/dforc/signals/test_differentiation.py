"""Velocity and acceleration from encoders of 12 bits."""

import math

import numpy as np
import pytest

from benchmarks.derivative_peers import AdaptiveWindow
from benchmarks.derivative_rows import Ours, rest_noise, sine_errors
from dforc.arrays import Matrix, Vector
from dforc.errors import NotFiniteError, ShapeError
from dforc.signals.differentiation import QUANTUM_RAD, Differentiator

PERIOD_S = 0.01


def shown(q_rad: Matrix) -> Matrix:
    rounded: Matrix = np.round(q_rad / QUANTUM_RAD) * QUANTUM_RAD
    return rounded


def swing(ticks: int, joints: int = 3) -> Matrix:
    """0.5 Hz, 20 degrees, each joint with its own phase; largest acceleration 3.45 rad/s2."""
    t = np.arange(ticks)[:, None] * PERIOD_S
    return shown(np.radians(20.0) * np.sin(np.pi * t + np.arange(joints)))


def fed(q_rad: Matrix, start_s: float = 0.0) -> Differentiator:
    differentiator = Differentiator(q_rad.shape[1])
    for tick, sample in enumerate(q_rad):
        differentiator.add(sample, start_s + tick * PERIOD_S)
    return differentiator


@pytest.mark.parametrize("amplitude_deg", [5.0, 10.0, 20.0])
def test_error_in_a_1_hz_swing_is_small_with_lag_and_noise_included(amplitude_deg: float) -> None:
    velocity, acceleration = sine_errors(Ours, 1.0, amplitude_deg)
    assert velocity <= 0.15
    assert acceleration <= 0.35


@pytest.mark.parametrize("frequency_hz", [0.2, 2.0])
def test_slow_and_fast_swings_are_better_than_with_the_adaptive_window(frequency_hz: float) -> None:
    ours = sine_errors(Ours, frequency_hz, 5.0)
    window = sine_errors(AdaptiveWindow, frequency_hz, 5.0)
    assert ours[0] < 0.5 * window[0]
    assert ours[1] < 0.6 * window[1]


def test_rest_is_quieter_than_with_the_adaptive_window() -> None:
    ours = rest_noise(Ours, 0.3, 1)
    window = rest_noise(AdaptiveWindow, 0.3, 1)
    assert ours[0] <= window[0]
    assert ours[1] <= window[1]


def test_encoder_that_stands_still_gives_exactly_zero() -> None:
    differentiator = fed(np.full((50, 2), 0.3))
    motion = differentiator.add([0.3, 0.3], 0.5)
    assert motion.q_rad == pytest.approx([0.3, 0.3], abs=1e-15)
    assert motion.dq_rad_s == pytest.approx([0.0, 0.0], abs=1e-12)
    assert motion.ddq_rad_s2 == pytest.approx([0.0, 0.0], abs=1e-12)


def test_constant_acceleration_is_found_without_lag() -> None:
    differentiator = Differentiator(1, quantum_rad=1e-9)
    for tick in range(60):
        t = tick * PERIOD_S
        motion = differentiator.add([0.5 * t + 0.5 * 2.0 * t * t], t)
    assert motion.dq_rad_s == pytest.approx([0.5 + 2.0 * 0.59], rel=1e-6)
    assert motion.ddq_rad_s2 == pytest.approx([2.0], rel=1e-5)


def test_jump_of_an_encoder_is_flagged_once_and_enters_no_derivative() -> None:
    q = swing(400, 1)
    jumped = q + np.where(np.arange(400)[:, None] >= 300, np.radians(25.0), 0.0)
    smooth, broken = Differentiator(1), Differentiator(1)
    flags = 0
    for tick in range(400):
        expected = smooth.add(q[tick], tick * PERIOD_S)
        found = broken.add(jumped[tick], tick * PERIOD_S)
        flags += int(broken.jumped[0])
        assert abs(found.dq_rad_s[0] - expected.dq_rad_s[0]) < 0.02
        assert abs(found.ddq_rad_s2[0] - expected.ddq_rad_s2[0]) < 0.4
    assert flags == 1
    assert found.q_rad[0] == pytest.approx(expected.q_rad[0] + np.radians(25.0), abs=2e-3)


def test_jump_of_one_joint_leaves_the_others_bit_identical() -> None:
    q = swing(200)
    jumped = q.copy()
    jumped[150:, 1] += 1.0
    whole, broken = fed(q), fed(jumped)
    expected, found = whole.add(q[-1], 2.0), broken.add(jumped[-1], 2.0)
    for a, b in zip(expected, found, strict=True):
        assert a[[0, 2]].tolist() == b[[0, 2]].tolist()


def test_encoder_that_showed_garbage_is_at_rest_again_soon_after() -> None:
    rng = np.random.default_rng(0)
    differentiator = fed(np.full((100, 1), 0.2))
    for tick in range(100, 150):
        differentiator.add(rng.uniform(-3.0, 3.0, 1), tick * PERIOD_S)
    assert differentiator.resets > 0
    for tick in range(150, 180):
        motion = differentiator.add([0.2], tick * PERIOD_S)
    assert np.abs(motion.dq_rad_s) < 0.01
    assert np.abs(motion.ddq_rad_s2) < 0.2


def test_joint_that_moves_after_garbage_is_followed_again() -> None:
    differentiator = fed(np.random.default_rng(1).uniform(-3.0, 3.0, (100, 1)))
    for tick in range(100, 140):
        motion = differentiator.add([3.0 * tick * PERIOD_S], tick * PERIOD_S)
    assert not differentiator.jumped[0]
    assert motion.dq_rad_s == pytest.approx([3.0], abs=0.05)


def test_silence_starts_anew_at_rest() -> None:
    differentiator = fed(swing(200))
    motion = differentiator.add([1.0, 1.0, 1.0], 2.5)
    assert differentiator.resets == 1
    assert not differentiator.settled
    assert motion.q_rad.tolist() == [1.0, 1.0, 1.0]
    assert motion.dq_rad_s.tolist() == [0.0, 0.0, 0.0]


def test_reset_differentiator_is_not_settled() -> None:
    differentiator = fed(swing(200))
    assert differentiator.settled
    differentiator.reset()
    assert not differentiator.settled
    assert differentiator.add([1.0, 1.0, 1.0], 2.0).dq_rad_s.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("back_s", [0.0, 0.01, 3.0])
def test_sample_that_is_not_newer_changes_nothing(back_s: float) -> None:
    q = swing(200)
    whole, late = fed(q), fed(q)
    late.add([1.0, 2.0, 3.0], 1.99 - back_s)
    assert late.late_samples == 1
    for a, b in zip(whole.add(q[0], 2.0), late.add(q[0], 2.0), strict=True):
        assert a.tolist() == b.tolist()


@pytest.mark.parametrize(("bad", "at_s"), [(math.nan, 2.0), (-math.inf, 2.0), (0.1, math.nan)])
def test_what_is_not_finite_is_refused_and_changes_nothing(bad: float, at_s: float) -> None:
    q = swing(200)
    whole, spoilt = fed(q), fed(q)
    with pytest.raises(NotFiniteError):
        spoilt.add([0.1, bad, 0.1], at_s)
    for a, b in zip(whole.add(q[0], 2.0), spoilt.add(q[0], 2.0), strict=True):
        assert a.tolist() == b.tolist()


def test_samples_too_close_are_answered_by_prediction() -> None:
    differentiator = fed(swing(300, 1))
    q, dq, ddq = differentiator.add(swing(300, 1)[-1], 3.0)
    soon: Vector = differentiator.add([77.0], 3.001).q_rad
    assert soon == pytest.approx(q + 0.001 * dq + 0.5e-6 * ddq, abs=1e-12)


def test_wrong_number_of_joints_is_refused() -> None:
    with pytest.raises(ShapeError):
        Differentiator(3).add([0.0, 0.0], 0.0)
