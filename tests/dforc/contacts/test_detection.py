import math

import numpy as np
import pytest

from dforc.contacts.detection import ContactDetector, ThresholdError, threshold_for
from dforc.errors import NotFiniteError


def states(detector: ContactDetector, *levels: float) -> list[bool]:
    return [detector.update(level) for level in levels]


def test_a_contact_begins_with_the_second_high_sample_in_a_row() -> None:
    detector = ContactDetector(2.5, 1.5)
    assert states(detector, 2.5, 2.4, 2.5, 2.5) == [False, False, False, True]


def test_a_contact_ends_with_the_third_low_sample_in_a_row() -> None:
    detector = ContactDetector(2.5, 1.5)
    states(detector, 3.0, 3.0)
    assert states(detector, 1.0, 1.0, 1.5, 1.0, 1.0, 1.0) == [True] * 5 + [False]


def test_between_the_thresholds_nothing_changes() -> None:
    detector = ContactDetector(2.5, 1.5)
    assert states(detector, *[2.0] * 5) == [False] * 5
    states(detector, 3.0, 3.0)
    assert states(detector, *[2.0] * 5) == [True] * 5


def test_without_debounce_one_sample_is_enough_either_way() -> None:
    detector = ContactDetector(3.0, 3.0, on_samples=1, off_samples=1)
    assert states(detector, 3.0, 2.9) == [True, False]


@pytest.mark.parametrize("level", [math.nan, math.inf])
def test_a_level_that_is_not_finite_changes_nothing(level: float) -> None:
    detector = ContactDetector(2.5, 1.5)
    detector.update(3.0)
    with pytest.raises(NotFiniteError):
        detector.update(level)
    assert not detector.touching
    assert detector.update(3.0)


def test_reset_forgets_the_contact_and_half_of_the_next() -> None:
    detector = ContactDetector(2.5, 1.5)
    states(detector, 3.0, 3.0)
    detector.reset()
    assert not detector.touching
    assert states(detector, 3.0, 3.0) == [False, True]


@pytest.mark.parametrize(("on", "off"), [(1.0, 2.0), (1.0, 0.0), (math.inf, 1.0), (math.nan, 1.0)])
def test_thresholds_the_wrong_way_round_are_refused(on: float, off: float) -> None:
    with pytest.raises(ThresholdError, match="0 < off <= on"):
        ContactDetector(on, off)


@pytest.mark.parametrize("samples", [0, 4])
def test_a_debounce_of_more_than_three_samples_is_refused(samples: int) -> None:
    with pytest.raises(ThresholdError, match="1 to 3"):
        ContactDetector(2.0, 1.0, on_samples=samples)


def test_an_exponential_level_is_exceeded_as_often_as_asked() -> None:
    # P(level > t) = exp(-t / 0.2): at 100 Hz one in 360 000 samples is beyond 0.2 ln 360000
    levels = -0.2 * np.log((np.arange(20_000) + 0.5) / 20_000)
    assert threshold_for(levels, 0.01) == pytest.approx(0.2 * math.log(360_000), rel=0.01)
    assert threshold_for(levels, 0.01, 36.0) == pytest.approx(0.2 * math.log(10_000), rel=0.01)


def test_a_threshold_from_too_few_or_equal_levels_is_refused() -> None:
    with pytest.raises(ThresholdError, match="99 levels"):
        threshold_for(np.linspace(0.0, 1.0, 99), 0.01)
    with pytest.raises(ThresholdError, match="do not vary"):
        threshold_for(np.ones(200), 0.01)
