from dataclasses import replace

import numpy as np
import pytest

from dforc.arrays import Matrix
from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.feature_ridge import FeatureRidge, Kernel
from dforc.learning.semi_parametric import RigidParameters, SemiParametric

KERNELS = (Kernel((0,), np.array([0.2]), 1e-3), Kernel((1,), np.array([0.2]), 1e-3))
THETA = np.array([2.0, -1.0, 0.5])


def regressors(x: Matrix) -> Matrix:
    """Two outputs, three parameters; the second output has a constant."""
    rows = np.zeros((len(x), 2, 3))
    rows[:, 0, 0] = x[:, 0]
    rows[:, 0, 1] = x[:, 0] ** 2
    rows[:, 1, 1] = x[:, 0]
    rows[:, 1, 2] = 1.0
    return rows


def wide() -> RigidParameters:
    return RigidParameters(np.zeros(3), np.full(3, 1e3), np.ones(2))


def test_parameters_are_found_from_noiseless_samples() -> None:
    x = np.linspace(-1, 1, 30)[:, None]
    rigid = wide()
    rigid.add(regressors(x), regressors(x) @ THETA)
    np.testing.assert_allclose(rigid.solve(), THETA, atol=1e-5)


def test_a_parameter_that_is_not_excited_stays_at_its_prior() -> None:
    rigid = RigidParameters([1.0, 7.0], [1.0, 1.0], [0.1])
    rows = np.zeros((5, 1, 2))
    rows[:, 0, 0] = 1.0
    rigid.add(rows, np.full((5, 1), 3.0))
    first, second = rigid.solve()
    # five samples of 0.1 against a prior of 1: 1 + 2 * 500 / 501
    assert first == pytest.approx(1 + 2 * 500 / 501)
    assert second == 7.0


def test_adding_in_pieces_is_adding_at_once() -> None:
    x = np.linspace(-1, 1, 30)[:, None]
    y = regressors(x) @ THETA + np.sin(9 * x)
    pieces, whole = wide(), wide()
    pieces.add(regressors(x[:11]), y[:11])
    pieces.add(regressors(x[11:]), y[11:])
    whole.add(regressors(x), y)
    np.testing.assert_allclose(pieces.solve(), whole.solve(), rtol=1e-9)


def test_parameters_change_only_when_asked_for() -> None:
    x = np.linspace(-1, 1, 30)[:, None]
    rigid = wide()
    rigid.add(regressors(x), regressors(x) @ THETA)
    assert not rigid.theta.any()


def test_the_rest_learns_what_no_rigid_body_does() -> None:
    x = np.linspace(-1, 1, 200)[:, None]
    friction = np.hstack([np.sign(x), np.zeros_like(x)])
    y = regressors(x) @ THETA + friction
    both = SemiParametric(wide(), FeatureRidge(KERNELS, 60, 0))
    both.fit(x, regressors(x), y)
    model_error = np.abs(y - regressors(x) @ both.rigid.theta).mean()
    error = np.abs(y - both.predict_rows(x, regressors(x))).mean()
    assert error < 0.3 * model_error


def test_beyond_the_data_the_model_carries_on() -> None:
    x = np.linspace(-1, 1, 200)[:, None]
    y = regressors(x) @ THETA
    far = np.array([[4.0]])
    both = SemiParametric(wide(), FeatureRidge(KERNELS, 60, 0))
    both.fit(x, regressors(x), y)
    bare = FeatureRidge(KERNELS, 60, 0)
    bare.fit(x, y)
    truth = (regressors(far) @ THETA)[0]
    assert both.predict(far[0], regressors(far)[0]) == pytest.approx(truth, abs=1e-3)
    assert np.abs(bare.predict(far[0]) - truth).max() > 1.0


def test_a_restored_state_goes_on_with_the_same_bits() -> None:
    x = np.linspace(-1, 1, 100)[:, None]
    rows, y = regressors(x), regressors(x) @ THETA + np.sin(5 * x)
    both = SemiParametric(wide(), FeatureRidge(KERNELS, 40, 0))
    both.fit(x[:50], rows[:50], y[:50])
    state = both.state()

    def going_on() -> Matrix:
        return np.array([both.update(x[i], rows[i], y[i]) for i in range(50, 100)])

    first = going_on()
    both.rigid.add(rows, y + 1.0)
    both.rigid.solve()
    both.restore(state)
    assert np.array_equal(first, going_on())


def test_a_learner_with_other_kernels_refuses_the_state() -> None:
    one = FeatureRidge(KERNELS, 40, 0)
    other = FeatureRidge((Kernel((0, 1), np.array([1.0]), 1e-3),), 40, 0)
    with pytest.raises(ShapeError):
        other.restore(one.state())


def test_kernels_must_name_every_output_once() -> None:
    with pytest.raises(ShapeError, match="name the outputs"):
        FeatureRidge((KERNELS[0], KERNELS[0]), 40, 0)


def test_a_sample_that_is_not_finite_changes_nothing() -> None:
    learner = FeatureRidge(KERNELS, 40, 0)
    with pytest.raises(NotFiniteError):
        learner.update([0.0], [1.0, np.nan])
    assert learner.samples == 0
    rigid = wide()
    with pytest.raises(NotFiniteError):
        rigid.add(np.full((1, 2, 3), np.inf), np.zeros((1, 2)))
    assert not rigid.solve().any()


def test_a_cold_start_predicts_the_mean_it_is_given() -> None:
    learner = FeatureRidge(KERNELS, 40, 0)
    learner.reset([3.0, -4.0])
    assert learner.predict([0.5]).tolist() == [3.0, -4.0]


def test_a_state_with_one_bad_part_changes_nothing() -> None:
    x = np.linspace(-1, 1, 50)[:, None]
    both = SemiParametric(wide(), FeatureRidge(KERNELS, 40, 0))
    empty = both.state()
    both.fit(x, regressors(x), regressors(x) @ THETA + np.sin(5 * x))
    expected = both.predict([0.3], regressors(x[:1])[0])
    first, second = empty.rest.ridges
    bad_rest = replace(empty.rest, ridges=(first, replace(second, P=np.eye(39))))
    for bad, why in (
        (replace(empty, rest=bad_rest), ShapeError),
        (replace(empty, moment=np.zeros(7)), ShapeError),
        (replace(empty, theta=np.full(3, np.nan)), NotFiniteError),
    ):
        with pytest.raises(why):
            both.restore(bad)
        assert np.array_equal(both.predict([0.3], regressors(x[:1])[0]), expected)


def test_a_batch_far_from_zero_leaves_its_mean_where_nothing_is_known() -> None:
    learner = FeatureRidge(KERNELS, 40, 0)
    x = np.linspace(-1, 1, 50)[:, None]
    learner.fit(x, np.column_stack([100.0 + np.sin(x[:, 0]), np.full(50, -7.0)]))
    assert learner.predict([0.0]) == pytest.approx([100.0, -7.0], abs=0.05)
    assert learner.predict_rows(np.array([[0.0]]))[0] == pytest.approx(learner.predict([0.0]))
