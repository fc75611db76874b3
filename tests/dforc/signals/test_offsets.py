"""Offsets of named sensors from samples in motion."""

import math

import numpy as np
import pytest

from benchmarks.ft_rows import offset_errors_n
from dforc.errors import NotFiniteError
from dforc.signals.offsets import (
    Calibrations,
    IncompleteError,
    OffsetCalibration,
    UnknownSensorError,
)

ZERO = (0.0,) * 6


def test_offset_and_spread_are_mean_and_deviation_of_measured_less_predicted() -> None:
    calibration = OffsetCalibration(2)
    assert calibration.add((3.0, 0.0, 1.0, 0.0, 0.0, 0.1), (1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert calibration.add((8.0, 0.0, 1.0, 0.0, 0.0, 0.3), (4.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert calibration.complete
    assert calibration.offset == pytest.approx([3.0, 0.0, 1.0, 0.0, 0.0, 0.2])
    assert calibration.spread == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, 0.1])


def test_arm_may_move_slowly_meanwhile() -> None:
    errors, predicted_once, spread = offset_errors_n(3)
    assert max(errors) <= 0.02
    assert min(predicted_once) > 0.1
    assert spread < 0.1


def test_touched_limb_gives_no_sample() -> None:
    calibration = OffsetCalibration(1)
    assert not calibration.add((50.0,) * 6, ZERO, in_contact=True)
    assert calibration.refused == 1
    assert not calibration.complete
    with pytest.raises(IncompleteError, match="0 samples of 1"):
        _ = calibration.offset


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_not_averaged(bad: float) -> None:
    calibration = OffsetCalibration(2)
    calibration.add((1.0,) * 6, ZERO)
    for measured, predicted in (((bad,) * 6, ZERO), (ZERO, (bad,) * 6)):
        with pytest.raises(NotFiniteError):
            calibration.add(measured, predicted)
    calibration.add((3.0,) * 6, ZERO)
    assert calibration.offset == pytest.approx([2.0] * 6)


def test_only_the_named_sensors_are_calibrated() -> None:
    calibrations = Calibrations(["l_arm_ft", "r_arm_ft", "l_leg_ft"])
    calibrations.start(["l_arm_ft", "r_arm_ft"], 2)
    done = {
        name: [calibrations.add(name, (float(k),) * 6, ZERO) for k in range(2)]
        for name in calibrations.sensors
    }
    assert done["l_leg_ft"] == [None, None]
    for name in ("l_arm_ft", "r_arm_ft"):
        first, second = done[name]
        assert first is None
        assert second is not None
        assert second.offset == pytest.approx([0.5] * 6)
    assert calibrations.running == ()


def test_unknown_sensor_starts_none() -> None:
    calibrations = Calibrations(["l_arm_ft"])
    with pytest.raises(UnknownSensorError, match="'l_arm'; known: l_arm_ft"):
        calibrations.start(["l_arm_ft", "l_arm"], 10)
    assert calibrations.running == ()


def test_cancelled_calibration_gives_nothing() -> None:
    calibrations = Calibrations(["l_arm_ft"])
    calibrations.start(["l_arm_ft"], 1)
    calibrations.cancel("l_arm_ft")
    assert calibrations.progress("l_arm_ft") is None
    assert calibrations.add("l_arm_ft", np.ones(6), ZERO) is None
