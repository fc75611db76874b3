"""Mode `pmp`: the Passive Motion Paradigm moves a virtual arm (Table I, variants A and B).

As published: the hand alone is kept out of obstacles, limit fields hold the hand back before the
goal, and the time base does not promise that it gets there.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.field.force import FieldParams, repulsion, scene_of
from dforc.field.kernel_force import Scene
from dforc.ik.problem import Tip
from dforc.pmp.motion import Pmp, PmpState, PmpTarget
from dforc.pmp.params import Orientation, PmpParams, Variant
from dforc.robot_model import ChainElement
from services.core.errors import ConfigError, ServiceError
from services.fields.clearances import hand_clearance
from services.fields.limbs import FieldLimb
from services.fields.mode import PERIOD_S, Goals, HandGoal, HandPoint, Motion, Start, Surroundings
from services.fields.seen import as_ellipsoid
from services.fields.standstill import Standstill
from services.reaching.tip_poses import vector3

JUMP_M = 0.01  # of the goal from one period to the next: the time base begins again
OVER = "the time base has run out (tau); `ulna field set gamma=0` goes on until it is there"
HELD_BACK = "limit fields hold the hand back; `ulna field set limits=0`, or mode ulna, does not"


class TipKinematics:
    """A tip as PMP wants its kinematics."""

    def __init__(self, tip: Tip) -> None:
        self.n = tip.n
        self._tip = tip

    def tip_pose(self, q_rad: Vector) -> tuple[Matrix, Vector]:
        """Rotation (3, 3) and position (3,)."""
        return self._tip.pose(q_rad)

    def tip_jacobian(self, q_rad: Vector) -> Matrix:
        """Geometric Jacobian (6, n), linear rows first."""
        return self._tip.jacobian(q_rad)

    def chain_description(self) -> Sequence[ChainElement]:
        """From the base to the tip, as it is attached."""
        chain, tip = list(self._tip.model.chain_description()), self._tip
        last = chain[-1]
        chain[-1] = last._replace(R=last.R @ tip.offset_rotation, p=last.p + last.R @ tip.offset_m)
        return chain


class PmpMode:
    """A virtual arm with one hand."""

    name = "pmp"
    budget = 0
    preview_steps = 16

    def __init__(self, limb: FieldLimb, gains: Mapping[str, float]) -> None:
        """Raise ConfigError for a limb with two hands: Table I has one."""
        if limb.hands != 1:
            raise ConfigError(f"mode pmp moves one hand, {limb.name} has two; mode ulna moves both")
        self._limb = limb
        self._kinematics = TipKinematics(limb.problem.tips[0])
        self._gains = dict(gains)
        self._pmp = self._made(gains)
        self._state: PmpState | None = None
        self._goal_m: Vector | None = None
        self._still = self._standstill()

    def use(self, gains: Mapping[str, float]) -> None:
        """The arm goes on from where it is; a changed time base begins again."""
        if gains == self._gains:
            return
        timed = ("tau", "gamma", "epsilon")
        if self._state is not None and any(self._gains[key] != gains[key] for key in timed):
            self._state = self._pmp.again(self._state)
        self._gains = dict(gains)
        self._pmp = self._made(gains)

    def begin(self, start: Start) -> None:
        """The posture is that given."""
        self._state = self._pmp.begin(self._limb.problem.limits.project(start.q_rad))
        self._goal_m = None
        self._still = self._standstill()

    def new_goal(self) -> None:
        """The time base begins again."""
        self._goal_m = None

    def step(self, goals: Goals | None, around: Surroundings, lag_m: float) -> Motion:  # noqa: ARG002
        """The arm gives way to the forces; without a goal it stands."""
        state, goal = self._at(), goals[0] if goals else None
        if goal is None:
            return self._motion(state, np.zeros_like(state.q_rad), around, "idle", "")
        if self._goal_m is None or np.linalg.norm(goal.position_m - self._goal_m) > JUMP_M:
            state = self._pmp.again(state)
            self._still = self._standstill()
        self._goal_m = goal.position_m
        target = PmpTarget(position_m=goal.position_m, rotation=goal.rotation)
        state = self._pmp.step(state, target, self._pushing(around), PERIOD_S)
        self._state = state
        kind, reason = self._still.judge((self._hand(state, state.dq_rad_s),), (goal,))
        if kind != "arrived" and self._gains["gamma"] and state.time_s >= self._gains["tau"]:
            kind, reason = "waiting", f"{self._away(state, goal)} from the goal: {OVER}"
        return self._motion(state, state.dq_rad_s, around, kind, reason)

    def forces(self, goals: Goals | None, around: Surroundings) -> dict[str, float]:
        """Of the spring and of eq. 5 on the hand; of eq. 8 the torque on the joints [Nm]."""
        state, goal = self._at(), goals[0] if goals else None
        found = {}
        if goal is not None:
            away_m = float(np.linalg.norm(goal.position_m - state.position_m))
            found["goal"] = self._gains["K"] * away_m
        for seen in around.obstacles:
            alone = scene_of([], [as_ellipsoid(seen)], self._params())
            found[seen.name] = float(np.linalg.norm(repulsion(vector3(state.position_m), alone)))
        return found

    def _standstill(self) -> Standstill:
        return Standstill(HELD_BACK) if self._gains["limits"] else Standstill()

    def _at(self) -> PmpState:
        if self._state is None:
            raise ServiceError("mode pmp has not begun")
        return self._state

    def _pushing(self, around: Surroundings) -> Scene:
        return scene_of([], [as_ellipsoid(seen) for seen in around.obstacles], self._params())

    def _params(self) -> FieldParams:
        return FieldParams(gain_n=self._gains["G"], margin_m=self._gains["margin"])

    def _away(self, state: PmpState, goal: HandGoal) -> str:
        return f"{np.linalg.norm(goal.position_m - state.position_m) * 1e3:.0f} mm"

    def _hand(self, state: PmpState, dq_rad_s: Vector) -> HandPoint:
        (velocity,) = self._limb.velocities(state.q_rad, dq_rad_s)
        return HandPoint(
            position_m=state.position_m, rotation=state.rotation, velocity_m_s=velocity
        )

    def _motion(
        self, state: PmpState, dq_rad_s: Vector, around: Surroundings, kind: str, reason: str
    ) -> Motion:
        hands = (self._hand(state, dq_rad_s),)
        clearance_m, nearest = hand_clearance(hands, around)
        return Motion(
            hands=hands,
            state=kind,
            reason=reason,
            q_rad=state.q_rad,
            dq_rad_s=dq_rad_s,
            clearance_m=clearance_m,
            nearest=nearest,
        )

    def _made(self, gains: Mapping[str, float]) -> Pmp:
        limits, free = self._limb.problem.limits, self._limb.problem.free
        params = PmpParams(
            variant=Variant.B if gains["variant"] else Variant.A,
            stiffness_n_m=gains["K"],
            angular_stiffness_nm_rad=gains["K"],
            orientation=Orientation.LOG,
            limit_gain_nm=gains["alpha"] if gains["limits"] else 0.0,
            admittance_rad_nms=tuple(np.where(free, gains["A"], 0.0).tolist()),
            has_time_base=bool(gains["gamma"]),
            duration_s=gains["tau"],
            epsilon=gains["epsilon"],
        )
        return Pmp(self._kinematics, limits.lower_rad, limits.upper_rad, params)
