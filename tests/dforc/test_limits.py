"""Joint ranges and rows."""

import numpy as np
import pytest

from dforc.errors import LimitsError
from dforc.limits import JointLimits


def test_projection_keeps_rows_and_is_nearest(limits: JointLimits) -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        outside = rng.uniform(limits.lower_rad - 0.5, limits.upper_rad + 0.5)
        q = limits.project(outside)
        assert limits.violation(q) <= 1e-9
        for _ in range(5):  # no feasible point on the way to another one is nearer
            other = limits.project(rng.uniform(limits.lower_rad, limits.upper_rad))
            assert (outside - q) @ (other - q) <= 1e-7


def test_posture_inside_is_not_moved(limits: JointLimits) -> None:
    q = np.radians([0.0, 0.0, 0.0, -30.0, 30.0, 0.0, 45.0, 0.0, 0.0, 0.0])
    assert np.array_equal(limits.project(q), q)
    assert limits.violation(q) == pytest.approx(-np.radians(30.0 - 26.4188))  # the cover row


def test_violation_is_the_largest_distance_outside() -> None:
    limits = JointLimits.make([-1.0, -1.0], [1.0, 1.0], np.array([[1.0, 1.0]]), [-0.5], [0.5])
    assert limits.violation(np.array([0.9, 0.4])) == pytest.approx(0.8)
    assert limits.violation(np.array([1.3, -0.8])) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("lower", "upper", "named"),
    [([0.0, 2.0], [1.0, 1.0], "joint 1"), ([0.0, np.nan], [1.0, 1.0], "joint 1")],
)
def test_impossible_range_is_named(lower: list[float], upper: list[float], named: str) -> None:
    with pytest.raises(LimitsError, match=named):
        JointLimits.make(lower, upper)


def test_rows_that_leave_no_posture_are_refused() -> None:
    with pytest.raises(LimitsError, match="no posture"):
        JointLimits.make([0.0, 0.0], [1.0, 1.0], np.array([[1.0, 1.0]]), [3.0], [4.0])


def test_rows_of_another_width_are_refused() -> None:
    with pytest.raises(LimitsError):
        JointLimits.make([0.0, 0.0], [1.0, 1.0], np.ones((1, 3)), [0.0], [1.0])
    with pytest.raises(LimitsError):
        JointLimits.make([0.0, 0.0], [1.0, 1.0], np.ones((1, 2)), [0.0], [1.0, 2.0])


def test_limits_cannot_be_changed_behind_the_owner() -> None:
    lower = np.array([0.0, 0.0])
    limits = JointLimits.make(lower, [1.0, 1.0])
    lower[0] = 0.5
    assert limits.lower_rad[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        limits.lower_rad[0] = 0.5
