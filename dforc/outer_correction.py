"""Integral correction of the joint reference by the measured error of the hand against the plan.

Friction, gravity and the spring of a compliant arm leave the hand beside its plan. Each period

    c += k dt W J' (J W J' + lambda I)^-1 e,   e = (x_plan - x ; rotation vector of R_plan R')

moves the joint reference q_plan + c. The correction is bounded, and stands still while the
estimated external force exceeds a threshold (with hysteresis): otherwise a pushed compliant arm
would push back until its compliance is gone.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionParams:
    """Tuning of the correction."""

    gain_per_s: float = 4.0  # k; 0 switches the correction off
    damping: float = 1e-4  # lambda
    bound_rad: float = 0.25  # of each joint's correction
    force_on_n: float = 2.0  # freezes above; contact-free estimates stay below 0.3 N
    force_off_n: float = 1.2  # thaws below
    position_deadband_m: float = 1e-4
    orientation_deadband_rad: float = 1e-3
    position_error_limit_m: float = 0.02  # a larger error does not correct faster: a released arm
    orientation_error_limit_rad: float = 0.1  # springs back by itself


@dataclass(frozen=True, slots=True, eq=False)
class CorrectionState:
    """What is carried from period to period."""

    offset_rad: Vector  # c (n,)
    gated: bool
    saturated: bool

    @classmethod
    def none(cls, n: int) -> "CorrectionState":
        """No correction yet."""
        return cls(np.zeros(n), False, False)


class OuterCorrection:
    """The constants of the correction: its tuning and W (n,), the share of each joint."""

    def __init__(self, weights: ArrayLike, params: CorrectionParams) -> None:
        self._weights = constant(weights)
        self._params = params

    def step(
        self,
        state: CorrectionState,
        error: Vector,
        J: Matrix,
        external_force_n: float,
        period_s: float,
    ) -> CorrectionState:
        """One period.

        Args:
            state: as the previous period left it.
            error: e (6,), plan minus measured: [m] and rotation vector [rad], base frame.
            J: Jacobian of the hand (6, n) at the measured posture.
            external_force_n: norm of the estimated force on the hand.
            period_s: dt.
        """
        p = self._params
        gated = external_force_n > (p.force_off_n if state.gated else p.force_on_n)
        if gated or p.gain_per_s == 0.0:
            return CorrectionState(state.offset_rad, gated, state.saturated)
        e = np.concatenate(
            [
                _within(error[:3], p.position_deadband_m, p.position_error_limit_m),
                _within(error[3:], p.orientation_deadband_rad, p.orientation_error_limit_rad),
            ]
        )
        JW = J * self._weights
        M = JW @ J.T
        M[np.diag_indices(6)] += p.damping
        wanted = state.offset_rad + (p.gain_per_s * period_s) * (JW.T @ np.linalg.solve(M, e))
        offset: Vector = np.clip(wanted, -p.bound_rad, p.bound_rad)
        return CorrectionState(offset, False, bool((offset != wanted).any()))


def _within(error: Vector, deadband: float, limit: float) -> Vector:
    """The error less its dead band, limited in length, in its direction."""
    size = float(np.sqrt(error @ error))
    if size <= deadband:
        return np.zeros(3)
    shortened: Vector = error * (min(size - deadband, limit) / size)
    return shortened
