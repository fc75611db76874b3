import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.wire.numbers import round_half_away, saturate_i16, saturate_i32


@pytest.mark.parametrize(
    ("value", "rounded"),
    [(0.5, 1), (-0.5, -1), (2.5, 3), (-2.5, -3), (2.49, 2), (-2.49, -2), (0.0, 0)],
)
def test_halves_round_away_from_zero(value: float, rounded: int) -> None:
    assert round_half_away(value) == rounded


def test_largest_number_below_one_half_rounds_to_zero() -> None:
    assert round_half_away(math.nextafter(0.5, 0.0)) == 0


@given(st.floats(-1e15, 1e15))
def test_rounding_moves_by_half_at_most_and_is_symmetric(value: float) -> None:
    assert abs(round_half_away(value) - value) <= 0.5
    assert round_half_away(-value) == -round_half_away(value)


@pytest.mark.parametrize(
    ("value", "word"),
    [(32766.5, 32767), (1e9, 32767), (-32768.4, -32768), (-1e9, -32768), (math.inf, 32767)],
)
def test_i16_saturates(value: float, word: int) -> None:
    assert saturate_i16(value) == word


def test_i32_saturates() -> None:
    assert saturate_i32(1e12) == 2**31 - 1
    assert saturate_i32(-math.inf) == -(2**31)
    assert saturate_i32(-1990.5) == -1991


def test_nan_is_refused() -> None:
    with pytest.raises(ValueError, match="NaN"):
        saturate_i16(math.nan)
