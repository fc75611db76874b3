"""Raw numbers of a sensor to wrenches."""

import math

import numpy as np
import pytest

from dforc.errors import NotFiniteError, ShapeError
from dforc.signals.ft_channel import FtChannel

RAW = (1.0, 2.0, 3.0, 0.1, 0.2, 0.3)


def held(channel: FtChannel, temperature_degc: float | None = None) -> FtChannel:
    for tick in range(200):
        channel.push(RAW, tick * 0.001, temperature_degc)
    return channel


def test_wrench_is_matrix_times_raw_less_offset_plus_drift() -> None:
    channel = FtChannel(drift_per_degc=[0.5, 0.0, 0.0, 0.0, 0.0, 0.01], reference_degc=30.0)
    C = np.eye(6)
    C[0, 4] = 10.0
    channel.set_matrix(C)
    channel.set_offset([0.5, 0.0, 1.0, 0.0, 0.0, 0.0])
    wrench = channel.wrench(RAW, 34.0)
    assert wrench == pytest.approx([1.0 + 2.0 - 0.5 + 2.0, 2.0, 2.0, 0.1, 0.2, 0.34])
    assert channel.without_offset(RAW, 34.0) == pytest.approx([5.0, 2.0, 3.0, 0.1, 0.2, 0.34])


def test_filtered_wrench_of_a_held_load_is_the_wrench() -> None:
    channel = FtChannel(drift_per_degc=[0.5, 0.0, 0.0, 0.0, 0.0, 0.0], reference_degc=30.0)
    channel.set_offset([0.5, 0.0, 1.0, 0.0, 0.0, 0.0])
    held(channel, 34.0)
    assert channel.settled
    assert channel.filtered(0.2) == pytest.approx(channel.wrench(RAW, 34.0))


def test_new_offset_and_matrix_hold_at_once_behind_the_filter() -> None:
    channel = held(FtChannel())
    channel.set_offset([1.0] * 6)
    channel.set_matrix(2.0 * np.eye(6))
    assert channel.filtered(0.2) == pytest.approx(2.0 * np.array(RAW) - 1.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_changes_nothing(bad: float) -> None:
    channel = held(FtChannel())
    spoilt = (*RAW[:5], bad)
    with pytest.raises(NotFiniteError):
        channel.wrench(spoilt)
    with pytest.raises(NotFiniteError):
        channel.push(spoilt, 0.2)
    with pytest.raises(NotFiniteError):
        channel.push(RAW, 0.2, bad)
    with pytest.raises(NotFiniteError):
        channel.set_offset(spoilt)
    with pytest.raises(NotFiniteError):
        channel.set_matrix(np.diag(spoilt))
    assert channel.filtered(0.2) == pytest.approx(RAW)


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(ShapeError):
        FtChannel().wrench(RAW[:5])
    with pytest.raises(ShapeError):
        FtChannel().set_matrix(np.eye(5))


def test_offset_and_matrix_cannot_be_changed_from_outside() -> None:
    channel = FtChannel()
    with pytest.raises(ValueError, match="read-only"):
        channel.offset[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        channel.matrix[0, 0] = 2.0
