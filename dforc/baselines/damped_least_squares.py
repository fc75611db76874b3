"""Damped least squares with gradient projection: the classical Cartesian controller.

A baseline to compare the Cartesian controller with, as it ran for the experiments of 2010 (numbers
of pattacini/iros2010, kdlCtrl, which takes the inverse from KDL):

    dq = J' (J J' + d^2)^-1 e + (I - J' (J J' + d^2)^-1 J) (-K w(q))

e is the error of the hand (m and rad side by side, gain 1/s). The damping d shrinks while the
error falls and grows while it rises; w pulls joints out of the outer tenth of their ranges as far
as the hand's task leaves room. It knows the joints' ranges, where it stops a joint, and no rows.

Lengths in m, angles in rad, base frame, joint vectors (n,); task vectors (6,) linear part first.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.kinematics import HandKinematics
from dforc.limits import JointLimits
from dforc.rotation import rotation_error

FIRST_DISTANCE = 1.0  # the error that the first one is compared with
NO_RANGE_RAD = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class DampedParams:
    """The numbers of kdlCtrl."""

    period_s: float = 0.01
    smallest_damping: float = 1e-5
    largest_damping: float = 10.0  # also the first
    shrink: float = 0.9
    grow: float = 1.1
    singular_value: float = 1e-4  # below it the damping is the largest
    posture_gain: float = 1.0  # K
    safe_share: float = 0.9  # of each range, in its middle, where w is zero


@dataclass(frozen=True, slots=True, eq=False)
class DampedState:
    """What one period hands to the next; `q_ref_rad` and `dq_ref_rad_s` are for the joints."""

    q_ref_rad: Vector  # (n,)
    dq_ref_rad_s: Vector
    damping: float
    distance: float  # norm of the error the damping was last adapted to


class DampedLeastSquares:
    """The constants of one limb."""

    def __init__(
        self, model: HandKinematics, limits: JointLimits, params: DampedParams | None = None
    ) -> None:
        self._model = model
        self._params = params or DampedParams()
        self._lower, self._upper = limits.lower_rad, limits.upper_rad
        self._range = self._upper - self._lower
        guarded = 0.5 * (1.0 - self._params.safe_share) * self._range
        self._safe_lower, self._safe_upper = self._lower + guarded, self._upper - guarded
        self._free = (self._range > NO_RANGE_RAD).astype(np.float64)

    def start(self, q_rad: ArrayLike) -> DampedState:
        """At rest, with the largest damping."""
        n = self._model.n
        q: Vector = np.clip(finite_vector("start", q_rad, n), self._lower, self._upper)
        return DampedState(q, np.zeros(n), self._params.largest_damping, FIRST_DISTANCE)

    def step(self, state: DampedState, position_m: ArrayLike, rotation: Matrix) -> DampedState:
        """One period towards a pose.

        Raises:
            NotFiniteError: NaN or infinity in the target.
        """
        position = finite_vector("target position", position_m, 3)
        q, h = state.q_ref_rad, self._params.period_s
        R, p = self._model.tip_pose(q)
        error = np.concatenate([position - p, rotation_error(R, rotation)])
        J = self._model.tip_jacobian(q) * self._free
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        inverse = (Vt.T * (s / (s * s + state.damping**2))) @ U.T
        away = self._free * (-self._params.posture_gain * self._crowding(q))
        dq = inverse @ error + away - inverse @ (J @ away)
        wanted = q + h * dq
        dq = np.where((wanted < self._lower) | (wanted > self._upper), 0.0, dq)
        damping, distance = self._adapted(state, float(s[-1]), float(np.linalg.norm(error)))
        return DampedState(q + h * dq, dq, damping, distance)

    def _crowding(self, q: Vector) -> Vector:
        """Gradient (n,) w of the squared share of its range that a joint is outside its middle."""
        outside = np.minimum(q - self._safe_lower, 0.0) + np.maximum(q - self._safe_upper, 0.0)
        crowding: Vector = 2.0 * outside / np.maximum(self._range, NO_RANGE_RAD) ** 2
        return crowding

    def _adapted(self, state: DampedState, smallest: float, distance: float) -> tuple[float, float]:
        """The damping of the next period and the distance it belongs to."""
        params = self._params
        if smallest <= params.singular_value:
            return params.largest_damping, FIRST_DISTANCE
        factor = params.grow if distance > state.distance else params.shrink
        bounded = max(state.damping * factor, params.smallest_damping)
        return min(bounded, params.largest_damping), distance
