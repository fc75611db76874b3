import numpy as np
import pytest

from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.kernel_ridge import gaussian_kernel
from dforc.learning.random_features import Form, RandomFeatures

LENGTHS = np.array([0.5, 2.0, 1.0])


@pytest.mark.parametrize("form", ["pair", "phase"])
def test_inner_products_approach_the_gaussian_kernel(form: Form) -> None:
    rng = np.random.default_rng(0)
    x = rng.standard_normal((30, 3))
    phi = RandomFeatures(3, 20_000, LENGTHS, 1, form).features_of_rows(x)
    # 20 000 independent terms of size about 1: a standard error of 0.01, five of them allowed
    np.testing.assert_allclose(phi @ phi.T, gaussian_kernel(x, x, LENGTHS), atol=0.05)


def test_pairs_have_unit_length() -> None:
    features = RandomFeatures(3, 10, LENGTHS, 0)
    assert np.linalg.norm(features.features([0.3, -4.0, 100.0])) == pytest.approx(1.0)


def test_a_pair_is_the_cosine_and_sine_of_its_frequency() -> None:
    features = RandomFeatures(2, 2, [1.0, 3.0], 5)
    angle = float(np.array([0.4, -0.7]) @ features.frequencies[:, 0])
    np.testing.assert_allclose(
        features.features([0.4, -0.7]), [np.cos(angle), np.sin(angle)], rtol=1e-15
    )


def test_the_same_seed_gives_the_same_features() -> None:
    first, second = (RandomFeatures(3, 50, LENGTHS, 7).features(LENGTHS) for _ in range(2))
    other = RandomFeatures(3, 50, LENGTHS, 8).features(LENGTHS)
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_a_row_has_the_features_of_the_vector() -> None:
    features = RandomFeatures(3, 50, LENGTHS, 7)
    rows = np.array([[1.0, 2.0, 3.0], [-1.0, 0.0, 0.5]])
    np.testing.assert_allclose(
        features.features_of_rows(rows), [features.features(row) for row in rows], rtol=1e-14
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad: float) -> None:
    features = RandomFeatures(3, 50, LENGTHS, 7)
    with pytest.raises(NotFiniteError):
        features.features([0.0, bad, 0.0])
    with pytest.raises(NotFiniteError):
        features.features_of_rows(np.array([[0.0, bad, 0.0]]))


def test_an_odd_number_of_pairs_is_refused() -> None:
    with pytest.raises(ShapeError, match="even"):
        RandomFeatures(3, 51, LENGTHS, 7)


def test_a_length_scale_of_zero_is_refused() -> None:
    with pytest.raises(ShapeError, match="above zero"):
        RandomFeatures(3, 50, [1.0, 0.0, 1.0], 7)
