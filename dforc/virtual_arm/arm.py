"""The virtual arm: a posture that goes to a goal of its hands and touches nothing on the way.

It does for the whole arm what the force field of DForC does for a point. Far from everything the
hand obeys eq. 3, with a limit on its speed; the joints that carry it there are chosen by a
quadratic program that keeps limits, rows, and all surfaces of the arm from obstacles, from the
rest of the body and from the other arm, whatever the hand wants (velocity damper, Faverjon and
Tournassoud 1987). Where that comes to rest before the goal a path is planned around the trap. The
hand's orientation obeys eq. 3 on SO(3), by the rotation vector, and gives way to its position.
"""

import math
from collections.abc import Sequence

import numpy as np

from dforc.arrays import ArrayLike, Vector, constant, finite_vector
from dforc.collision.body import Body
from dforc.collision.obstacles import World
from dforc.errors import NotFiniteError, ShapeError
from dforc.limits import JointLimits
from dforc.rotation import angle_between, rotation_error
from dforc.virtual_arm.goals import ArmOutput, ArmState, TipGoal
from dforc.virtual_arm.kernel_arm import hand_speed
from dforc.virtual_arm.motion import ArmMotion
from dforc.virtual_arm.params import ArmParams
from dforc.virtual_arm.pursuit import Gait, Pursuit
from dforc.virtual_arm.situation import Situation

POSITION_WEIGHT, TURN_WEIGHT = 1e5, 1.0  # (m/s)^-2, (rad/s)^-2: the position is the condition
POSTURE_WEIGHT = 0.02
POSTURE_PULL_1_S = 2.0
LEANING_SHARE = 0.5  # of the joints' speeds
TURN_PROGRESS_M = 0.1  # what a radian counts beside metres
NEAR_M = 0.02  # of the goal the posture's pull fades, so that it moves no hand off it
LEAST_PULL = 0.05


