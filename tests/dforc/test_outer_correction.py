"""The integral correction: convergence, bound, gate."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.outer_correction import CorrectionParams, CorrectionState, OuterCorrection
from dforc.robot_model import RobotModel

PERIOD_S = 0.01
NO_ERROR = np.zeros(6)
BESIDE = np.array([0.003, 0.0, 0.0, 0.0, 0.0, 0.02])


def test_correction_moves_the_hand_against_its_error(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    params = CorrectionParams(position_deadband_m=0.0, orientation_deadband_rad=0.0, damping=1e-8)
    J = model.tip_jacobian(home)
    outer, state = OuterCorrection(correction_weights, params), CorrectionState.none(10)
    state = outer.step(state, BESIDE, J, 0.0, PERIOD_S)
    assert J @ state.offset_rad == pytest.approx(4.0 * PERIOD_S * BESIDE, rel=1e-3, abs=1e-9)


def test_error_inside_the_dead_band_moves_nothing(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    outer = OuterCorrection(correction_weights, CorrectionParams())
    small = np.array([0.9e-4, 0.0, 0.0, 0.0, 0.9e-3, 0.0])
    state = outer.step(CorrectionState.none(10), small, model.tip_jacobian(home), 0.0, PERIOD_S)
    assert state.offset_rad == pytest.approx(np.zeros(10))


def test_correction_stays_within_its_bound_and_leaves_it_at_once(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    params = CorrectionParams(bound_rad=0.05)
    outer, state = OuterCorrection(correction_weights, params), CorrectionState.none(10)
    J = model.tip_jacobian(home)
    for _ in range(2000):
        state = outer.step(state, BESIDE, J, 0.0, PERIOD_S)
    assert state.saturated
    assert float(np.abs(state.offset_rad).max()) == pytest.approx(0.05)
    after = outer.step(state, -BESIDE, J, 0.0, PERIOD_S)
    assert (np.abs(after.offset_rad) < 0.05).any()
    assert not after.saturated


def test_gate_closes_above_2_n_and_opens_only_below_1_2_n(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    outer, J = OuterCorrection(correction_weights, CorrectionParams()), model.tip_jacobian(home)
    state, gated = CorrectionState.none(10), []
    for force_n in (1.9, 2.1, 1.5, 1.1, 1.5):
        before = state.offset_rad
        state = outer.step(state, BESIDE, J, force_n, PERIOD_S)
        gated.append(state.gated)
        assert np.array_equal(state.offset_rad, before) == state.gated
    assert gated == [False, True, True, False, False]


def test_large_error_corrects_no_faster_than_its_limit(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    outer, J = OuterCorrection(correction_weights, CorrectionParams()), model.tip_jacobian(home)
    near, far = (
        outer.step(
            CorrectionState.none(10), np.array([0.0, 0.0, z, 0.0, 0.0, 0.0]), J, 0.0, PERIOD_S
        )
        for z in (0.0201, 0.2)
    )
    assert near.offset_rad == pytest.approx(far.offset_rad)


def test_gain_zero_switches_it_off(
    model: RobotModel, home: Vector, correction_weights: Vector
) -> None:
    outer = OuterCorrection(correction_weights, CorrectionParams(gain_per_s=0.0))
    J = model.tip_jacobian(home)
    state = outer.step(CorrectionState.none(10), BESIDE, J, 0.0, PERIOD_S)
    assert not state.offset_rad.any()
