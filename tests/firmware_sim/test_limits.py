"""When a joint counts as outside its limits."""

import numpy as np

from firmware_sim.limits import LimitCounter


def counted(angles_deg: list[float], calibrated_from: int = 0) -> int:
    counter = LimitCounter([(-10.0, 20.0)])
    for tick, angle in enumerate(angles_deg):
        q_rad = np.radians([angle])
        counter.admit(q_rad, np.array([tick >= calibrated_from]))
        counter.step(q_rad)
    return counter.ticks[0]


def test_each_tick_beyond_the_tolerance_counts_once() -> None:
    assert counted([0.0, 20.1, 20.3, 20.3, -10.1, -10.3, 0.0]) == 3


def test_joint_that_was_never_inside_is_not_counted() -> None:
    assert counted([25.0, 25.0, 20.1]) == 0


def test_joint_is_counted_from_the_first_time_inside() -> None:
    assert counted([25.0, 19.0, 25.0]) == 1


def test_joint_is_not_counted_before_its_board_calls_it_calibrated() -> None:
    assert counted([0.0, 30.0, 30.0, 0.0, 30.0], calibrated_from=3) == 1


def test_joint_counts_from_the_tick_in_which_it_is_calibrated_inside_its_limits() -> None:
    counter = LimitCounter([(-10.0, 20.0)])
    counter.admit(np.radians([25.0]), np.array([True]))
    assert counter.waiting == [0]
    counter.admit(np.radians([19.0]), np.array([True]))
    assert counter.waiting == []
    counter.step(np.radians([25.0]))
    assert counter.ticks == [1]


def test_joints_are_counted_apart() -> None:
    counter = LimitCounter([(-1.0, 1.0), (-2.0, 2.0)])
    counter.admit(np.zeros(2), np.ones(2, dtype=np.bool_))
    counter.step(np.radians([1.5, 1.5]))
    assert counter.ticks == [1, 0]
    assert counter.waiting == []
