"""Joint torques and the contact wrench of a limb from its force-torque sensor.

The wrench w that the limb beyond the sensor exerts on the near side is measured; its part w_i due to
the limb's own weight and motion comes from the Newton-Euler pass (force control paper, eqs. 8 to 10).
The rest is what the world exerts on the limb, here assumed to act at the hand (eq. 2):

    f = R_s (w - w_offset - w_i)_force,  m = R_s (...)_moment + (p_s - p_hand) x f
    tau = RNEA(q, dq, 0) - J_hand' (f, m)

tau is the torque that the drives exert on the joints, gravity and motion included: a drive has to
hold what gravity asks and give back what the world already contributes, hence the minus. (The papers
write the torque of the external wrench itself, eq. 3, with the opposite reading of "exerts".)
The joint accelerations are left at zero: what they add beyond the sensor is measured and ends up in
the wrench at the hand. A push between base and sensor is invisible to the estimate.

Wrenches are (6,): force [N], then moment [Nm].
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import DforcError


class NotAtRestError(DforcError):
    """A calibration sample was taken while the limb moved."""


class LimbModel(Protocol):
    """What the estimate asks of dforc.robot_model.RobotModel."""

    n: int

    def inverse_dynamics(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector
    ) -> tuple[Vector, dict[str, Vector]]: ...

    def sensor_wrench(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector, name: str
    ) -> Vector: ...

    def sensor_pose(self, q_rad: Vector, name: str) -> tuple[Matrix, Vector]: ...

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]: ...

    def tip_jacobian(self, q_rad: Vector) -> Matrix: ...

    def gravity(self, q_rad: Vector) -> Vector: ...


@dataclass(frozen=True, slots=True)
class Estimate:
    """What the drives exert, and what the world exerts on the hand."""

    tau_nm: Vector  # (n,), the order of the model's joints
    force_n: Vector  # (3,), on the hand, base frame
    moment_nm: Vector  # (3,), on the hand about the tip frame's origin, base axes


@dataclass(frozen=True, slots=True)
class OffsetSamples:
    """Running sum of (measured - predicted) wrenches, taken at rest and without contact."""

    wanted: int
    count: int = 0
    sum_wrench: tuple[float, ...] = (0.0,) * 6
    sum_square: tuple[float, ...] = (0.0,) * 6

    @property
    def complete(self) -> bool:
        """Enough samples are in."""
        return self.count >= self.wanted


class TorqueEstimator:
    """Torque estimate of one limb: a pure function of its arguments, given model and sensor."""

    def __init__(self, model: LimbModel, sensor: str) -> None: ...

    def estimate(
        self, q_rad: ArrayLike, dq_rad_s: ArrayLike, wrench: ArrayLike, offset: ArrayLike
    ) -> Estimate:
        """Torques and external wrench from one reading.

        Args:
            q_rad: joint angles (n,).
            dq_rad_s: joint velocities (n,).
            wrench: sensor reading (6,): limb beyond the sensor on the near side, sensor frame.
            offset: what the sensor reads in excess (6,), as `offset_of` gives it; zeros before.

        Raises:
            NotFiniteError: an input holds NaN or infinity; nothing was computed.
        """
        raise NotImplementedError

    def gravity(self, q_rad: ArrayLike) -> Vector:
        """Gravity torques (n,) [Nm] of the model: the impedance offset of compliant axes."""
        raise NotImplementedError

    def add_sample(
        self, samples: OffsetSamples, q_rad: ArrayLike, dq_rad_s: ArrayLike, wrench: ArrayLike
    ) -> OffsetSamples:
        """`samples` with one more reading; raises instead of taking in a bad one.

        Raises:
            NotFiniteError: NaN or infinity in the reading or the joints; `samples` stays as it was.
            NotAtRestError: a joint is faster than REST_SPEED_RAD_S.
        """
        raise NotImplementedError


def offset_of(samples: OffsetSamples) -> Vector:
    """The sensor's offset (6,): mean of the samples.

    Raises:
        DforcError: fewer samples than wanted.
    """
    raise NotImplementedError
