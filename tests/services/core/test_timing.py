import pytest

from services.core.timing import Durations


def test_knows_nothing_before_the_first_sample() -> None:
    assert Durations().percentiles_ns(50, 99) == (0.0, 0.0)


@pytest.mark.parametrize("scale_ns", [1, 1_000, 1_000_000, 1_000_000_000])
def test_percentiles_are_right_within_two_percent(scale_ns: int) -> None:
    durations = Durations()
    for value in range(1, 1001):
        durations.add(value * scale_ns)
    p50, p99, p100 = durations.percentiles_ns(50, 99, 100)
    assert p50 == pytest.approx(500 * scale_ns, rel=0.02)
    assert p99 == pytest.approx(990 * scale_ns, rel=0.02)
    assert p100 == pytest.approx(1000 * scale_ns, rel=0.02)
    assert durations.count == 1000


def test_small_values_are_exact_and_negative_ones_are_zero() -> None:
    durations = Durations()
    for value in (-5, 0, 3, 63):
        durations.add(value)
    assert durations.percentiles_ns(50, 75, 100) == (0.0, 3.0, 63.0)


def test_clear_starts_over() -> None:
    durations = Durations()
    durations.add(100)
    durations.clear()
    durations.add(7)
    assert durations.count == 1
    assert durations.percentiles_ns(99) == (7.0,)
