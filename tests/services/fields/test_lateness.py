import logging

import pytest

from services.core.clock import NS_PER_MS
from services.fields.lateness import Lateness


def noted(*periods: tuple[int, int]) -> Lateness:
    """Of periods that began at these times and so late [ms]."""
    lateness = Lateness()
    for at_ms, late_ms in periods:
        lateness.note(at_ms * NS_PER_MS, late_ms * NS_PER_MS)
    return lateness


def test_the_largest_of_the_last_second_is_told() -> None:
    assert noted((10, 1), (20, 7), (30, 3)).largest_ms == 7.0
    assert noted((10, 1), (20, 7), (30, 3), (1020, 2)).largest_ms == 7.0
    assert noted((10, 1), (20, 7), (30, 3), (1021, 2)).largest_ms == 3.0
    assert noted((10, 1), (20, 7), (30, 3), (1021, 2), (1031, 0)).largest_ms == 2.0


def test_up_to_five_periods_are_not_warned_of(caplog: pytest.LogCaptureFixture) -> None:
    assert noted((10, 50), (20, 40)).count == 0
    assert caplog.records == []


def test_a_stall_is_warned_of_once_and_the_next_one_again(caplog: pytest.LogCaptureFixture) -> None:
    stall = ((200, 51), (201, 80), (202, 70), (900, 90))
    lateness = noted((10, 0), *stall, (1500, 0), (1890, 0))
    assert lateness.count == 1
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "51 ms late" in record.getMessage()
    lateness.note(1901 * NS_PER_MS, 0)  # a second without a late period: this one is over
    lateness.note(1911 * NS_PER_MS, 60 * NS_PER_MS)
    assert lateness.count == 2
    assert len(caplog.records) == 2
