"""Tuning of the Cartesian controller."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from dforc.cartesian.outer_correction import CorrectionParams
from dforc.errors import DforcError


class ParameterError(DforcError, ValueError):
    """A tuning value that no controller can have."""


class Law(StrEnum):
    """How the plan is drawn to its target."""

    TIME_TO_GO = "time_to_go"  # exact minimum jerk, straight, inside all limits
    REFERENCE = "reference"  # the law of the papers and of the iCub's own controller


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingParams:
    """How the generators share the joints.

    `gamma` weighs the path of the tips against the path of the joints, which has the weight 1.
    """

    gamma: float | None = None  # None: 0.05 of iKin for the reference law, 2e4 for the other one
    speed_limit_rad_s: float | Sequence[float] = 1.75  # of every joint, or one for each
    # A joint or row may come near its limit as fast as this stops it; half the next one at most.
    braking_rad_s2: float = 10.0
    acceleration_limit_rad_s2: float = 40.0  # of every joint, where limits and rows leave a choice
    guard_ratio: float = 0.1  # reference law: share of the range, half at each end, without task


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianParams:
    """Tuning of the controller.

    `following_time_s` is the floor of the task's time to go: the plan trails an acceleration a of
    the target by 0.15 of its square times a, and overshoots a corner by 0.2 of it times the change
    of speed. `lead_s` moves the reference ahead by the plan's speed, against a lag of the boards
    below: it helps a stiff arm whose back-EMF is not compensated, and makes a compliant arm with
    compensation overshoot (5 mm of clearance lost at 40 ms).
    """

    law: Law = Law.TIME_TO_GO
    period_s: float = 0.01
    trajectory_time_s: float = 0.5  # T: duration of the move to a target that jumps
    following_time_s: float = 0.05
    posture_time_s: float = 0.3  # floor of the joints' time to go
    stop_time_s: float = 0.4  # of the plan without a target, and of a joint that is blocked
    speed_time_s: float = 0.3  # in which a commanded speed of a tip is taken up
    lead_s: float = 0.0
    position_tolerance_m: float = 0.003  # in target
    orientation_tolerance_rad: float = math.radians(1.5)
    rest_band_m: float = 2e-4  # in target, a target at rest that trembles by less is not followed
    rest_band_rad: float = 2e-3
    coupling: CouplingParams = field(default_factory=CouplingParams)
    correction: CorrectionParams = field(default_factory=CorrectionParams)

    def check(self) -> None:
        """Raise ParameterError for times that no motion can have."""
        for name in (
            "period_s",
            "trajectory_time_s",
            "following_time_s",
            "posture_time_s",
            "stop_time_s",
            "speed_time_s",
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= self.period_s > 0.0):
                raise ParameterError(f"{name} must be at least one period, not {value}")
        gamma = self.coupling.gamma
        if gamma is not None and not (math.isfinite(gamma) and gamma > 0.0):
            raise ParameterError(f"gamma must be a positive number, not {gamma}")
