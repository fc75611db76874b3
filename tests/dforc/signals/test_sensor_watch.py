"""What is wrong with a reading, in the tick in which it comes."""

import math

import pytest

from benchmarks.sensor_fault_rows import fault_tally, joint_faults_not_finite
from dforc.signals.sensor_watch import FROZEN_READINGS, Flag, SensorWatch

FULL_SCALE = (100.0,) * 3 + (5.0,) * 3


def reading(tick: int) -> tuple[float, ...]:
    return (1.0 + 0.1 * (tick % 7), 2.0, -3.0, 0.1, 0.2, -0.3)


def healthy(ticks: int = 5) -> SensorWatch:
    watch = SensorWatch(full_scale=FULL_SCALE)
    for tick in range(ticks):
        assert watch.check(reading(tick), 0.001, stamp_s=tick * 0.01) == ()
    return watch


def test_sensor_is_missing_until_its_first_reading_and_valid_with_it() -> None:
    watch = SensorWatch()
    assert not watch.valid
    assert watch.flags == ("missing",)
    assert watch.check(None, math.inf) == ("missing",)
    watch = SensorWatch()
    assert watch.check(reading(0), 0.0) == ()
    assert watch.valid


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (math.nan, "nan"),
        (math.inf, "inf"),
        (-math.inf, "inf"),
        (100.0, "saturated"),
        (-100.0, "saturated"),
    ],
)
def test_impossible_value_is_flagged_with_its_cause(value: float, expected: Flag) -> None:
    watch = healthy()
    assert watch.check((1.0, 2.0, value, 0.1, 0.2, -0.3), 0.001, stamp_s=0.05) == (expected,)
    assert not watch.valid


def test_moment_has_a_range_of_its_own() -> None:
    watch = healthy()
    assert watch.check((1.0, 2.0, -3.0, 0.1, 0.2, -5.0), 0.001, stamp_s=0.05) == ("saturated",)


@pytest.mark.parametrize(("age_s", "expected"), [(0.02, ()), (0.021, ("late",))])
def test_old_reading_is_late(age_s: float, expected: tuple[Flag, ...]) -> None:
    assert healthy().check(reading(5), age_s, stamp_s=0.05) == expected


@pytest.mark.parametrize("age_s", [0.11, math.inf, math.nan])
def test_very_old_reading_is_missing(age_s: float) -> None:
    assert healthy().check(reading(5), age_s, stamp_s=0.05) == ("missing",)


def test_tick_without_a_reading_is_no_fault_until_the_last_one_is_old() -> None:
    watch = healthy()
    assert watch.check(None, 0.01) == ()
    assert watch.valid
    assert watch.check(None, 0.021) == ("missing",)
    assert not watch.valid


def test_board_that_says_saturated_or_frozen_is_believed_at_once() -> None:
    assert healthy().check(reading(5), 0.0, saturated=True, stamp_s=0.05) == ("saturated",)
    assert healthy().check(reading(5), 0.0, frozen=True, stamp_s=0.05) == ("frozen",)


def test_equal_readings_freeze_and_the_first_other_one_thaws() -> None:
    watch = SensorWatch()
    flags = [watch.check(reading(0), 0.0, stamp_s=k * 0.01) for k in range(FROZEN_READINGS)]
    assert flags[:-1] == [()] * (FROZEN_READINGS - 1)
    assert flags[-1] == ("frozen",)
    assert watch.check(reading(1), 0.0, stamp_s=1.0) == ()
    assert watch.check(reading(2), 0.0, stamp_s=1.01) == ()
    assert watch.valid


def test_same_reading_seen_again_is_not_frozen() -> None:
    watch = SensorWatch()
    for _ in range(3 * FROZEN_READINGS):
        assert watch.check(reading(0), 0.0, stamp_s=0.5) == ()
    assert watch.valid


def test_reading_that_was_overtaken_is_reordered() -> None:
    watch = healthy()
    assert watch.check(reading(9), 0.0, stamp_s=0.02) == ("reordered",)
    assert not watch.valid


def test_several_causes_are_all_told_and_counted() -> None:
    watch = healthy()
    assert set(watch.check((math.nan, math.inf, 0, 0, 0, 0), 0.05, stamp_s=0.01)) == {
        "nan",
        "inf",
        "late",
        "reordered",
    }
    assert watch.counts == {"nan": 1, "inf": 1, "late": 1, "reordered": 1}


def test_sensor_is_valid_with_the_second_good_reading_after_a_fault() -> None:
    watch = healthy()
    watch.check((math.nan,) * 6, 0.0, stamp_s=0.05)
    assert watch.check(reading(6), 0.0, stamp_s=0.06) == ()
    assert not watch.valid
    watch.check(reading(6), 0.0, stamp_s=0.06)  # the same one again does not count
    assert not watch.valid
    assert watch.check(reading(7), 0.0, stamp_s=0.07) == ()
    assert watch.valid


def test_ten_thousand_random_faults_are_flagged_at_once_and_forgotten_in_two_readings() -> None:
    tally = fault_tally(10_000, seed=7)
    assert tally.faulty == 10_000
    assert tally.unflagged == 0
    assert tally.believed == 0
    assert tally.false_alarms == 0
    assert tally.not_finite == 0
    assert len(tally.recoveries) > 1000
    assert max(tally.recoveries) == 2


def test_faulty_joint_states_never_give_a_nan() -> None:
    assert joint_faults_not_finite(3000, seed=7) == 0
