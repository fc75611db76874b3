import numpy as np
import pytest

from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.feature_ridge import FeatureRidge, Kernel
from dforc.learning.kernel_ridge import KernelRidge, gaussian_kernel

LENGTHS = np.array([0.7, 1.5])


def test_a_kernel_by_hand() -> None:
    a, b = np.array([[0.0, 0.0]]), np.array([[0.7, 3.0]])
    # distances of 1 and 2 length scales: exp(-(1 + 4) / 2)
    assert gaussian_kernel(a, b, LENGTHS)[0, 0] == pytest.approx(np.exp(-2.5))


def test_one_row_by_hand() -> None:
    # k(x, x) = 1, so the prediction at the row itself is y / (1 + lambda)
    ridge = KernelRidge(LENGTHS, 0.25).fit(np.array([[1.0, 2.0]]), np.array([[5.0]]))
    assert ridge.predict(np.array([1.0, 2.0]))[0, 0] == pytest.approx(4.0)


def test_agrees_with_scikit_learn() -> None:
    kernel_ridge = pytest.importorskip("sklearn.kernel_ridge")
    rng = np.random.default_rng(0)
    x, y, new = rng.normal(size=(80, 2)), rng.normal(size=(80, 3)), rng.normal(size=(20, 2))
    peer = kernel_ridge.KernelRidge(alpha=0.01, kernel="rbf", gamma=0.5).fit(x / LENGTHS, y)
    ours = KernelRidge(LENGTHS, 0.01).fit(x, y)
    np.testing.assert_allclose(ours.predict(new), peer.predict(new / LENGTHS), atol=1e-9)


def test_many_random_features_do_what_the_kernel_does() -> None:
    rng = np.random.default_rng(1)
    x, new = rng.normal(size=(60, 2)), 0.5 * rng.normal(size=(20, 2))
    y = np.sin(x[:, :1]) + x[:, 1:]
    exact = KernelRidge(LENGTHS, 0.1).fit(x, y - y.mean(0)).predict(new) + y.mean(0)
    features = FeatureRidge((Kernel((0,), LENGTHS, 0.1),), 1000, 2)
    features.fit(x, y)
    np.testing.assert_allclose(features.predict_rows(new), exact, atol=0.15)


def test_what_is_not_finite_is_refused() -> None:
    with pytest.raises(NotFiniteError):
        KernelRidge(LENGTHS, 0.1).fit(np.array([[1.0, np.nan]]), np.array([[5.0]]))


def test_rows_of_another_length_are_refused() -> None:
    with pytest.raises(ShapeError):
        KernelRidge(LENGTHS, 0.1).fit(np.zeros((3, 3)), np.zeros((3, 1)))


def test_inputs_far_from_zero_are_learned_like_inputs_about_zero() -> None:
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(60, 2)), rng.normal(size=(60, 1))
    near, far = KernelRidge(LENGTHS, 0.01).fit(x, y), KernelRidge(LENGTHS, 0.01).fit(x + 1e7, y)
    assert far.predict(x + 1e7) == pytest.approx(near.predict(x), abs=1e-5)


@pytest.mark.parametrize(("lengths", "regularisation"), [((0.7, 0.0), 0.1), ((0.7, 1.5), 0.0)])
def test_a_kernel_without_width_or_regularisation_is_refused(
    lengths: tuple[float, float], regularisation: float
) -> None:
    with pytest.raises(ShapeError, match="lambda"):
        KernelRidge(lengths, regularisation)
