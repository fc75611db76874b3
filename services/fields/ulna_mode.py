"""Mode `ulna`: a virtual arm that touches nothing on its way; the default.

What it keeps clear of: obstacles, the rest of the body and the other arm, with the whole limb.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dforc import rotation
from dforc.arrays import Vector
from dforc.collision.body import Body
from dforc.limits import JointLimits
from dforc.virtual_arm.arm import VirtualArm
from dforc.virtual_arm.goals import ArmOutput, ArmState, TipGoal
from dforc.virtual_arm.params import ArmParams
from services.core.errors import ServiceError
from services.fields.arm_clearance import ArmClearance
from services.fields.limbs import FieldLimb
from services.fields.mode import PERIOD_S, Goals, HandGoal, HandPoint, Motion, Start, Surroundings
from services.reaching.messages import TipOffset


class UlnaMode:
    """The arm of a limb, or both."""

    name = "ulna"
    preview_steps = 8

    def __init__(
        self, limb: FieldLimb, gains: Mapping[str, float], body: Body, frames: tuple[str, ...]
    ) -> None:
        """`frames` are the limb's hands among the body's tips."""
        self._limb = limb
        self._frames = frames
        self._plain = body
        self._body = with_offsets(body, frames, limb.setup.tip_offsets)
        self._clearance = ArmClearance(self._body, limb.shape.joints)
        self._gains = dict(gains)
        self._params = arm_params(gains)
        self.budget = self._params.goal_tries + self._params.planner_states
        self._has_begun = False
        self._output: ArmOutput | None = None
        home = limb.problem.limits.project(limb.problem.rest_rad)
        self._arm = self._made(home, None)  # takes several periods: not when a goal comes

    def use(self, gains: Mapping[str, float]) -> None:
        """The arm goes on from where it is."""
        if gains == self._gains:
            return
        self._gains = dict(gains)
        self._params = arm_params(gains)
        self._arm.change(self._params)

    def begin(self, start: Start) -> None:
        """The posture is that given, at its speed."""
        if self._limb.problem.free.all():
            self._arm.begin(start.q_rad, start.dq_rad_s)
        else:  # the blocked joints' limits are where they are now
            self._arm = self._made(start.q_rad, start.dq_rad_s)
        self._output = None
        self._has_begun = True

    def new_goal(self) -> None:
        """The attempts begin again, wherever it is."""
        self._arm.new_goal()

    def step(self, goals: Goals | None, around: Surroundings, lag_m: float) -> Motion:
        """The arm draws nearer to the goal, clear of everything."""
        if not self._has_begun:
            raise ServiceError("mode ulna has not begun")
        asked = None if goals is None else [_tip_goal(goal) for goal in goals]
        q_rad = self._arm.q_rad  # that the distances are of
        output = self._arm.step(
            asked, around.world, around.body_rad, around.body_rad_s, PERIOD_S, lag_m
        )
        self._output = output
        clearance_m, nearest = self._told(output, q_rad, around)
        state, reason = _with_contact(output, clearance_m, nearest, around)
        return Motion(
            hands=tuple(
                HandPoint(
                    position_m=tip.position_m, rotation=tip.rotation, velocity_m_s=tip.velocity_m_s
                )
                for tip in output.tips
            ),
            state=str(state),
            reason=reason,
            q_rad=output.q_rad,
            dq_rad_s=output.dq_rad_s,
            clearance_m=clearance_m,
            nearest=nearest,
            iterations=output.iterations,
            nodes=output.nodes,
            held=output.held,
        )

    def _told(
        self, output: ArmOutput, q_rad: Vector, around: Surroundings
    ) -> tuple[float, tuple[str, str]]:
        """Clearance and between what: of the objects themselves, whatever room they have."""
        if around.world.margins.any():
            return self._clearance.of(q_rad, around, self._params.reach_m)
        capsule, other = output.nearest
        if output.nearest_obstacle >= 0:
            other = around.obstacles[output.nearest_obstacle].name
        return output.clearance_m, (capsule, other)

    def _made(self, q_rad: Vector, dq_rad_s: Vector | None) -> VirtualArm:
        """An arm that is there, at these speeds."""
        problem = self._limb.problem
        arm = VirtualArm(
            self._body,
            self._limb.shape.joints,
            kept_still(problem.limits, problem.free, q_rad),
            self._limb.shape.speed_limits_rad_s,
            tuple(self._body.tips.index(frame) for frame in self._frames),
            problem.rest_rad,
            self._params,
        )
        arm.begin(q_rad, dq_rad_s)
        return arm

    def forces(self, goals: Goals | None, around: Surroundings) -> dict[str, float]:  # noqa: ARG002
        """None: it works with speeds."""
        return {}


def _with_contact(
    output: ArmOutput, clearance_m: float, nearest: tuple[str, str], around: Surroundings
) -> tuple[ArmState, str]:
    """State and reason; what the arm is inside of counts before all else."""
    capsule, other = nearest
    if clearance_m < 0.0:
        state = ArmState.WAITING if output.state is ArmState.ARRIVED else output.state
        return state, f"{capsule} is {-1e3 * clearance_m:.0f} mm inside {other}"
    if output.clearance_m < 0.0 and output.nearest_obstacle >= 0:
        capsule, other = output.nearest[0], around.obstacles[output.nearest_obstacle].name
        depth_mm = -1e3 * output.clearance_m
        return output.state, f"{capsule} is {depth_mm:.0f} mm inside the room kept around {other}"
    return output.state, output.reason


def arm_params(gains: Mapping[str, float]) -> ArmParams:
    """Gains as the virtual arm has them."""
    return ArmParams(
        stiffness_n_m=gains["K"],
        damping_ns_m=gains["D"],
        speed_m_s=gains["speed"],
        turn_rad_s=gains["turn"],
        margin_m=gains["margin"],
        least_margin_m=min(gains["least_margin"], gains["margin"]),
        self_margin_m=gains["self_margin"],
    )


def with_offsets(body: Body, frames: tuple[str, ...], offsets: tuple[TipOffset, ...]) -> Body:
    """The body with other frames attached to some of its tips."""
    if not offsets:
        return body
    arrays = body.arrays
    turns, places = arrays.tip_turns.copy(), arrays.tip_places.copy()
    for frame, offset in zip(frames, offsets, strict=True):
        at = body.tips.index(frame)
        turned = turns[at].reshape(3, 3)
        places[at] += turned @ np.array(offset.position_m)
        turns[at] = (turned @ rotation.matrix(offset.rotation_rad)).ravel()
    return replace(body, arrays=arrays._replace(tip_turns=turns, tip_places=places))


def kept_still(limits: JointLimits, free: np.ndarray, q_rad: Vector) -> JointLimits:
    """The limits with blocked joints where they are."""
    if free.all():
        return limits
    n = limits.n
    lower = np.where(free, limits.lower_rad, q_rad)
    upper = np.where(free, limits.upper_rad, q_rad)
    return JointLimits.make(lower, upper, limits.rows, limits.lower[n:], limits.upper[n:])


def _tip_goal(goal: HandGoal | None) -> TipGoal | None:
    if goal is None:
        return None
    return TipGoal(goal.position_m, goal.rotation, goal.velocity_m_s)
