"""One period of the plan: what its generators want, and the joint speeds that serve them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.cartesian.aim import Aim, Mode
from dforc.cartesian.coupling import Coupling
from dforc.cartesian.min_jerk import run_cubic, run_lag, run_quintic
from dforc.cartesian.params import CartesianParams, Law
from dforc.cartesian.rotation_kernel import pose_errors
from dforc.cartesian.state import CartesianState, Generators, Outside, Poses, TipKinematics
from dforc.cartesian.targets import JUMP_M
from dforc.limits import JointLimits

RETURN_S = 1.0  # in which a plan that began outside its limits comes back in
SPEED_ERROR_PERIODS = 3.0  # in which speed mode makes up for what the tips lost
# While limits hold a tip back it asks for no more speed than this adds in a period: a pose out of
# reach is leant against, not hammered at.
STIFF = 1e4  # weight of the joints' own speeds meanwhile
LEANING = np.array([10.0] * 3 + [30.0] * 3)  # m/s^2, rad/s^2
OUTSIDE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class PlanStep:
    """The plan one period later."""

    q: Vector
    dq: Vector  # (n,), mean speed of the period
    generators: Generators
    aim: Aim
    limited: bool


class Planner:
    """What moves a plan; all that changes is in the state handed in."""

    def __init__(
        self,
        tips: Sequence[TipKinematics],
        limits: JointLimits,
        params: CartesianParams,
        free: Sequence[bool],
    ) -> None:
        """Keep everything; the caller has checked it."""
        self._tips = tips
        self._limits = limits
        self._params = params
        self._free = np.array(free, dtype=np.float64)
        self._is_free = np.array(free, dtype=np.bool_)
        self._lower, self._upper = np.array(limits.lower), np.array(limits.upper)
        self.coupling = Coupling(limits, params.coupling)

    def moved(self, state: CartesianState, aim: Aim, poses: Poses) -> PlanStep:
        """One period of the plan towards `aim`; `poses` are those of the plan now."""
        if self._params.law is Law.REFERENCE and aim.mode is Mode.REACH:
            return self._by_reference(state, aim, poses)
        h, q = self._params.period_s, state.q_plan
        generators = state.generators.copy()
        J = self._jacobians(q + 0.5 * h * state.dq_plan)
        v_joint = self._joint_speeds(generators, aim, q)
        v_task, aim = self._task_speeds(generators, aim, poses)
        asked = self._eased(state, v_task) if state.limited else v_task
        stiff = STIFF if state.limited and self._leans(aim, poses) else 1.0
        dq, limited = self._coupled(state, J, v_joint, asked, aim, stiff)
        if limited:  # what limits took from the task's speed leaves its generator, or it winds up
            moved = (J @ dq).reshape(v_task.shape)
            generators.task_velocity[:] += (moved - v_task) * aim.active
        return PlanStep(q + h * dq, dq, generators, aim, limited)

    def begun_anew(self, state: CartesianState) -> CartesianState:
        """The same motion with generators that begin at its speed and acceleration."""
        h, q, a = self._params.period_s, state.q_plan, state.ddq_plan
        v = state.dq_plan + 0.5 * h * a
        if not v.any() and not a.any():
            generators = Generators.at_rest(len(q), len(self._tips))
        else:
            J, beyond = self._jacobians(q), self._jacobians(q + h * v)
            shape = (len(self._tips), 6)
            generators = Generators(
                joint_velocity=v,
                joint_acceleration=a.copy(),
                task_velocity=(J @ v).reshape(shape),
                task_acceleration=((beyond - J) @ v / h + J @ a).reshape(shape),
                task_error=np.zeros(shape),
            )
        return replace(state, generators=generators)

    def outside(self, q: Vector) -> Outside:
        """How far a posture is outside the limits."""
        values = self._limits.C @ q
        distance = np.maximum(np.maximum(self._lower - values, values - self._upper), 0.0)
        return Outside(np.where(distance > OUTSIDE, distance, 0.0), 0.0)

    def bounds(self, outside: Outside) -> tuple[Vector, Vector]:
        """Limits and rows (m,) that the plan has to keep at the end of this period."""
        s = (outside.elapsed_s + self._params.period_s) / RETURN_S
        if s >= 1.0 or not outside.distance.any():
            return self._lower, self._upper
        left = (1.0 - s * s * s * (10.0 - s * (15.0 - 6.0 * s))) * outside.distance
        return self._lower - left, self._upper + left

    def _leans(self, aim: Aim, poses: Poses) -> bool:
        """Whether the time is over and a tip is not there."""
        if aim.mode is not Mode.REACH or aim.task_time_s > self._params.following_time_s:
            return False
        away = (poses.position - aim.position) * aim.active[:, :3]
        return float(np.abs(away).max()) > JUMP_M

    def _eased(self, state: CartesianState, v_task: Matrix) -> Matrix:
        now = state.generators.task_velocity
        more = LEANING * self._params.period_s
        eased: Matrix = np.minimum(np.maximum(v_task, now - more), now + more)
        return eased

    def _coupled(
        self,
        state: CartesianState,
        J: Matrix,
        v_joint: Vector,
        v_task: Matrix,
        aim: Aim,
        stiffness: float,
    ) -> tuple[Vector, bool]:
        return self.coupling.speeds(
            state.q_plan,
            J,
            v_joint,
            state.dq_plan,
            v_task,
            aim.active,
            self._free,
            stiffness,
            self.bounds(state.outside),
            self._params.period_s,
        )

    def _by_reference(self, state: CartesianState, aim: Aim, poses: Poses) -> PlanStep:
        """As the iCub's own controller does it, but never across limits and rows, nor too fast.

        DELIBERATE: iKin stops a joint at its own limits only, and a large gamma then crosses the
        rows of the shoulder by up to 9 degrees; here the plan is brought back inside. Nor has it
        speed limits: 22 rad/s with T 0.1 s. Here T stretches, and what is left is cut.
        """
        h, q = self._params.period_s, state.q_plan
        T = max(self._params.trajectory_time_s, aim.duration_s)
        generators = state.generators.copy()
        v_brake = self._braked(generators, aim)
        J = self._jacobians(q)
        before, v_task = state.generators, generators.task_velocity
        # What both filters see at the end of the period is guessed from the plan's motion: without
        # it the loop lags by a period, and with T 1 s is at 98 % after 1.35 T.
        ahead = h * (state.dq_plan + h * state.ddq_plan)
        error = self._task_errors(generators, aim, poses)
        generators.task_error[:] = error
        then = error + (J @ ahead).reshape(error.shape) - h * aim.velocity
        beside = np.where(self._is_free, aim.q - q, 0.0)
        lagged, pushed = before.joint_velocity.copy(), before.joint_acceleration.copy()
        run_lag(lagged, pushed, beside, beside - ahead * self._free, T, h)
        generators.joint_velocity[:] = np.where(self._is_free, lagged, generators.joint_velocity)
        generators.joint_acceleration[:] = np.where(
            self._is_free, pushed, generators.joint_acceleration
        )
        task_acceleration = generators.task_acceleration.ravel()
        run_lag(v_task.ravel(), task_acceleration, -error.ravel(), -then.ravel(), T, h)
        # Speeds are integrated by the trapezoidal rule, as iKin's integrator does it.
        v_joint = np.where(self._is_free, 0.5 * (before.joint_velocity + lagged), v_brake)
        v_mean = 0.5 * (before.task_velocity + v_task)
        dq = self.coupling.reference_speeds(q, J, v_joint, v_mean, aim.active, self._free)
        wanted = q + h * dq
        inside = self._inside(wanted, state.outside)
        fastest = float(np.max(np.abs(inside - q) / (h * self.coupling.speed_limit), initial=1.0))
        if fastest > 1.0:  # on the way between two postures inside; the filters slow down as well
            inside = q + (inside - q) / fastest
            generators.joint_velocity[:] /= fastest
            generators.task_velocity[:] /= fastest
        return PlanStep(inside, (inside - q) / h, generators, aim, bool((inside != wanted).any()))

    def _inside(self, q: Vector, outside: Outside) -> Vector:
        if outside.distance.any() and outside.elapsed_s < RETURN_S:
            lower, upper = self.bounds(outside)
            n = self._limits.n
            rows = self._limits.rows
            return JointLimits.make(lower[:n], upper[:n], rows, lower[n:], upper[n:]).project(q)
        return self._limits.project(q)

    def _jacobians(self, q: Vector) -> Matrix:
        J = np.empty((6 * len(self._tips), len(q)))
        for i, tip in enumerate(self._tips):
            J[6 * i : 6 * i + 6] = tip.jacobian(q)
        return J

    def _task_errors(self, generators: Generators, aim: Aim, poses: Poses) -> Matrix:
        error = np.empty_like(generators.task_error)
        pose_errors(
            poses.position,
            poses.rotation,
            aim.position,
            aim.rotation,
            generators.task_error,
            error,
        )
        return error

    def _task_speeds(self, generators: Generators, aim: Aim, poses: Poses) -> tuple[Matrix, Aim]:
        """What the tips are to do (k, 6); runs the task generator on."""
        h = self._params.period_s
        if not aim.active.any():
            return np.zeros_like(aim.velocity), aim
        error = self._task_errors(generators, aim, poses)
        generators.task_error[:] = error
        velocity, acceleration = generators.task_velocity, generators.task_acceleration
        if aim.mode is not Mode.REACH:
            way = np.empty_like(error)
            run_cubic(
                way.ravel(),
                velocity.ravel(),
                acceleration.ravel(),
                aim.velocity.ravel(),
                max(aim.task_time_s, h),
                h,
            )
            return (way - error / SPEED_ERROR_PERIODS) / h, aim.moved_on(way)
        away = error.copy()
        velocity -= aim.velocity
        run_quintic(away.ravel(), velocity.ravel(), acceleration.ravel(), aim.task_time_s, h)
        velocity += aim.velocity
        return (away - error) / h + aim.velocity, aim

    def _joint_speeds(self, generators: Generators, aim: Aim, q: Vector) -> Vector:
        """What the joints are to do (n,); runs the joint generator on."""
        h = self._params.period_s
        if aim.mode is not Mode.REACH:
            return self._braked(generators, aim)
        beside = q - aim.q
        away = beside.copy()
        velocity, acceleration = generators.joint_velocity, generators.joint_acceleration
        if self._is_free.all():
            run_quintic(away, velocity, acceleration, aim.joint_time_s, h)
            return (away - beside) / h
        drawn, pushed = velocity.copy(), acceleration.copy()
        run_quintic(away, drawn, pushed, aim.joint_time_s, h)
        v_brake = self._braked(generators, aim)
        velocity[:] = np.where(self._is_free, drawn, velocity)
        acceleration[:] = np.where(self._is_free, pushed, acceleration)
        return np.where(self._is_free, (away - beside) / h, v_brake)

    def _braked(self, generators: Generators, aim: Aim) -> Vector:
        """Speeds of joints that come to rest (n,)."""
        h, way = self._params.period_s, np.empty_like(generators.joint_velocity)
        velocity, acceleration = generators.joint_velocity, generators.joint_acceleration
        brake_s = max(aim.brake_time_s, h)
        run_cubic(way, velocity, acceleration, np.zeros_like(way), brake_s, h)
        return way / h