class VirtualArm:
    """One limb, or two over one waist."""

    def __init__(
        self,
        body: Body,
        joints: tuple[str, ...],
        limits: JointLimits,
        speed_limits_rad_s: ArrayLike,
        tips: tuple[int, ...],
        rest_rad: ArrayLike,
        params: ArmParams | None = None,
        seed: int = 0,
    ) -> None:
        """An arm at its rest posture.

        Args:
            body: all of the robot that is near: what the arm must not touch, too.
            joints: of the limb (n), in the order of its vectors; all of them joints of the body.
            limits: of the limb.
            speed_limits_rad_s: of its joints (n,).
            tips: indices of its hands among the body's.
            rest_rad: posture that it leans to (n,).
            params: constants.
            seed: of the searches.
        """
        self.params = params or ArmParams()
        self._motion = ArmMotion(body, joints, limits, speed_limits_rad_s, tips, self.params)
        self._rest = constant(finite_vector("rest posture", rest_rad, limits.n))
        motion = self._motion
        self._pursuit = Pursuit(
            body, motion.columns, limits, tips, self._rest, motion.speeds, self.params, seed
        )
        self.begin(limits.project(self._rest))

    @property
    def q_rad(self) -> Vector:
        """Posture (n,)."""
        return self._motion.q.copy()

    def begin(self, q_rad: ArrayLike, dq_rad_s: ArrayLike | None = None) -> None:
        """Be at a posture (n,), at rest or with these speeds (n,); the goal is forgotten.

        Raises:
            NotFiniteError, ShapeError: it is none.
        """
        motion = self._motion
        q = finite_vector("posture", q_rad, motion.n)
        dq = np.zeros(motion.n)
        if dq_rad_s is not None:
            dq = finite_vector("speeds", dq_rad_s, motion.n)
        motion.begin(q, dq)
        self._pursuit.drop()

    def new_goal(self) -> None:
        """The goals of the next step are others, however near those before they are."""
        self._pursuit.new_goal()

    def change(self, params: ArmParams) -> None:
        """Other constants from the next step on; the arm moves on as it did."""
        motion = self._motion
        motion.change(params)
        self._pursuit.change(params, motion.speeds)
        self.params = params

    def step(
        self,
        goals: Sequence[TipGoal | None] | None,
        world: World,
        others_q: Vector,
        others_dq: Vector,
        dt_s: float,
        lag_m: float = 0.0,
    ) -> ArmOutput:
        """Move by one period.

        Args:
            goals: one for each hand, None for one that is free; None altogether: stand.
            world: obstacles, as they are now.
            others_q: all joints of the body (N,); the limb's own are not looked at.
            others_dq: their speeds (N,).
            dt_s: period.
            lag_m: how far the real hand is behind; the virtual one waits for it.

        Raises:
            NotFiniteError, ShapeError: what is no number or has another shape; nothing has moved.
        """
        if not all(np.isfinite(values).all() for values in world):
            raise NotFiniteError("an obstacle is not finite")
        for goal in goals or ():
            if goal is not None and not goal.is_finite:
                raise NotFiniteError(f"a goal at {goal.position_m}, {goal.velocity_m_s} m/s")
        N = len(self._motion.body.joints)
        others_q = finite_vector("joints of the body", others_q, N)
        others_dq = finite_vector("their speeds", others_dq, N)
        if not (math.isfinite(dt_s) and dt_s > 0.0 and math.isfinite(lag_m)):
            raise NotFiniteError(f"a period of {dt_s} s, a lag of {lag_m} m")
        if goals is not None and len(goals) != len(self._motion.tips):
            raise ShapeError(f"{len(goals)} goals for {len(self._motion.tips)} hands")
        asked = None if goals is None or all(goal is None for goal in goals) else tuple(goals)
        motion, pursuit = self._motion, self._pursuit
        motion.look(world, others_q, others_dq, pursuit.margin_m, dt_s)
        errors = self._errors(asked)
        if asked is None:
            if pursuit.state is not ArmState.IDLE:
                pursuit.drop()
        else:
            known = [error for error in errors if error is not None]
            now = Situation(asked, motion.q, world, others_q, motion.left_m)
            pursuit.advance(now, known, dt_s)
        held, missed = self._move(asked, world, self._share(lag_m), dt_s)
        return self._output(errors, held, missed, lag_m)

    def _errors(self, goals: tuple[TipGoal | None, ...] | None) -> list[tuple[float, float] | None]:
        """Of each hand (m, rad), before the step."""
        errors: list[tuple[float, float] | None] = []
        for at, goal in enumerate(goals or ()):
            if goal is None:
                errors.append(None)
                continue
            R, p = self._motion.pose(at)
            off_rad = 0.0 if goal.rotation is None else angle_between(R, goal.rotation)
            errors.append((float(np.linalg.norm(goal.position_m - p)), off_rad))
        return errors

    def _share(self, lag_m: float) -> float:
        """Of its speed: less where the real hand is left behind."""
        params = self.params
        room = params.lag_stop_m - params.lag_slow_m
        return min(1.0, max(0.0, (params.lag_stop_m - lag_m) / room))

    def _move(
        self, goals: tuple[TipGoal | None, ...] | None, world: World, share: float, dt_s: float
    ) -> tuple[bool, bool]:
        motion, pursuit, params = self._motion, self._pursuit, self.params
        rows = 6 * len(motion.tips)
        v, weights = np.zeros(rows), np.zeros(rows)
        gain = min(1.0, dt_s * params.damping_ns_m)
        if pursuit.gait is Gait.REACH and goals is not None:
            nearest_m = self._hands(goals, share, dt_s, v, weights)
            wanted, posture = self._leaning(nearest_m, share, gain)
            before = motion.velocity
        else:
            wanted = np.zeros(motion.n)
            if pursuit.way is not None:
                wanted = pursuit.way.wanted(motion.q, share, dt_s)
            target = wanted
            wanted = motion.dq + gain * (wanted - motion.dq)
            posture = np.ones(motion.n)
        held, missed = motion.step(v, weights, wanted, posture, world, dt_s)
        if pursuit.gait is Gait.REACH and goals is not None:
            scale = np.where(weights == TURN_WEIGHT, TURN_PROGRESS_M, 1.0) * (weights > 0.0)
            nominal = scale * (before + (v - before) / gain)
            done = scale * motion.velocity
            pursuit.progress.note(float(done @ nominal), float(nominal @ nominal), dt_s)
        elif pursuit.way is not None:
            pursuit.progress.note(float(motion.dq @ target), float(target @ target), dt_s)
        return held, missed

    def _hands(
        self,
        goals: tuple[TipGoal | None, ...],
        share: float,
        dt_s: float,
        v: Vector,
        weights: Vector,
    ) -> float:
        """Fill what the hands want; distance [m] of the farthest from its goal."""
        motion, params = self._motion, self.params
        before = motion.velocity
        K, D = params.stiffness_n_m, params.damping_ns_m
        still = np.zeros(3)
        farthest = 0.0
        for at, goal in enumerate(goals):
            if goal is None:
                continue
            R, p = motion.pose(at)
            to_go = goal.position_m - p
            distance = float(np.linalg.norm(to_go))
            farthest = max(farthest, distance)
            linear, turning = slice(6 * at, 6 * at + 3), slice(6 * at + 3, 6 * at + 6)
            hand_speed(
                to_go, before[linear], goal.velocity_m_s, K, D, params.speed_m_s, share, dt_s,
                v[linear],
            )  # fmt: skip
            weights[linear] = POSITION_WEIGHT
            if goal.rotation is not None:
                gate = min(1.0, params.turn_gate_m / max(distance, 1e-9))
                turn = rotation_error(R, goal.rotation)
                fastest = gate * params.turn_rad_s
                hand_speed(turn, before[turning], still, K, D, fastest, share, dt_s, v[turning])
                weights[turning] = TURN_WEIGHT
        return farthest

    def _leaning(self, distance_m: float, share: float, gain: float) -> tuple[Vector, Vector]:
        """Joint speeds that the posture wants, and their weights."""
        motion, posture = self._motion, self._pursuit.posture
        lean = self._rest if posture is None else posture
        limit = LEANING_SHARE * motion.speeds
        pull = share * np.clip(POSTURE_PULL_1_S * (lean - motion.q), -limit, limit)
        wanted: Vector = motion.dq + gain * (pull - motion.dq)
        near = 1.0 if posture is not None else min(1.0, max(LEAST_PULL, distance_m / NEAR_M))
        return wanted, np.full(motion.n, near * POSTURE_WEIGHT)

    def _output(
        self,
        errors: list[tuple[float, float] | None],
        held: bool,
        missed: bool,
        lag_m: float,
    ) -> ArmOutput:
        motion, pursuit = self._motion, self._pursuit
        known = [error for error in errors if error is not None]
        state, reason = pursuit.state, pursuit.reason
        if state is ArmState.REACHING and lag_m >= self.params.lag_stop_m:
            state, reason = ArmState.WAITING, f"the hand is {1e3 * lag_m:.0f} mm behind"
        nearest, clearance_m, obstacle = ("", ""), math.inf, -1
        if motion.nearest >= 0:
            k = motion.nearest
            capsule, other = (int(i) for i in motion.which[k])
            names = motion.body.capsules
            clearance_m = float(motion.distances[k])
            obstacle = max(other, -1)
            nearest = (names[capsule], "an obstacle" if other >= 0 else names[-1 - other])
        if clearance_m < 0.0:
            state = ArmState.WAITING if state is ArmState.ARRIVED else state
            reason = f"{nearest[0]} is {-1e3 * clearance_m:.0f} mm inside {nearest[1]}"
        way = pursuit.way
        return ArmOutput(
            q_rad=constant(motion.q),
            dq_rad_s=constant(motion.dq),
            tips=motion.tip_motions(),
            state=state,
            reason=reason,
            clearance_m=clearance_m,
            nearest=nearest,
            nearest_obstacle=obstacle,
            margin_m=pursuit.margin_m,
            position_error_m=max((error[0] for error in known), default=0.0),
            orientation_error_rad=max((error[1] for error in known), default=0.0),
            way_to_go_rad=0.0 if way is None else way.left_rad(motion.q),
            iterations=pursuit.iterations,
            nodes=pursuit.nodes,
            held=held,
            yielding=missed,
        )
