"""What a user may choose about the Passive Motion Paradigm, and what is refused."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from dforc.errors import DforcError


class PmpError(DforcError, ValueError):
    """A constant, limits or a period that make no motion."""


class Variant(StrEnum):
    """Where the point of the virtual arm comes from."""

    A = "A"  # eq. 6: x = integral of J dq; drifts away from the arm
    B = "B"  # eq. 7: x = kin(integral of dq)


class Orientation(StrEnum):
    """How a target's orientation draws the hand."""

    NONE = "none"
    RAW = "raw"  # difference of two rotation vectors: no rotation, and it lets the hand run away
    LOG = "log"  # rotation vector of the rotation between the two


@dataclass(frozen=True, slots=True, kw_only=True)
class PmpParams:
    """Constants of PMP; by default the paper's.

    A value per joint may stand where one for all does. The papers' K = "4 N" is 4 N/m, and
    4 Nm/rad where the orientation is controlled too.
    """

    variant: Variant = Variant.B
    stiffness_n_m: float = 4.0  # K
    angular_stiffness_nm_rad: float = 4.0
    orientation: Orientation = Orientation.NONE
    limit_gain_nm: float | tuple[float, ...] = 0.05  # alpha; 0: no field at the joint limits
    admittance_rad_nms: float | tuple[float, ...] = 1.0  # diagonal of A_int
    has_time_base: bool = True  # eq. 10; False: the gain is 1 for ever
    duration_s: float = 3.0  # tau
    epsilon: float = 1e-3
    clamped: bool = True  # joints stop at their limits

    def __post_init__(self) -> None:
        """Refuse constants that let the arm run away."""
        _refuse("stiffness", (self.stiffness_n_m, self.angular_stiffness_nm_rad))
        _refuse("limit gain", per_joint(self.limit_gain_nm, 1))
        _refuse("admittance", per_joint(self.admittance_rad_nms, 1))
        for name, value in (("duration", self.duration_s), ("epsilon", self.epsilon)):
            if not (math.isfinite(value) and value > 0.0):
                raise PmpError(f"PMP's {name} must be a positive number, not {value}")


def per_joint(value: float | tuple[float, ...], n: int) -> Sequence[float]:
    """One value for each of n joints; a tuple stays as it is."""
    return value if isinstance(value, tuple) else (value,) * n


def _refuse(name: str, values: Sequence[float]) -> None:
    if not all(math.isfinite(value) and value >= 0.0 for value in values):
        raise PmpError(f"PMP's {name} must be numbers >= 0, not {tuple(values)}")
