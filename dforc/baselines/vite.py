"""VITE in joint and in task space at once: the multi-referential reaching of Hersch and Billard.

A baseline to compare the Cartesian controller with, as it ran on the iCub for the experiments of
2010 (gains of pattacini/iros2010, viteCtrl). In both spaces the speed follows a share of the way
that is left:

    v <- v + alpha h (beta (target - x) - v),   x <- x + h v

which with alpha = 4 beta is a critically damped approach at w = sqrt(alpha beta): 98 % after
5.83 / w, fastest after 1 / w. The joints' wish and the hand's are made one by Lagrange multipliers,

    dq = v_q + W J' (J W J' + V)^-1 (v_x - J v_q),

W large in the middle of a joint's range and zero at its ends. It knows the joints' ranges, and no
rows. On the robot a proportional velocity loop with a speed limit followed the plan.

Lengths in m, angles in rad, base frame, joint vectors (n,); task vectors (6,) linear part first.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.kinematics import HandKinematics
from dforc.limits import JointLimits
from dforc.rotation import rotation_error

MS_PER_S = 1e3
LEVER_POSTURES = 50  # drawn to find how far a joint moves the hand
SHORTEST_LEVER_M = 0.05
JOINT_SHARE = 0.1  # of W, against the inverse of the levers in mm
# V of the original is 1 for a hand in mm and for the vector sin(angle / 2) axis.
POSITION_WEIGHT = 1e-6
ROTATION_WEIGHT = 4.0
NO_RANGE_RAD = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class VelocityLoop:
    """What followed the plan on the robot: dq = Kp (plan - q), limited."""

    gain_per_s: float = 3.0
    speed_limit_rad_s: float = float(np.radians(30.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class ViteParams:
    """The gains of viteCtrl. `loop` None: the plan itself is the reference."""

    alpha_per_ms: float = 0.008
    beta_per_ms: float = 0.002
    period_s: float = 0.01
    loop: VelocityLoop | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ViteState:
    """What one period hands to the next; `q_ref_rad` and `dq_ref_rad_s` are for the joints."""

    q_plan: Vector  # (n,)
    joint_velocity: Vector  # (n,)
    task_velocity: Vector  # (6,)
    q_ref_rad: Vector
    dq_ref_rad_s: Vector


class Vite:
    """The constants of one limb."""

    def __init__(
        self, model: HandKinematics, limits: JointLimits, params: ViteParams | None = None
    ) -> None:
        self._model = model
        self._limits = limits
        self._params = params or ViteParams()
        self._range = limits.upper_rad - limits.lower_rad
        self._largest_weights = constant(JOINT_SHARE / (MS_PER_S * self._levers_m()))
        self._V = np.diag([POSITION_WEIGHT] * 3 + [ROTATION_WEIGHT] * 3)

    def start(self, q_rad: ArrayLike) -> ViteState:
        """At rest."""
        n = self._model.n
        q = self._clipped(finite_vector("start", q_rad, n))
        return ViteState(q, np.zeros(n), np.zeros(6), q, np.zeros(n))

    def step(
        self, state: ViteState, position_m: ArrayLike, rotation: Matrix, q_target_rad: ArrayLike
    ) -> ViteState:
        """One period towards a pose and the posture that reaches it.

        Raises:
            NotFiniteError: NaN or infinity in the target.
        """
        target = finite_vector("target posture", q_target_rad, self._model.n)
        position = finite_vector("target position", position_m, 3)
        h, q = self._params.period_s, state.q_plan
        R, p = self._model.tip_pose(q)
        v_joint = self._speed(state.joint_velocity, target - q)
        v_joint = (self._clipped(q + h * v_joint) - q) / h
        left = np.concatenate([position - p, rotation_error(R, rotation)])
        v_task = self._speed(state.task_velocity, left)
        J = self._model.tip_jacobian(q)
        JW = J * self._weights(q)
        dq = v_joint + JW.T @ np.linalg.solve(JW @ J.T + self._V, v_task - J @ v_joint)
        q_new = self._clipped(q + h * dq)
        R_new, p_new = self._model.tip_pose(q_new)
        moved = np.concatenate([p_new - p, rotation_error(R, R_new)]) / h
        dq_plan = (q_new - q) / h
        q_ref, dq_ref = self._followed(state.q_ref_rad, q_new, dq_plan)
        return ViteState(q_new, dq_plan, moved, q_ref, dq_ref)

    def _speed(self, velocity: Vector, left: Vector) -> Vector:
        """The next speed (per s); both gains are per ms."""
        gains = self._params
        share = gains.alpha_per_ms * MS_PER_S * gains.period_s
        after: Vector = velocity + share * (gains.beta_per_ms * MS_PER_S * left - velocity)
        return after

    def _followed(self, q_ref: Vector, q_plan: Vector, dq_plan: Vector) -> tuple[Vector, Vector]:
        loop = self._params.loop
        if loop is None:
            return q_plan, dq_plan
        limit = loop.speed_limit_rad_s
        dq: Vector = np.clip(loop.gain_per_s * (q_plan - q_ref), -limit, limit)
        return self._clipped(q_ref + self._params.period_s * dq), dq

    def _weights(self, q: Vector) -> Vector:
        """W (n,): a raised cosine over each joint's range."""
        usable = np.maximum(self._range, NO_RANGE_RAD)
        turn = 2.0 * np.pi * (q - self._limits.lower_rad) / usable
        weights: Vector = 0.5 * (1.0 - np.cos(turn)) * self._largest_weights
        return np.where(self._range > NO_RANGE_RAD, weights, 0.0)

    def _levers_m(self) -> Vector:
        """How far a radian of each joint moves the hand, on average over its range (n,)."""
        draw = np.random.default_rng(0)
        levers = np.zeros(self._model.n)
        for _ in range(LEVER_POSTURES):
            q = draw.uniform(self._limits.lower_rad, self._limits.upper_rad)
            levers += np.linalg.norm(self._model.tip_jacobian(q)[:3], axis=0)
        return np.maximum(levers / LEVER_POSTURES, SHORTEST_LEVER_M)

    def _clipped(self, q: Vector) -> Vector:
        clipped: Vector = np.clip(q, self._limits.lower_rad, self._limits.upper_rad)
        return clipped
