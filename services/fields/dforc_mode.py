"""Mode `dforc`: the paper's field moves a point for each hand (DForC, eqs. 3 to 5).

As published: only the hand is kept out of obstacles, which are ellipsoids, and the point can be
trapped. The orientation is no part of the field: it turns to the goal's at a bounded rate, and the
way round that the arm can.
"""

from collections.abc import Mapping

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.collision.obstacles import Triple
from dforc.field.force import FieldParams, PointState, Target, force, repulsion, scene_of
from dforc.field.kernel_force import Scene
from dforc.field.rollout import step
from dforc.field.turning import Turning
from dforc.ik.problem import TipTarget
from services.fields.clearances import hand_clearance
from services.fields.limbs import FieldLimb
from services.fields.mode import PERIOD_S, Goals, HandGoal, HandPoint, Motion, Start, Surroundings
from services.fields.seen import as_ellipsoid
from services.fields.standstill import Standstill
from services.reaching.tip_poses import vector3


class DforcMode:
    """One point per hand."""

    name = "dforc"
    budget = 0
    preview_steps = 40

    def __init__(self, limb: FieldLimb, gains: Mapping[str, float]) -> None:
        self._limb = limb
        self._gains = dict(gains)
        self._params = _params(gains)
        self._hands: tuple[HandPoint, ...] = ()
        self._still = Standstill()
        self._turning = Turning(limb.problem)

    def use(self, gains: Mapping[str, float]) -> None:
        """Other forces act on the points from now on."""
        self._gains = dict(gains)
        self._params = _params(gains)

    def begin(self, start: Start) -> None:
        """The points are those given; the posture says which way round the hands may turn."""
        self._hands = start.hands
        self._turning.begin(start.q_rad)
        self._still = Standstill()

    def new_goal(self) -> None:
        """The points have not come to rest on the way to it yet."""
        self._still = Standstill()

    def step(self, goals: Goals | None, around: Surroundings, lag_m: float) -> Motion:  # noqa: ARG002
        """The points obey the forces; that of a hand without a goal stands."""
        asked: Goals = (None,) * len(self._hands) if goals is None else goals
        turns = self._turning.step(
            [hand.rotation for hand in self._hands],
            [hand.position_m for hand in self._hands],
            [_tip_target(goal) for goal in asked],
            PERIOD_S,
        )
        self._hands = tuple(
            self._moved(hand, goal, turned, around)
            for hand, goal, turned in zip(self._hands, asked, turns, strict=True)
        )
        state, reason = ("idle", "")
        if goals is not None:
            state, reason = self._still.judge(self._hands, goals)
        clearance_m, nearest = hand_clearance(self._hands, around)
        return Motion(
            hands=self._hands,
            state=state,
            reason=reason,
            clearance_m=clearance_m,
            nearest=nearest,
        )

    def forces(self, goals: Goals | None, around: Surroundings) -> dict[str, float]:
        """Of eq. 3 and eq. 5 on the first hand's point."""
        hand, goal = self._hands[0], goals[0] if goals else None
        state = PointState(
            position_m=vector3(hand.position_m), velocity_m_s=vector3(hand.velocity_m_s)
        )
        found = {}
        if goal is not None:
            found["goal"] = _size(force(state, scene_of([_target(goal)], [], self._params)))
        for seen in around.obstacles:
            alone = scene_of([], [as_ellipsoid(seen)], self._params)
            found[seen.name] = _size(repulsion(state.position_m, alone))
        return found

    def _moved(
        self, hand: HandPoint, goal: HandGoal | None, turned: Matrix, around: Surroundings
    ) -> HandPoint:
        scene = self._scene(hand, goal, around)
        before = PointState(
            position_m=vector3(hand.position_m), velocity_m_s=vector3(hand.velocity_m_s)
        )
        after = step(before, scene, PERIOD_S)
        return HandPoint(
            position_m=np.array(after.position_m),
            rotation=turned,
            velocity_m_s=np.array(after.velocity_m_s),
        )

    def _scene(self, hand: HandPoint, goal: HandGoal | None, around: Surroundings) -> Scene:
        """Without a goal the point is drawn to where it is, so that it comes to rest."""
        here = Target(position_m=vector3(hand.position_m))
        targets = [here if goal is None else _target(goal)]
        if goal is not None and self._gains["targets"]:
            targets += [Target(position_m=seen.place_m) for seen in around.targets]
        obstacles = [as_ellipsoid(seen) for seen in around.obstacles]
        return scene_of(targets, obstacles, self._params)


def _params(gains: Mapping[str, float]) -> FieldParams:
    return FieldParams(
        stiffness_n_m=gains["K"],
        damping_ns_m=gains["D"],
        gain_n=gains["G"],
        margin_m=gains["margin"],
        truncated=bool(gains["truncated"]),
    )


def _target(goal: HandGoal) -> Target:
    return Target(position_m=vector3(goal.position_m))


def _tip_target(goal: HandGoal | None) -> TipTarget | None:
    return None if goal is None else TipTarget(goal.position_m, goal.rotation)


def _size(force_n: Triple) -> float:
    size: Vector = np.array(force_n)
    return float(np.linalg.norm(size))
