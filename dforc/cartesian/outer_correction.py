"""Integral correction of the reference of compliant joints by their error against the plan.

Dry friction, an inexact gravity model and the spring leave a compliant joint beside its plan. Each
period

    c += k dt (q_plan - q),    q_ref = q_plan + c

takes that out. A stiff joint has such an integrator on its board, and two of them around one dry
friction would hunt for ever: so only compliant joints are corrected, and the correction of a joint
that turns stiff fades out. For the same reason a joint that has come to within an encoder tick
is left alone until it is well away again.

The correction is bounded, and stands still while the estimated external force exceeds a threshold
(with hysteresis): otherwise a pushed arm would push back until its compliance is gone.

The same integral over the hand's error (inner-loop reference, section 3) needs the stiff joints to
correct six directions with four compliant ones, and hunted: 1 to 3 mm at rest, here 0.5.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Vector
from dforc.compiled import compiled

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionParams:
    """Tuning of the correction."""

    gain_per_s: float = 4.0  # k; 0 switches the correction off
    bound_rad: float = 0.25  # of each joint's correction
    error_limit_rad: float = 0.05  # a larger error does not correct faster: a released arm springs
    force_on_n: float = 2.0  # freezes above; contact-free estimates stay below 0.6 N
    force_off_n: float = 1.2  # thaws below
    settle_rad: float = 0.0012  # under a tick of the 12-bit encoders, 0.07 deg: arrived
    wake_rad: float = 0.0030  # two ticks: go on


@dataclass(frozen=True, slots=True, eq=False)
class CorrectionState:
    """What is carried from period to period."""

    offset_rad: Vector  # c (n,)
    settled: Flags  # (n,)
    gated: bool
    saturated: bool

    @classmethod
    def none(cls, n: int) -> "CorrectionState":
        """No correction yet."""
        return cls(np.zeros(n), np.zeros(n, dtype=np.bool_), gated=False, saturated=False)


def corrected(
    state: CorrectionState,
    error_rad: Vector,
    compliant: Sequence[bool],
    external_force_n: float,
    period_s: float,
    params: CorrectionParams,
) -> CorrectionState:
    """The correction one period later.

    Args:
        state: as the previous period left it.
        error_rad: plan minus measured angle (n,).
        compliant: joints that are corrected (n,); the correction of the others fades out.
        external_force_n: norm of the estimated force on the hand.
        period_s: dt.
        params: tuning.
    """
    share = min(1.0, params.gain_per_s * period_s)
    gated = external_force_n > (params.force_off_n if state.gated else params.force_on_n)
    offset, settled = state.offset_rad.copy(), state.settled.copy()
    saturated = _correct(
        offset,
        settled,
        error_rad,
        np.asarray(compliant, dtype=np.bool_),
        gated,
        share,
        params.bound_rad,
        params.error_limit_rad,
        params.settle_rad,
        params.wake_rad,
    )
    return CorrectionState(offset, settled, gated, saturated)


@compiled
def _correct(
    offset: Vector,
    settled: Flags,
    error: Vector,
    compliant: Flags,
    gated: bool,
    share: float,
    bound: float,
    error_limit: float,
    settle: float,
    wake: float,
) -> bool:
    """Offsets and flags in place; whether a bound cut an offset."""
    cut = False
    for i in range(len(offset)):
        settled[i] = abs(error[i]) <= (wake if settled[i] else settle)
        wanted = offset[i]
        if not compliant[i]:
            wanted = (1.0 - share) * wanted
        elif not settled[i] and not gated:
            wanted += share * min(max(error[i], -error_limit), error_limit)
        offset[i] = min(max(wanted, -bound), bound)
        cut = cut or offset[i] != wanted
    return cut
