"""What the estimator and its assumptions refuse, and what stays as it was then."""

from collections.abc import Callable
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from benchmarks.dynamics_scenes import LIMBS, Robot, Scene, scene
from benchmarks.newton_euler import Array
from dforc.errors import NotFiniteError, ShapeError
from dforc.estimation.assumption import (
    Assumption,
    AssumptionError,
    Contact,
    Kind,
    KnownWrench,
    crawling,
    standing,
)
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from dforc.robot_model import ModelError

Make = Callable[[Assumption], WholeBodyEstimator]


@pytest.fixture(scope="module")
def pushed(icub: Robot) -> Scene:
    assumption = Assumption(contacts=(Contact(frame="l_hand"),))
    return scene(np.random.default_rng(1), icub, assumption)


def run(estimator: WholeBodyEstimator, true: Scene) -> BodyEstimate:
    return estimator.estimate(true.q, true.dq, true.ddq, true.readings)


@pytest.mark.parametrize(
    ("bad", "where"),
    [(bad, where) for bad in (np.nan, np.inf) for where in range(4)]
    + [(1e305, where) for where in range(1, 4)],
)
def test_input_that_is_not_finite_is_refused_and_changes_nothing(
    make: Make, pushed: Scene, bad: float, where: int
) -> None:
    estimator = make(standing())
    first = run(estimator, pushed).numbers.copy()
    pose = estimator.frame_pose("l_hand")[1].copy()
    given = [pushed.q.copy(), pushed.dq.copy(), pushed.ddq.copy(), pushed.readings.copy()]
    given[where].flat[2] = bad
    with pytest.raises(NotFiniteError):
        estimator.estimate(given[0], given[1], given[2], given[3])
    assert np.array_equal(estimator.frame_pose("l_hand")[1], pose)
    assert np.array_equal(run(estimator, pushed).numbers, first)


def test_motion_of_the_source_that_is_not_finite_is_refused_and_changes_nothing(
    icub: Robot, pushed: Scene, compiled: bool
) -> None:
    estimator = WholeBodyEstimator(icub.tree, crawling(), compiled=compiled)
    given = pushed.q, pushed.dq, pushed.ddq, pushed.readings
    first = estimator.estimate(*given, None, pushed.imu).numbers.copy()
    bad = replace(pushed.imu, domega_rad_s2=(0.0, float("nan"), 0.0))
    with pytest.raises(NotFiniteError):
        estimator.estimate(*given, None, bad)
    assert np.array_equal(estimator.estimate(*given, None, pushed.imu).numbers, first)


def test_lists_and_read_only_arrays_count_like_arrays(make: Make, pushed: Scene) -> None:
    estimator = make(standing())
    expected = run(estimator, pushed).numbers
    frozen = pushed.q.copy()
    frozen.setflags(write=False)
    listed: Array = pushed.readings.tolist()
    found = estimator.estimate(frozen, pushed.dq, pushed.ddq, listed)
    assert np.array_equal(found.numbers, expected)


def test_arrays_in_any_order_of_memory_count_alike(make: Make, pushed: Scene) -> None:
    estimator = make(standing())
    expected = run(estimator, pushed).numbers
    spread = np.zeros(2 * len(pushed.q))
    spread[::2] = pushed.q
    by_columns = np.asfortranarray(pushed.readings)
    found = estimator.estimate(spread[::2], pushed.dq, pushed.ddq, by_columns)
    assert np.array_equal(found.numbers, expected)


def test_whole_numbers_count_like_real_ones(make: Make, icub: Robot) -> None:
    estimator = make(standing())
    zero, readings = np.zeros(icub.tree.n), np.arange(24.0).reshape(4, 6)
    expected = estimator.estimate(zero, zero, zero, readings).numbers
    whole = cast("Array", zero.astype(np.int64))
    found = estimator.estimate(whole, whole, whole, cast("Array", readings.astype(np.int64)))
    assert np.array_equal(found.numbers, expected)


def test_arrays_of_another_size_are_refused(make: Make, pushed: Scene) -> None:
    estimator = make(standing())
    with pytest.raises(ShapeError, match=r"\(24,\)"):
        estimator.estimate(pushed.q, pushed.dq, pushed.ddq, pushed.readings.ravel())
    with pytest.raises(ShapeError, match=r"\(32, 1\)"):
        estimator.estimate(pushed.q[:, None], pushed.dq, pushed.ddq, pushed.readings)
    with pytest.raises(ShapeError, match=r"\(31,\)"):
        estimator.estimate(pushed.q[1:].copy(), pushed.dq, pushed.ddq, pushed.readings)
    with pytest.raises(ShapeError, match="valid"):
        estimator.estimate(
            pushed.q, pushed.dq, pushed.ddq, pushed.readings, np.ones(3, dtype=np.bool_)
        )


def test_unknown_frame_is_refused_and_the_old_assumption_stays(make: Make, pushed: Scene) -> None:
    estimator = make(standing())
    first = run(estimator, pushed).numbers.copy()
    for wrong in (
        Assumption(contacts=(Contact(frame="l_claw"),)),
        Assumption(source="l_claw"),
        Assumption(known=(KnownWrench(frame="l_claw", wrench=(0, 0, 0, 0, 0, 0)),)),
    ):
        with pytest.raises(AssumptionError, match="l_claw"):
            estimator.assume(wrong)
    assert estimator.assumption == standing()
    assert np.array_equal(run(estimator, pushed).numbers, first)


def test_motion_of_the_source_is_asked_for_and_refused_without_one(
    icub: Robot, pushed: Scene, compiled: bool
) -> None:
    fixed = WholeBodyEstimator(icub.tree, standing(), compiled=compiled)
    floating = WholeBodyEstimator(icub.tree, crawling(), compiled=compiled)
    with pytest.raises(AssumptionError, match="imu_frame"):
        run(floating, pushed)
    with pytest.raises(AssumptionError, match="names no kinematic source"):
        fixed.estimate(pushed.q, pushed.dq, pushed.ddq, pushed.readings, None, pushed.imu)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Contact(frame="l_hand", kind=cast("Kind", "push")),
        lambda: Contact(frame="l_hand", kind="direction"),
        lambda: Contact(frame="l_hand", direction=(0.0, 0.0, 1.0)),
        lambda: Contact(frame="l_hand", kind="direction", direction=(0.0, 0.0, 2.0)),
        lambda: Contact(frame="l_hand", point_m=(0.0, float("nan"), 0.0)),
        lambda: KnownWrench(frame="l_hand", wrench=(0, 0, float("inf"), 0, 0, 0)),
    ],
)
def test_assumption_that_cannot_be_meant_is_refused(wrong: Callable[[], object]) -> None:
    with pytest.raises(AssumptionError, match="l_hand"):
        wrong()


def test_model_names_what_it_knows_when_asked_for_what_it_lacks(icub: Robot) -> None:
    assert icub.tree.link_of_sensor("l_arm_ft") == "l_upper_arm"
    assert icub.tree.sensors == LIMBS
    with pytest.raises(ModelError, match="l_hand"):
        icub.tree.frame("l_claw")
