import numpy as np
import pytest
from scipy.stats import multivariate_normal

from dforc.errors import NotFiniteError
from dforc.learning.feature_ridge import Kernel, fit_kernels, fit_noise
from dforc.learning.kernel_ridge import gaussian_kernel
from dforc.learning.marginal_likelihood import fit_hyperparameters, negative_log_likelihood


def test_the_likelihood_is_that_of_a_normal_distribution() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(15, 2)), rng.normal(size=(15, 2))
    logs = np.log([0.8, 1.3, 1.7, 0.4])
    covariance = 1.7**2 * gaussian_kernel(x, x, np.array([0.8, 1.3])) + 0.4**2 * np.eye(15)
    expected = sum(multivariate_normal(cov=covariance).logpdf(y[:, i]) for i in range(2))
    assert -negative_log_likelihood(logs, x, y)[0] == pytest.approx(expected, rel=1e-8)


def test_the_gradient_is_that_of_finite_differences() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(25, 3)), rng.normal(size=(25, 2))
    logs = np.log([0.8, 1.3, 2.0, 1.7, 0.4])
    gradient = negative_log_likelihood(logs, x, y)[1]
    step = 1e-6
    for i, exact in enumerate(gradient):
        up, down = (logs + sign * step * np.eye(5)[i] for sign in (1, -1))
        slope = (negative_log_likelihood(up, x, y)[0] - negative_log_likelihood(down, x, y)[0]) / (
            2 * step
        )
        assert exact == pytest.approx(slope, rel=1e-5, abs=1e-5)


def test_finds_the_kernel_that_the_data_were_drawn_from() -> None:
    rng = np.random.default_rng(2)
    x = rng.uniform(-3, 3, size=(150, 2)) * [1.0, 100.0]
    covariance = gaussian_kernel(x, x, np.array([1.0, 150.0])) + 1e-8 * np.eye(150)
    clean = np.linalg.cholesky(covariance) @ rng.normal(size=(150, 4))
    found = fit_hyperparameters(x, 5.0 * (clean + 0.1 * rng.normal(size=clean.shape)))
    np.testing.assert_allclose(found.length_scales, [1.0, 150.0], rtol=0.15)
    assert found.signal == pytest.approx(5.0, rel=0.3)
    assert found.noise == pytest.approx(0.5, rel=0.15)
    assert found.regularisation == pytest.approx((found.noise / found.signal) ** 2)


def test_an_input_that_does_not_matter_gets_a_long_scale() -> None:
    rng = np.random.default_rng(3)
    x = rng.uniform(-2, 2, size=(120, 2))
    found = fit_hyperparameters(x, np.sin(2 * x[:, 0]) + 0.05 * rng.normal(size=120))
    assert found.length_scales[1] > 10 * found.length_scales[0]


def test_mostly_noise_is_not_taken_for_noise_alone() -> None:
    rng = np.random.default_rng(4)
    x = rng.uniform(-2, 2, size=(200, 3))
    found = fit_hyperparameters(x, np.sin(2 * x[:, 0]) + 0.7 * rng.normal(size=200))
    assert found.length_scales[0] == pytest.approx(0.9, rel=0.6)
    assert found.noise == pytest.approx(0.7, rel=0.15)


def test_given_length_scales_are_kept() -> None:
    rng = np.random.default_rng(5)
    x = rng.uniform(-2, 2, size=(100, 2))
    y = np.sin(x[:, 0]) + 0.2 * rng.normal(size=100)
    found = fit_hyperparameters(x, y, np.array([1.0, 5.0]))
    assert found.length_scales.tolist() == [1.0, 5.0]
    assert found.noise == pytest.approx(0.2, rel=0.3)


def test_each_group_of_outputs_gets_its_own_kernel() -> None:
    rng = np.random.default_rng(6)
    x = rng.uniform(-2, 2, size=(100, 1))
    y = np.hstack([np.sin(x), np.sin(6 * x)]) + 0.02 * rng.normal(size=(100, 2))
    slow, fast = fit_kernels(x, y, ((0,), (1,)))
    assert slow.outputs == (0,)
    assert fast.outputs == (1,)
    assert slow.length_scales[0] > 3 * fast.length_scales[0]


def test_the_noise_alone_is_fitted_to_another_target() -> None:
    rng = np.random.default_rng(7)
    x = rng.uniform(-2, 2, size=(150, 1))
    rest = np.sin(x) + rng.normal(size=(150, 1))
    kernel = Kernel((0,), np.array([1.0]), 1e-6)
    (fitted,) = fit_noise(x, rest, (kernel,))
    assert fitted.length_scales is kernel.length_scales or fitted.length_scales[0] == 1.0
    assert fitted.regularisation > 0.1


def test_what_is_not_finite_is_refused() -> None:
    with pytest.raises(NotFiniteError):
        fit_hyperparameters(np.zeros((3, 1)), np.array([1.0, np.nan, 0.0]))


def test_an_input_that_never_varies_does_no_harm() -> None:
    """A joint that stands still, away from zero, beside one that moves."""
    moving = np.linspace(-3.0, 3.0, 60)
    x, y = np.column_stack([moving, np.full(60, 3.0)]), np.sin(moving)
    alone, both = fit_hyperparameters(x[:, :1], y), fit_hyperparameters(x, y)
    assert both.length_scales[0] == pytest.approx(alone.length_scales[0], rel=0.05)
    assert both.length_scales[1] >= 1.0


def test_the_likelihood_is_that_of_the_data_in_their_own_units() -> None:
    rng = np.random.default_rng(6)
    x = 50.0 * rng.normal(size=(40, 1))
    y = 1e-3 * (np.sin(x / 50.0) + 0.1 * rng.normal(size=(40, 1)))
    found = fit_hyperparameters(x, y)
    logs = np.log([*found.length_scales, found.signal, found.noise])
    assert found.log_likelihood == pytest.approx(-negative_log_likelihood(logs, x, y)[0])
