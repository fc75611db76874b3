"""Joint speeds that serve two minimum-jerk generators at once, one in joint and one in task space.

    dq = v_q + W J' (I + J W J')^-1 (v_x - J v_q),   W = gamma diag(g_i(q))

is the minimum of |dq - v_q|^2 in the metric W^-1 plus |J dq - v_x|^2 (DForC III-A; the Lagrange
multipliers of dx = J dq are eliminated). gamma weighs the straight path of the hand against the
direct path of the joints; g_i fades a joint out of the task's share towards the ends of its range.
Where the result would leave the joint ranges or the rows, or exceed the speed limit, the same cost
is minimised under these as constraints.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.limits import JointLimits
from dforc.quadratic import minimise

CLOSED_JOINT = 1e-6  # W of a joint at its end in the constrained problem, as a share of gamma
KEPT = 1e-12  # rad/s
SMALLEST_GUARD_RAD = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingParams:
    """How the two generators share the joints."""

    gamma: float = 1e4  # iKin: 0.05, path bent by 13 % of its length; 1000: 0.7 % (ik reference)
    guard_ratio: float = 0.02  # share of the range at each end in which a joint fades out
    speed_limit_rad_s: float = 1.75  # of every joint
    braking_time_s: float = 0.1  # towards a limit the speed falls to the distance over this time


class Coupling:
    """The constants of the coupling for one limb."""

    def __init__(self, limits: JointLimits, params: CouplingParams) -> None:
        self._limits = limits
        self._params = params
        # A range without end counts as one turn; a joint without range is faded out for good.
        guarded = params.guard_ratio * np.minimum(limits.upper_rad - limits.lower_rad, 2.0 * np.pi)
        self._slope: Vector = 2.0 / np.maximum(guarded, SMALLEST_GUARD_RAD)

    def guard(self, q_rad: Vector) -> Vector:
        """g_i (n,): 1 inside, 0 in the outer half of the guarded share, a line between."""
        limits = self._limits
        inside = np.minimum(q_rad - limits.lower_rad, limits.upper_rad - q_rad)
        share = inside * self._slope - 1.0
        faded: Vector = np.minimum(np.maximum(share, 0.0), 1.0)
        return faded

    def speeds(
        self, q_rad: Vector, J: Matrix, v_joint: Vector, v_task: Vector, period_s: float
    ) -> tuple[Vector, bool]:
        """Joint speeds (n,) that keep all limits for a period, and whether limits changed them.

        Args:
            q_rad: the plan's posture (n,), inside limits and rows.
            J: Jacobian of the hand (6, n), linear rows first.
            v_joint: v_q (n,) [rad/s].
            v_task: v_x (6,), linear [m/s] then angular [rad/s].
            period_s: how long dq will be applied.
        """
        W = self._params.gamma * self.guard(q_rad)
        JW = J * W
        multipliers = np.linalg.solve(np.eye(6) + JW @ J.T, v_task - J @ v_joint)
        dq: Vector = v_joint + JW.T @ multipliers
        C = self._limits.C
        values = C @ q_rad
        speed = self._params.speed_limit_rad_s
        braking_s = max(period_s, self._params.braking_time_s)
        lower = (self._limits.lower - values) / braking_s
        upper = (self._limits.upper - values) / braking_s
        n = len(q_rad)
        lower[:n] = np.maximum(lower[:n], -speed)
        upper[:n] = np.minimum(upper[:n], speed)
        # Rounding may have left q a hair outside; then staying is allowed.
        lower, upper = np.minimum(lower, 0.0), np.maximum(upper, 0.0)
        moved = C @ dq
        if (moved >= lower - KEPT).all() and (moved <= upper + KEPT).all():
            return dq, False
        stiff = 1.0 / np.maximum(W, CLOSED_JOINT * self._params.gamma)
        H = J.T @ J
        H[np.diag_indices(n)] += stiff
        return minimise(H, -(stiff * v_joint + J.T @ v_task), C, lower, upper), True
