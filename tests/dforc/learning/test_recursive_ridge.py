from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from dforc.arrays import Matrix
from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.random_features import RandomFeatures
from dforc.learning.recursive_ridge import HELD, NotDefiniteError, RecursiveRidge

LAMBDA = 1e-3


def samples(count: int, size: int, seed: int = 0) -> tuple[Matrix, Matrix]:
    rng = np.random.default_rng(seed)
    x = np.cumsum(0.1 * rng.standard_normal((count, 4)), 0)
    phi = RandomFeatures(4, size, np.ones(4), seed).features_of_rows(x)
    return phi, np.column_stack([np.sin(x[:, 0]), x[:, 1], x[:, 2] * x[:, 3]])


def solved(phi: Matrix, y: Matrix) -> Matrix:
    """The ridge solution as a least-squares problem, with rows for the prior."""
    rows = np.vstack([phi, np.sqrt(LAMBDA) * np.eye(phi.shape[1])])
    targets = np.vstack([y, np.zeros((phi.shape[1], y.shape[1]))])
    solution: Matrix = np.linalg.lstsq(rows, targets, rcond=None)[0]
    return solution


def test_one_sample_by_hand() -> None:
    # phi = (1, 2), y = 3, lambda = 1: W = phi y / (lambda + phi'phi) = (3, 6) / 6
    ridge = RecursiveRidge(2, 1, 1.0)
    error = ridge.update(np.array([1.0, 2.0]), [3.0])
    assert error == pytest.approx([3.0])
    np.testing.assert_allclose(ridge.weights, [[0.5], [1.0]], rtol=1e-15)
    # P = I - phi phi' / 6, so phi'P phi = 5 - 25 / 6
    assert ridge.variance(np.array([1.0, 2.0])) == pytest.approx(5.0 / 6.0)


def test_stays_with_the_batch_over_ten_thousand_updates() -> None:
    phi, y = samples(10_000, 60)
    ridge = RecursiveRidge(60, 3, LAMBDA)
    for row, target in zip(phi, y, strict=True):
        ridge.update(row, target)
    truth = solved(phi, y)
    assert np.abs(ridge.weights - truth).max() <= 1e-6 * np.abs(truth).max()
    assert ridge.definite()
    assert ridge.samples == 10_000


def test_a_batch_start_goes_on_as_if_it_had_come_sample_by_sample() -> None:
    phi, y = samples(400, 30)
    ridge = RecursiveRidge(30, 3, LAMBDA)
    ridge.fit(phi[:200], y[:200])
    for row, target in zip(phi[200:], y[200:], strict=True):
        ridge.update(row, target)
    truth = solved(phi, y)
    np.testing.assert_allclose(ridge.weights, truth, atol=1e-8 * np.abs(truth).max())


@pytest.mark.parametrize("held_back", range(HELD + 1))
def test_samples_that_are_held_back_count_in_all_that_is_asked(held_back: int) -> None:
    phi, y = samples(3 * HELD + 1, 40)
    learner = RecursiveRidge(40, 3, LAMBDA)
    for i in range(HELD + held_back):
        learner.update(phi[i], y[i])
    taken = phi[: HELD + held_back]
    P = np.linalg.inv(LAMBDA * np.eye(40) + taken.T @ taken)
    assert learner.variance(phi[-1]) == pytest.approx(phi[-1] @ P @ phi[-1], rel=1e-9)
    np.testing.assert_allclose(learner.weights, solved(taken, y[: len(taken)]), atol=1e-9)
    state = learner.state()
    whole = state.P - state.held @ state.held.T
    np.testing.assert_allclose(np.tril(whole), np.tril(P), rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("held_back", [0, 3, HELD - 1])
def test_looking_at_a_learner_does_not_change_what_it_will_say(held_back: int) -> None:
    phi, y = samples(4 * HELD, 40)
    looked_at, left_alone = RecursiveRidge(40, 3, LAMBDA), RecursiveRidge(40, 3, LAMBDA)
    for i, (features, outputs) in enumerate(zip(phi, y, strict=True)):
        if i == HELD + held_back:
            assert looked_at.definite()
            looked_at.state()
            looked_at.variance(phi[0])
        looked_at.update(features, outputs)
        left_alone.update(features, outputs)
    np.testing.assert_array_equal(looked_at.weights, left_alone.weights)


def test_a_state_that_holds_back_too_much_is_refused() -> None:
    learner = RecursiveRidge(4, 1, LAMBDA)
    with pytest.raises(ShapeError, match="holds back"):
        learner.restore(replace(learner.state(), held=np.zeros((4, HELD))))


def test_the_order_of_samples_does_not_matter() -> None:
    phi, y = samples(300, 20)
    forwards, backwards = RecursiveRidge(20, 3, LAMBDA), RecursiveRidge(20, 3, LAMBDA)
    for i in range(300):
        forwards.update(phi[i], y[i])
        backwards.update(phi[-1 - i], y[-1 - i])
    np.testing.assert_allclose(forwards.weights, backwards.weights, atol=1e-9)


def test_outputs_are_learned_as_if_each_were_alone() -> None:
    phi, y = samples(200, 20)
    together, alone = RecursiveRidge(20, 3, LAMBDA), RecursiveRidge(20, 1, LAMBDA)
    for row, target in zip(phi, y, strict=True):
        together.update(row, target)
        alone.update(row, target[1:2])
    np.testing.assert_allclose(together.weights[:, 1:2], alone.weights, rtol=1e-12)


def test_agrees_with_scikit_learn() -> None:
    linear_model = pytest.importorskip("sklearn.linear_model")
    phi, y = samples(500, 40)
    ridge = RecursiveRidge(40, 3, LAMBDA)
    for row, target in zip(phi, y, strict=True):
        ridge.update(row, target)
    peer = linear_model.Ridge(alpha=LAMBDA, fit_intercept=False, solver="svd").fit(phi, y)
    np.testing.assert_allclose(ridge.predict_rows(phi), peer.predict(phi), atol=1e-8)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["features", "outputs"])
