"""Joint torques and the contact wrench of a limb from its force-torque sensor.

The wrench w that the limb beyond the sensor exerts on the near side is measured; its part w_i due
to the limb's own weight and motion comes from the Newton-Euler pass (force control paper, eqs. 8
to 10). The rest is what the world exerts on the limb, here assumed to act at the hand (eq. 2):

    f = R_s (w - w_offset - w_i)_force,  m = R_s (...)_moment + (p_s - p_hand) x f
    tau = RNEA(q, dq, 0) - J_hand' (f, m)

tau is the torque that the drives exert on the joints, gravity and motion included: a drive has to
hold what gravity asks and give back what the world already contributes, hence the minus. (The
papers write the torque of the external wrench itself, eq. 3, with the opposite reading of
"exerts".) The joint accelerations are left at zero: what they add beyond the sensor is measured
and ends up in the wrench at the hand. A push between base and sensor is invisible to the estimate.

Wrenches are (6,): force [N], then moment [Nm].
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import DforcError

REST_SPEED_RAD_S = 0.02  # encoders of 4096 ticks per turn count 0.015 rad/s at 10 ms


class NotAtRestError(DforcError):
    """A calibration sample was taken while the limb moved."""


class TooFewSamplesError(DforcError):
    """The offset was asked for before enough samples were in."""


class LimbModel(Protocol):
    """What the estimate asks of dforc.robot_model.RobotModel."""

    n: int

    def inverse_dynamics(
        self, q_rad: Vector, dq_rad_s: Vector, ddq_rad_s2: Vector
    ) -> tuple[Vector, dict[str, Vector]]:
        """Joint torques (n,) and each sensor's wrench (6,) in its own frame."""
        ...

    def sensor_to_tip(self, q_rad: Vector, name: str) -> tuple[Matrix, Vector, Matrix]:
        """Sensor's rotation in the base, vector from tip to sensor, Jacobian of the tip."""
        ...

    def gravity(self, q_rad: Vector) -> Vector:
        """Gravity torques (n,)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What the drives exert, and what the world exerts on the hand."""

    tau_nm: Vector  # (n,), the order of the model's joints
    force_n: Vector  # (3,), on the hand, base frame
    moment_nm: Vector  # (3,), on the hand about the tip frame's origin, base axes


@dataclass(frozen=True, slots=True)
class OffsetSamples:
    """Sums over (measured - predicted) wrenches, taken at rest and without contact."""

    wanted: int
    count: int = 0
    sums: tuple[float, ...] = (0.0,) * 6
    squares: tuple[float, ...] = (0.0,) * 6

    @property
    def complete(self) -> bool:
        """Enough samples are in."""
        return self.count >= self.wanted


class TorqueEstimator:
    """Torque estimate of one limb: a pure function of its arguments, given model and sensor."""

    def __init__(self, model: LimbModel, sensor: str) -> None:
        """Keep the model.

        Args:
            model: rigid-body model with the sensor; this object alone may use it meanwhile.
            sensor: the sensor's name in the model.
        """
        self._model = model
        self._sensor = sensor
        self._still = constant(np.zeros(model.n))

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
        n = self._model.n
        given = (q_rad, dq_rad_s, wrench, offset)
        # One check for all four: this runs at 1 kHz.
        together = finite_vector("state, wrench, offset", np.concatenate(given), 2 * n + 12)
        q, dq, measured = together[:n], together[n : 2 * n], together[-12:-6] - together[-6:]
        tau_nm, predicted = self._model.inverse_dynamics(q, dq, self._still)
        excess = measured - predicted[self._sensor]
        R, lever, J = self._model.sensor_to_tip(q, self._sensor)
        force, moment = R @ excess[:3], R @ excess[3:]
        moment = moment + _cross(lever, force)
        external = np.concatenate([force, moment])
        return Estimate(tau_nm - external @ J, force, moment)

    def gravity(self, q_rad: ArrayLike) -> Vector:
        """Gravity torques (n,) [Nm] of the model: the impedance offset of compliant axes."""
        return self._model.gravity(finite_vector("joint angles", q_rad, self._model.n))

    def add_sample(
        self, samples: OffsetSamples, q_rad: ArrayLike, dq_rad_s: ArrayLike, wrench: ArrayLike
    ) -> OffsetSamples:
        """`samples` with one more reading; raises rather than take in a bad one.

        Raises:
            NotFiniteError: NaN or infinity in the reading or the joints.
            NotAtRestError: a joint is faster than REST_SPEED_RAD_S.
        """
        n = self._model.n
        q = finite_vector("joint angles", q_rad, n)
        dq = finite_vector("joint velocities", dq_rad_s, n)
        measured = finite_vector("sensor wrench", wrench, 6)
        fastest = float(np.abs(dq).max())
        if fastest > REST_SPEED_RAD_S:
            raise NotAtRestError(f"a joint moves at {fastest:.3f} rad/s; the limb must be at rest")
        _, predicted = self._model.inverse_dynamics(q, dq, self._still)
        excess = (measured - predicted[self._sensor]).tolist()
        return OffsetSamples(
            wanted=samples.wanted,
            count=samples.count + 1,
            sums=tuple(s + e for s, e in zip(samples.sums, excess, strict=True)),
            squares=tuple(s + e * e for s, e in zip(samples.squares, excess, strict=True)),
        )


def offset_of(samples: OffsetSamples) -> Vector:
    """The sensor's offset (6,): mean of the samples.

    Raises:
        TooFewSamplesError: fewer samples than wanted.
    """
    if not samples.complete or samples.count == 0:
        raise TooFewSamplesError(f"{samples.count} samples of {samples.wanted} wanted")
    return np.array(samples.sums) / samples.count


def spread_of(samples: OffsetSamples) -> Vector:
    """Standard deviation (6,) of the samples: far above the sensor's noise means it was touched."""
    count = max(samples.count, 1)
    mean = np.array(samples.sums) / count
    return np.sqrt(np.maximum(np.array(samples.squares) / count - mean * mean, 0.0))


def _cross(a: Vector, b: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
