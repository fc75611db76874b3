import numpy as np
import pytest

from dforc.arrays import ArrayLike, Matrix, Vector
from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.feature_ridge import FeatureRidge, Kernel, LearnerState
from dforc.learning.gate import ContactSafe, GateLimits, UpdateGate

LIMITS = GateLimits(close_n=2.0, open_n=1.5, quiet=3, model_n=4.0)
KERNEL = Kernel(tuple(range(6)), np.array([1.0]), 1e-2)


def test_closes_at_once_and_opens_after_a_quiet_while() -> None:
    gate = UpdateGate(LIMITS)
    given = [0.5, 2.1, 1.0, 1.0, 1.0, 0.5]
    assert [gate.admit(n) for n in given] == [True, False, False, False, True, True]


def test_between_the_thresholds_it_stays_as_it_is() -> None:
    gate = UpdateGate(LIMITS)
    assert gate.admit(1.9)
    gate.admit(2.1)
    assert not any(gate.admit(1.9) for _ in range(20))


def test_the_quiet_while_begins_again_with_every_disturbance() -> None:
    gate = UpdateGate(LIMITS)
    given = [2.1, 1.0, 1.0, 1.6, 1.0, 1.0, 1.0]
    assert [gate.admit(n) for n in given] == [False] * 6 + [True]


def test_a_touch_closes_it_whatever_the_residual() -> None:
    gate = UpdateGate(LIMITS)
    assert not gate.admit(0.0, touched=True)
    assert gate.closings == 1


def test_far_from_the_model_it_closes_however_well_the_learner_explains_it() -> None:
    assert not UpdateGate(LIMITS).admit(0.1, model_n=4.1)


def test_what_is_not_a_number_closes_it() -> None:
    assert not UpdateGate(LIMITS).admit(float("nan"))


def test_can_be_opened_by_hand() -> None:
    gate = UpdateGate(LIMITS)
    gate.admit(3.0)
    gate.release()
    assert gate.admit(1.9)


@pytest.mark.parametrize("limits", [(1.0, 2.0), (2.0, 0.0), (5.0, 1.0)])
def test_thresholds_out_of_order_are_refused(limits: tuple[float, float]) -> None:
    with pytest.raises(ShapeError):
        GateLimits(close_n=limits[0], open_n=limits[1], model_n=4.0)


def wrench(force_n: float) -> Vector:
    return np.array([force_n, 0.0, 0.0, 0.0, 0.0, 0.0])


def run(
    memory: int, forces_n: Matrix | list[float]
) -> tuple[ContactSafe[LearnerState], FeatureRidge]:
    """A learner that knows a force of zero at rest, then is given forces at the same input."""
    learner = FeatureRidge((KERNEL,), 20, 0)
    safe = ContactSafe(learner, UpdateGate(LIMITS), memory)
    for _ in range(100):
        safe.update([0.0], wrench(0.0))
    for force_n in forces_n:
        safe.update([0.0], wrench(force_n))
    return safe, learner


def test_a_step_is_not_eaten() -> None:
    safe, _ = run(0, [5.0] * 300)
    assert 5.0 - safe.predict([0.0])[0] == pytest.approx(5.0, abs=1e-12)


def test_a_twist_without_force_is_not_eaten() -> None:
    """0.5 Nm is 2.5 N at 0.2 m; 0.3 Nm stays below the threshold."""
    safe, _ = run(0, [])
    for _ in range(300):
        safe.update([0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.5])
    assert safe.predict([0.0])[5] == pytest.approx(0.0, abs=1e-12)
    assert safe.update([0.0], [0.0, 0.0, 0.0, 0.3, 0.0, 0.0]) is False
    for _ in range(LIMITS.quiet):
        safe.update([0.0], wrench(0.0))
    assert safe.update([0.0], [0.0, 0.0, 0.0, 0.3, 0.0, 0.0])


def test_without_memory_a_ramp_is_eaten_up_to_the_threshold() -> None:
    ramp = np.linspace(0.0, 5.0, 200)
    safe, _ = run(0, [*ramp, *[5.0] * 100])
    assert safe.predict([0.0])[0] > 0.1


