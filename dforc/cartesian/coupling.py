"""Joint speeds that serve two minimum-jerk generators at once, one in joint and one in task space.

Reference law (DForC III-A, and the iCub's own controller):

    dq = v_q + W J' (I + J W J')^-1 (v_x - J v_q),   W = gamma diag(w_i(q))

is the minimum of |dq - v_q|^2 in the metric W^-1 plus |J dq - v_x|^2 (the Lagrange multipliers of
dx = J dq are eliminated). w_i takes a joint out of the task's share in the outer 2.5 % of its range
and brings it in over the next 2.5 %.

Time-to-go law: the same cost, but no joint fades out; ranges, rows and speed limits are
constraints of a quadratic program. Where they cost the tips some of their speed, it is taken first
from turning, then from the speed along the path, and from the path itself last.
"""

import math

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.cartesian.coupling_kernel import plan_speeds
from dforc.cartesian.params import CouplingParams, ParameterError
from dforc.limits import JointLimits

REFERENCE_GAMMA = 0.05  # iKin's
GAMMA = 2e4
# Across the path, along it, turning, each against gamma. Over 200 random moves these keep the
# path to 0.15 % of its length and the profile to 0.2 %, where all alike leave 12 and 14 %.
SHARES = (100.0, 50.0, 0.005)


class Coupling:
    """The constants of the coupling for one limb."""

    def __init__(self, limits: JointLimits, params: CouplingParams) -> None:
        """Keep limits and tuning. Raises ParameterError for a speed limit that is none."""
        n = limits.n
        self._params = params
        self._C = np.array(limits.C)
        self._sizes = np.sqrt((self._C * self._C).sum(axis=1))
        limit = np.asarray(params.speed_limit_rad_s, dtype=np.float64)
        if limit.shape not in ((), (n,)) or not (limit > 0.0).all():
            raise ParameterError(f"speed limits must be positive, one or {n}: {limit.tolist()}")
        self.speed_limit: Vector = np.array(np.broadcast_to(limit, (n,)))
        gamma = params.gamma or GAMMA
        self._weights = gamma * np.array(SHARES)
        self._guard = _Guard(limits, params)

    def speeds(
        self,
        q_rad: Vector,
        J: Matrix,
        v_joint: Vector,
        v_before: Vector,
        v_task: Matrix,
        active: Matrix,
        free: Vector,
        stiffness: float,
        bounds: tuple[Vector, Vector],
        period_s: float,
    ) -> tuple[Vector, bool]:
        """Time-to-go law: joint speeds (n,) inside all limits, and whether limits changed them.

        Args:
            q_rad: the plan's posture (n,).
            J: Jacobians of the tips in the middle of the period (6 k, n), linear rows first.
            v_joint: v_q (n,) [rad/s].
            v_before: joint speeds of the period before (n,).
            v_task: v_x (k, 6), linear [m/s] then angular [rad/s].
            active: (k, 6), 1 where v_x counts.
            free: (n,), 0 for a joint that moves by v_q whatever happens.
            stiffness: weight of the joints' own speeds, 1 but for a tip that cannot go on.
            bounds: lower and upper of C q (m,) at the period's end.
            period_s: how long the speeds will be applied.
        """
        dq = np.empty(len(q_rad))
        count = plan_speeds(
            J,
            v_task,
            active,
            self._weights,
            free,
            stiffness,
            v_joint,
            v_before,
            self._C,
            self._C @ q_rad,
            bounds[0],
            bounds[1],
            self._sizes,
            self.speed_limit,
            self._params.acceleration_limit_rad_s2,
            min(self._params.braking_rad_s2, 0.5 * self._params.acceleration_limit_rad_s2),
            period_s,
            dq,
        )
        return dq, count != 0

    def reference_speeds(
        self,
        q_rad: Vector,
        J: Matrix,
        v_joint: Vector,
        v_task: Matrix,
        active: Matrix,
        free: Vector,
    ) -> Vector:
        """Reference law: joint speeds (n,), without any limit. Arguments as in `speeds`."""
        W = (self._params.gamma or REFERENCE_GAMMA) * self.guard(q_rad) * free
        counts = active.ravel() != 0.0
        rows = J[counts]
        JW = rows * W
        miss = v_task.ravel()[counts] - rows @ v_joint
        multipliers = np.linalg.solve(np.eye(len(rows)) + JW @ rows.T, miss)
        dq: Vector = v_joint + JW.T @ multipliers
        return dq

    def guard(self, q_rad: Vector) -> Vector:
        """w_i (n,) of the reference law, 0 to 1."""
        return self._guard.weights(q_rad)


class _Guard:
    """iKin's weights near the ends of the joints' ranges."""

    def __init__(self, limits: JointLimits, params: CouplingParams) -> None:
        # A range without end counts as one turn.
        width = np.minimum(limits.upper_rad - limits.lower_rad, 2.0 * math.pi)
        self._closed = 0.25 * params.guard_ratio * width
        self._lower, self._upper = limits.lower_rad, limits.upper_rad

    def weights(self, q_rad: Vector) -> Vector:
        """1 inside, 0 in the outer quarter of the guarded share, and a tanh over the next."""
        inside = np.minimum(q_rad - self._lower, self._upper - q_rad)
        closed = np.maximum(self._closed, 1e-12)
        # iKin: 0.5 (tanh(alpha (q - middle)) + 1) with alpha = 10 over the width of the ramp
        ramp = 0.5 * (np.tanh(10.0 * (inside - 1.5 * closed) / closed) + 1.0)
        rounded = 1e-9 * closed
        shut, open_ = inside <= closed + rounded, inside >= 2.0 * closed - rounded
        faded: Vector = np.where(shut, 0.0, np.where(open_, 1.0, ramp))
        return faded
