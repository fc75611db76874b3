"""Gain and offset of a sensor from a sweep of postures."""

import math

import numpy as np
import pytest

from benchmarks.ft_rows import gain_error, identified, leg_model, secondary_matrix
from dforc.arrays import Matrix
from dforc.errors import NotFiniteError, ShapeError
from dforc.signals.identification import NOISE, TooFewPosesError, identify_gain

OFFSET = np.array([3.0, -2.0, 1.0, 0.1, -0.2, 0.3])


def loads(count: int, seed: int = 0) -> Matrix:
    """Wrenches that excite all six directions."""
    values = np.random.default_rng(seed).normal(size=(count, 6))
    scaled: Matrix = values * np.array([10.0] * 3 + [1.0] * 3)
    return scaled


def noise(count: int, seed: int = 1) -> Matrix:
    scaled: Matrix = np.random.default_rng(seed).normal(size=(count, 6)) * np.array(NOISE)
    return scaled


def test_sweep_of_the_leg_finds_a_gain_that_is_40_percent_off() -> None:
    true, fit = identified(leg_model, seed=0)
    assert gain_error(np.eye(6), true) > 0.4
    assert gain_error(fit.matrix, true) <= 0.02
    assert fit.rank == 6
    assert np.linalg.norm(fit.residual[:3]) < 0.1 < 5.0 < np.linalg.norm(fit.residual_before[:3])


def test_rich_loads_give_gain_and_offset_back() -> None:
    C, wrenches = secondary_matrix(np.random.default_rng(4)), loads(4000)
    raw = np.linalg.solve(C, (wrenches + OFFSET).T).T + noise(4000)
    fit = identify_gain(raw, wrenches)
    assert gain_error(fit.matrix, C) < 0.002
    assert fit.condition == pytest.approx(fit.spread[0] / fit.spread[5])
    assert fit.offset == pytest.approx(OFFSET, abs=0.02)


def test_noise_of_the_readings_does_not_draw_the_gain_towards_zero() -> None:
    wrenches = loads(40_000) * 0.01  # a spread of two noises in force, five in moment
    fit = identify_gain(wrenches + noise(40_000), wrenches, ridge=1e-3)
    assert np.diag(fit.matrix) == pytest.approx(np.ones(6), abs=0.02)


def test_noise_of_the_readings_does_not_draw_a_wrong_gain_towards_one() -> None:
    wrenches = loads(40_000) * 0.01
    fit = identify_gain(wrenches + noise(40_000), 1.3 * wrenches, ridge=1e-3)
    assert np.diag(fit.matrix) == pytest.approx(np.full(6, 1.3), abs=0.02)


def test_one_posture_leaves_the_gain_alone_and_finds_the_offset() -> None:
    wrenches = np.tile(loads(1), (400, 1))
    fit = identify_gain(wrenches + OFFSET + noise(400), wrenches)
    assert fit.rank == 0
    assert len(fit.unobserved) == 6
    assert fit.condition == math.inf
    assert fit.matrix.tolist() == np.eye(6).tolist()
    moved = (wrenches + OFFSET) @ fit.matrix.T - fit.offset
    assert moved == pytest.approx(wrenches, abs=0.02)


def test_direction_that_was_not_loaded_keeps_gain_one_and_is_named() -> None:
    wrenches = loads(2000)
    wrenches[:, 5] = 0.4
    fit = identify_gain(wrenches / 0.6 + noise(2000), wrenches)
    assert fit.rank == 5
    assert np.abs(fit.unobserved[0]) == pytest.approx([0, 0, 0, 0, 0, 1], abs=0.01)
    assert np.diag(fit.matrix)[:5] == pytest.approx(np.full(5, 0.6), abs=1e-3)
    assert fit.matrix[5, 5] == pytest.approx(1.0, abs=0.01)


def test_result_cannot_be_changed() -> None:
    fit = identify_gain(loads(100), loads(100))
    with pytest.raises(ValueError, match="read-only"):
        fit.matrix[0, 0] = 2.0


def test_bad_input_is_refused() -> None:
    good, spoilt = loads(100), loads(100)
    spoilt[7, 3] = np.nan
    for pair in ((good, spoilt), (spoilt, good)):
        with pytest.raises(NotFiniteError):
            identify_gain(*pair)
    with pytest.raises(ShapeError):
        identify_gain(good, good[:99])
    with pytest.raises(TooFewPosesError):
        identify_gain(good[:10], good[:10])
