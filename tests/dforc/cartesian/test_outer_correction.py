"""The integral correction: convergence, bound, rest, gate."""

import numpy as np
import pytest

from dforc.arrays import Vector
from dforc.cartesian.outer_correction import CorrectionParams, CorrectionState, corrected

PERIOD_S = 0.01
PARAMS = CorrectionParams()
ARM = (False, True, True)  # the first joint is stiff
BESIDE = np.array([0.01, 0.01, -0.02])


def step(
    state: CorrectionState,
    error_rad: Vector = BESIDE,
    force_n: float = 0.0,
    compliant: tuple[bool, ...] = ARM,
    params: CorrectionParams = PARAMS,
) -> CorrectionState:
    return corrected(state, error_rad, compliant, force_n, PERIOD_S, params)


def test_only_compliant_joints_are_corrected_in_proportion_to_their_error() -> None:
    state = step(CorrectionState.none(3))
    assert state.offset_rad == pytest.approx([0.0, 4.0 * PERIOD_S * 0.01, -4.0 * PERIOD_S * 0.02])


def test_correction_fades_out_when_a_joint_turns_stiff() -> None:
    state = step(CorrectionState.none(3))
    offset = state.offset_rad[1]
    state = step(state, compliant=(False, False, True))
    assert state.offset_rad[1] == pytest.approx((1.0 - 4.0 * PERIOD_S) * offset)


def test_a_joint_that_has_arrived_is_left_alone_until_it_is_well_away_again() -> None:
    state, moved = CorrectionState.none(1), []
    for away_rad in (0.0015, 0.0010, 0.0025, 0.0032, 0.0025):
        before = state.offset_rad
        state = step(state, np.array([away_rad]), compliant=(True,))
        moved.append(not np.array_equal(state.offset_rad, before))
    assert moved == [True, False, False, True, True]


def test_correction_stays_within_its_bound_and_leaves_it_at_once() -> None:
    params = CorrectionParams(bound_rad=0.05)
    state = CorrectionState.none(3)
    for _ in range(1000):
        state = step(state, params=params)
    assert state.saturated
    assert float(np.abs(state.offset_rad).max()) == pytest.approx(0.05)
    after = step(state, -BESIDE, params=params)
    assert not after.saturated


def test_gate_closes_above_2_n_and_opens_only_below_1_2_n() -> None:
    state, gated = CorrectionState.none(3), []
    for force_n in (1.9, 2.1, 1.5, 1.1, 1.5):
        before = state.offset_rad
        state = step(state, force_n=force_n)
        gated.append(state.gated)
        assert np.array_equal(state.offset_rad, before) == state.gated
    assert gated == [False, True, True, False, False]


def test_large_error_corrects_no_faster_than_its_limit() -> None:
    near, far = (step(CorrectionState.none(3), np.full(3, e)) for e in (0.0501, 0.5))
    assert near.offset_rad == pytest.approx(far.offset_rad)


def test_gain_zero_switches_it_off() -> None:
    state = step(CorrectionState.none(3), params=CorrectionParams(gain_per_s=0.0))
    assert not state.offset_rad.any()