def test_a_sample_that_is_not_finite_changes_nothing(bad: float, where: str) -> None:
    phi, y = samples(100, 20)
    ridge = RecursiveRidge(20, 3, LAMBDA)
    ridge.fit(phi[:50], y[:50])
    before = ridge.state()
    row, target = phi[60].copy(), y[60].copy()
    (row if where == "features" else target)[1] = bad
    with pytest.raises(NotFiniteError):
        ridge.update(row, target)
    after = ridge.state()
    assert np.array_equal(before.P, after.P)
    assert np.array_equal(before.W, after.W)
    assert after.samples == 50


def test_a_restored_state_goes_on_with_the_same_bits() -> None:
    phi, y = samples(300, 30)
    ridge = RecursiveRidge(30, 3, LAMBDA)
    ridge.fit(phi[:100], y[:100])
    state = ridge.state()
    for i in range(100, 200):
        ridge.update(phi[i], y[i])
    first = ridge.weights
    ridge.restore(state)
    for i in range(100, 200):
        ridge.update(phi[i], y[i])
    assert np.array_equal(first, ridge.weights)


def test_a_state_is_not_changed_by_later_updates() -> None:
    phi, y = samples(100, 20)
    ridge = RecursiveRidge(20, 3, LAMBDA)
    state = ridge.state()
    ridge.update(phi[0], y[0])
    assert np.array_equal(np.tril(state.P), np.eye(20) / LAMBDA)
    assert not state.W.any()


def test_a_state_of_another_size_is_refused() -> None:
    with pytest.raises(ShapeError):
        RecursiveRidge(20, 3, LAMBDA).restore(RecursiveRidge(30, 3, LAMBDA).state())


def test_an_indefinite_p_is_seen_before_it_does_harm() -> None:
    ridge = RecursiveRidge(2, 1, 1.0)
    state = ridge.state()
    P = np.asfortranarray(np.diag([1.0, -1.0]))
    ridge.restore(replace(state, P=P, samples=5))
    assert not ridge.definite()
    with pytest.raises(NotDefiniteError, match="after 5 samples"):
        ridge.update(np.array([0.0, 1.0]), [1.0])
    assert not ridge.weights.any()


def test_features_of_zero_teach_nothing_and_break_nothing() -> None:
    ridge = RecursiveRidge(2, 1, 1.0)
    ridge.update(np.zeros(2), [7.0])
    assert not ridge.weights.any()


def test_a_sample_of_another_shape_is_refused() -> None:
    ridge = RecursiveRidge(3, 2, 1.0)
    with pytest.raises(ShapeError, match="features"):
        ridge.update(np.zeros(4), [1.0, 1.0])
    with pytest.raises(ShapeError, match="outputs"):
        ridge.update(np.zeros(3), [1.0, 1.0, 1.0])
    with pytest.raises(ShapeError, match="outputs"):
        ridge.update(np.zeros(3), np.ones((2, 1)))


def test_a_regularisation_of_zero_is_refused() -> None:
    with pytest.raises(ShapeError, match="lambda"):
        RecursiveRidge(3, 2, 0.0)


@pytest.mark.parametrize("kind", [np.float32, np.int64])
def test_a_batch_of_other_numbers_is_summed_up_in_float64(kind: type) -> None:
    rng = np.random.default_rng(9)
    phi, y = (cast("Matrix", (9.0 * rng.normal(size=(300, k))).astype(kind)) for k in (20, 2))
    one, other = RecursiveRidge(20, 2, 1e-3), RecursiveRidge(20, 2, 1e-3)
    one.fit(phi, y)
    other.fit(phi.astype(np.float64), y.astype(np.float64))
    assert one.weights == pytest.approx(other.weights, abs=1e-12)


def test_a_state_without_a_lambda_is_refused() -> None:
    ridge = RecursiveRidge(4, 1, 0.1)
    with pytest.raises(NotFiniteError, match="lambda"):
        ridge.restore(replace(ridge.state(), regularisation=np.nan))
