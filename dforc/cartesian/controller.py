"""Cartesian controller: minimum-jerk generators on an internal plan, and an outer correction.

Multi-referential scheme (DForC section III-A) for any number of joints and one tip or two: a
generator in joint space draws the plan to the posture q_d that inverse kinematics found, one in
task space draws each tip to its pose along a straight line and the shortest turn, and
dforc.cartesian.coupling joins their speeds. The plan runs open loop: the arm's lag cannot shake it.
Both generators work on the error against the target in motion, so a target whose velocity is told
is followed without lag. A target that jumps is reached in minimum jerk after T; after that, and for
a target that moves smoothly, the time to go stays at its floor.

Speeds can be commanded instead of poses, and without a target the plan comes to rest. Whatever
changes in motion (kind of target, tips, blocked joints, limits, law), the generators begin anew
from the speed and acceleration that the plan has, so nothing jumps.

Below the plan, dforc.cartesian.outer_correction moves the reference of compliant joints by the
integral of their measured error.

Lengths in m, angles in rad, base frame, joint vectors (n,) in the order of the model; task vectors
(6,) hold the linear part, then the angular one.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dforc.arrays import ArrayLike, Vector, finite_vector
from dforc.cartesian.aim import Aim, Mode, slowest_joint_s
from dforc.cartesian.arrival import is_in_target, plan_is_at_rest, progress, tip_reports
from dforc.cartesian.outer_correction import CorrectionState, corrected
from dforc.cartesian.params import CartesianParams
from dforc.cartesian.plan import Planner, PlanStep
from dforc.cartesian.scalar_kernel import clamped_reference
from dforc.cartesian.state import (
    CartesianOutput,
    CartesianState,
    Generators,
    Measurement,
    Outside,
    Poses,
    TipKinematics,
)
from dforc.cartesian.targets import Target, Wanted
from dforc.errors import NotFiniteError, ShapeError
from dforc.limits import JointLimits


class CartesianController:
    """The controller's constants; all that changes is in the state handed in and out."""

    def __init__(
        self,
        tips: Sequence[TipKinematics],
        limits: JointLimits,
        params: CartesianParams | None = None,
        free: Sequence[bool] | None = None,
    ) -> None:
        """Keep tips, limits and tuning.

        Args:
            tips: what is to be placed, all over the same joints.
            limits: ranges and rows that plan and reference keep.
            params: tuning.
            free: joints that may move (n,); the others come to rest and hold. None: all.

        Raises:
            ShapeError: tips, limits and flags of different numbers of joints.
            ParameterError: tuning that no controller can have.
        """
        self.tips = tuple(tips)
        self.limits = limits
        self.params = params or CartesianParams()
        self.free = tuple(bool(f) for f in free) if free is not None else (True,) * limits.n
        self.params.check()
        counts = [tip.n for tip in self.tips]
        if not counts or {*counts, len(self.free)} != {limits.n}:
            raise ShapeError(
                f"limits of {limits.n} joints, tips of {counts}, {len(self.free)} flags"
            )
        self._planner = Planner(self.tips, limits, self.params, self.free)
        self._free = np.array(self.free, dtype=np.float64)

    def changed(
        self,
        *,
        tips: Sequence[TipKinematics] | None = None,
        limits: JointLimits | None = None,
        params: CartesianParams | None = None,
        free: Sequence[bool] | None = None,
    ) -> "CartesianController":
        """Another controller; its `take_over` carries a motion on."""
        return CartesianController(
            self.tips if tips is None else tips,
            limits or self.limits,
            params or self.params,
            self.free if free is None else free,
        )

    def start(self, q_ref_rad: ArrayLike) -> CartesianState:
        """At rest at the reference that the joints hold now (not the measured posture: no jump).

        Outside the limits it starts as well; the plan then comes back inside within a second.
        """
        n, tips = self.limits.n, len(self.tips)
        q = finite_vector("reference", q_ref_rad, n)
        return CartesianState(
            q_plan=q,
            dq_plan=np.zeros(n),
            ddq_plan=np.zeros(n),
            generators=Generators.at_rest(n, tips),
            aim=Aim.at_rest(q, tips),
            outside=self._planner.outside(q),
            limited=False,
            in_target=False,
            correction=CorrectionState.none(n),
        )

    def take_over(self, state: CartesianState) -> CartesianState:
        """The motion of another controller of the same joints: speed and acceleration go on.

        A joint that is not free any more comes to rest within the stop time, and the time to go
        starts anew. Raises ShapeError for another number of joints.
        """
        if len(state.q_plan) != self.limits.n:
            raise ShapeError(f"a plan of {len(state.q_plan)} joints for {self.limits.n}")
        aim, params = state.aim, self.params
        if len(aim.active) != len(self.tips):
            aim = replace(Aim.at_rest(aim.q, len(self.tips)), q_onset=aim.q_onset)
        # The next period takes itself off these times before it uses them.
        whole_s = params.trajectory_time_s + params.period_s
        brake_s = params.stop_time_s + params.period_s
        aim = replace(aim, brake_time_s=brake_s, task_time_s=whole_s, joint_time_s=whole_s)
        taken = replace(
            state,
            aim=aim,
            outside=self._planner.outside(state.q_plan),
            in_target=False,
        )
        return self._planner.begun_anew(taken)

    def step(
        self, state: CartesianState, measured: Measurement, target: Target | None
    ) -> tuple[CartesianState, CartesianOutput]:
        """One period. `target` None: the plan stops in minimum jerk and holds.

        Raises:
            NotFiniteError: an input holds NaN or infinity; keep the old state, send no command.
            ShapeError: an input has another size, or is no rotation matrix; likewise.
        """
        q_measured = finite_vector("measured posture", measured.q_rad, self.limits.n)
        if not math.isfinite(measured.external_force_n):
            raise NotFiniteError(f"external force is {measured.external_force_n}")
        poses = Poses.of(self.tips, state.q_plan)
        state, aim = self._aimed(state, target, poses)
        correction = corrected(
            state.correction,
            state.q_plan - q_measured,
            measured.compliant,
            measured.external_force_n,
            self.params.period_s,
            self.params.correction,
        )
        moved = self._planner.moved(state, aim, poses)
        correction, q_ref = self._referenced(moved, correction, state.outside)
        velocities = state.generators.task_velocity
        reports = tip_reports(aim, velocities, poses, Poses.of(self.tips, q_measured))
        in_target = is_in_target(aim, reports, moved.dq, self.params, was=state.in_target)
        after = self._after(state, moved, correction, in_target=in_target)
        return after, CartesianOutput(
            q_rad=q_ref,
            dq_rad_s=moved.dq,
            plan_q_rad=moved.q,
            tips=reports,
            progress=1.0 if in_target else progress(aim, moved.q, self._free),
            duration_s=aim.duration_s,
            in_target=in_target,
            at_rest=plan_is_at_rest(moved.dq),
            held=aim.mode is Mode.HOLD,
            limited=moved.limited,
            gated=correction.gated,
            saturated=correction.saturated,
        )

    def resting_posture(self, state: CartesianState) -> Vector:
        """Where the plan would come to rest now (n,), inside the limits."""
        T, h = self.params.stop_time_s, self.params.period_s
        now = state.dq_plan + 0.5 * h * state.ddq_plan
        way = T * (0.5 * now + T / 12.0 * state.ddq_plan)
        return self.limits.project(state.q_plan + way)

    def _aimed(
        self, state: CartesianState, target: Target | None, poses: Poses
    ) -> tuple[CartesianState, Aim]:
        """The next aim, and the state, begun anew where other coordinates count."""
        before = state.aim
        if target is None:
            aim = before.stopping((poses.position, poses.rotation), self.params)
            afresh = before.mode is not Mode.HOLD
        else:
            wanted = Wanted.checked(target, len(self.tips), self.limits.n)
            afresh = not before.keeps_pattern(wanted)
            aim = self._next_aim(state, wanted, poses)
        return (self._planner.begun_anew(state) if afresh else state), aim

    def _next_aim(self, state: CartesianState, wanted: Wanted, poses: Poses) -> Aim:
        where = (poses.position, poses.rotation)
        if wanted.q is None:
            return state.aim.speeding(wanted, where, self.params, anchored=state.limited)
        if state.in_target and state.aim.trembles(wanted, self.params):
            return state.aim.waited(self.params)
        way = (wanted.q - state.q_plan) * self._free
        slowest_s = slowest_joint_s(way, self._planner.coupling.speed_limit)
        return state.aim.reached(wanted, state.q_plan, where, slowest_s, self.params)

    def _after(
        self,
        state: CartesianState,
        moved: PlanStep,
        correction: CorrectionState,
        *,
        in_target: bool,
    ) -> CartesianState:
        h = self.params.period_s
        return CartesianState(
            q_plan=moved.q,
            dq_plan=moved.dq,
            ddq_plan=(moved.dq - state.dq_plan) / h,
            generators=moved.generators,
            aim=moved.aim,
            outside=Outside(state.outside.distance, state.outside.elapsed_s + h),
            limited=moved.limited,
            in_target=in_target,
            correction=correction,
        )

    def _referenced(
        self, moved: PlanStep, correction: CorrectionState, outside: Outside
    ) -> tuple[CorrectionState, Vector]:
        """q_ref inside the joint ranges; what they cut off is not kept in the correction.

        Not inside the rows: the correction is what a spring needs for the joint to stand at the
        plan, and the plan keeps the rows.
        """
        n = self.limits.n
        lower, upper = self._planner.bounds(outside)
        offset, reference = np.empty(n), np.empty(n)
        cut = clamped_reference(
            moved.q,
            correction.offset_rad,
            self.params.lead_s * moved.dq,
            lower,
            upper,
            offset,
            reference,
        )
        if cut:
            correction = replace(correction, offset_rad=offset, saturated=True)
        return correction, reference