def test_with_memory_a_ramp_is_taken_back() -> None:
    ramp = np.linspace(0.0, 5.0, 200)
    safe, _ = run(150, [*ramp, *[5.0] * 100])
    assert safe.taken_back == 1
    assert safe.predict([0.0])[0] == pytest.approx(0.0, abs=1e-12)


def test_a_sample_that_is_not_finite_neither_closes_it_nor_takes_anything_back() -> None:
    safe, learner = run(50, [])
    before = learner.state()
    with pytest.raises(NotFiniteError):
        safe.update([0.0], wrench(np.nan))
    assert safe.gate.open
    assert np.array_equal(before.ridges[0].W, learner.state().ridges[0].W)


def test_where_nothing_is_known_it_allows_for_more() -> None:
    def learned(unknown_n: float) -> bool:
        safe = ContactSafe(FeatureRidge((KERNEL,), 20, 0), UpdateGate(LIMITS), 0, unknown_n)
        return safe.update([0.0], wrench(3.0))

    assert not learned(0.5)
    assert learned(1.5)


def test_what_it_allows_for_where_nothing_is_known_is_gone_once_it_knows() -> None:
    learner = FeatureRidge((KERNEL,), 20, 0)
    safe = ContactSafe(learner, UpdateGate(LIMITS), 0, 1.5)
    assert learner.novelty([0.0]) == pytest.approx(1.0)
    for _ in range(100):
        safe.update([0.0], wrench(0.0))
    # 100 samples against lambda = 0.01: one in 10 001 of the uncertainty is left
    assert learner.novelty([0.0]) == pytest.approx(1 / 10_001, rel=1e-6)
    assert not safe.update([0.0], wrench(2.1))


def test_after_the_release_it_goes_on_learning() -> None:
    safe, learner = run(50, [5.0] * 100)
    before = learner.samples
    for _ in range(10):
        safe.update([0.0], wrench(0.0))
    assert learner.samples == before + 10 - LIMITS.quiet + 1


def test_an_ungated_learner_eats_the_push_and_leaves_a_ghost() -> None:
    learner = FeatureRidge((KERNEL,), 20, 0)
    for force_n in [0.0] * 100 + [5.0] * 300:
        learner.update([0.0], wrench(force_n))
    assert 5.0 - learner.predict([0.0])[0] < 2.0


class Diary:
    """A learner that only remembers what it was given."""

    def __init__(self) -> None:
        self.seen: tuple[float, ...] = ()

    def predict(self, x: ArrayLike) -> Vector:  # noqa: ARG002
        return np.zeros(6)

    def novelty(self, x: ArrayLike) -> float:  # noqa: ARG002
        return 0.0

    def update(self, x: ArrayLike, y: ArrayLike) -> Vector:  # noqa: ARG002
        self.seen = (*self.seen, float(y[0]))
        return np.zeros(6)

    def state(self) -> tuple[float, ...]:
        return self.seen

    def restore(self, state: tuple[float, ...]) -> None:
        self.seen = state


def test_what_was_taken_back_once_never_comes_back() -> None:
    diary, limits = Diary(), GateLimits(close_n=20.0, open_n=20.0, quiet=1)
    safe = ContactSafe(diary, UpdateGate(limits), memory=3)
    for force_n in (1, 2, 3, 4, 5, 6, 7, 99):
        safe.update([0.0], wrench(force_n))
    assert diary.seen == (1, 2, 3)
    for force_n in (8, 9, 10, 11):
        safe.update([0.0], wrench(force_n))
    assert diary.seen == (1, 2, 3, 8, 9, 10, 11)
    safe.update([0.0], wrench(99))
    assert diary.seen == (1, 2, 3)


def test_after_a_reset_there_is_nothing_to_go_back_to_and_the_gate_is_open() -> None:
    diary, limits = Diary(), GateLimits(close_n=20.0, open_n=20.0, quiet=5)
    safe = ContactSafe(diary, UpdateGate(limits), memory=3)
    for force_n in (1, 2, 3, 4, 5, 6, 7, 99):
        safe.update([0.0], wrench(force_n))
    assert not safe.gate.open
    diary.seen = ()
    safe.forget()
    assert safe.gate.open
    safe.update([0.0], wrench(8))
    safe.update([0.0], wrench(99))
    assert diary.seen == ()
