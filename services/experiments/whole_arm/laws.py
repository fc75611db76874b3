"""Laws that bring an arm to its goal, all asked the same way: a posture every 10 ms.

paper       eqs. 3 to 5 with the paper's constants move a point, eq. 1 gives the posture
inflated    the same, obstacles larger by the hand's radius and 1 cm
point       the project's better law for a bare point, obstacles larger by the hand's radius; eq. 1
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from dforc.collision.obstacles import Obstacle, Shape, world_of
from dforc.field.force import Ellipsoid, FieldParams, PointState, Target, scene_of
from dforc.field.kernel_force import Scene
from dforc.field.point import PointField
from dforc.field.rollout import PERIOD_S, step
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from services.experiments.whole_arm.draw import Goal
from services.experiments.whole_arm.referee import Array

HAND_M = 0.05  # radius of the hand about its frame, as the inflated field has it
INFLATION_M = 0.01
ENDED = "ended"  # what a law says when nothing will move any more


@dataclass(frozen=True, eq=False)
class Seen:
    """What a law is told in one tick."""

    goals: tuple[Goal, ...]
    obstacles: tuple[Obstacle, ...]  # as the sensors have them, with velocity and margin
    others_rad: Array | None = None  # joints of the body that are not the limb's, where they move
    others_rad_s: Array | None = None


@dataclass(frozen=True, eq=False)
class Answer:
    """The posture to execute, and what the law says."""

    q_rad: Array
    state: str = ""
    reason: str = ""


class ArmLaw(Protocol):
    """One law. It never looks at a clock."""

    name: str

    def begin(self, q_rad: Array) -> None:
        """Stand in this posture."""
        ...

    def step(self, seen: Seen) -> Answer:
        """Go on by 10 ms."""
        ...


class Nothing:
    """The empty law: what the loop itself costs."""

    name = "empty loop"

    def begin(self, q_rad: Array) -> None:
        """Stand."""
        self._answer = Answer(q_rad)

    def step(self, seen: Seen) -> Answer:  # noqa: ARG002
        """Stand still."""
        return self._answer


class PaperLaw:
    """DForC: the point of each hand by itself, and eq. 1 for all of them."""

    def __init__(self, name: str, problem: IkProblem, params: FieldParams) -> None:
        self.name = name
        self._ik = InverseKinematics(problem)
        self._problem = problem
        self._params = params
        self._made: tuple[tuple[Obstacle, ...], tuple[Goal, ...]] | None = None

    def begin(self, q_rad: Array) -> None:
        """The points are where the hands are."""
        self._q = q_rad
        self._points = []
        self._made = None
        for tip in self._problem.tips:
            x, y, z = tip.pose(q_rad)[1].tolist()
            self._points.append(PointState(position_m=(x, y, z)))

    def step(self, seen: Seen) -> Answer:
        """Move the points, then follow."""
        if self._made is None or self._made != (seen.obstacles, seen.goals):
            self._scenes = [_scene(goal, seen.obstacles, self._params) for goal in seen.goals]
            self._made = (seen.obstacles, seen.goals)
        targets = []
        for k, (goal, scene) in enumerate(zip(seen.goals, self._scenes, strict=True)):
            self._points[k] = step(self._points[k], scene, PERIOD_S)
            targets.append(TipTarget(np.array(self._points[k].position_m), goal.rotation))
        found = self._ik.track(targets, self._q)
        self._q = found.q_rad
        return Answer(found.q_rad, "" if found.status is IkStatus.CONVERGED else found.reason)


class PointLaw:
    """The better law for each hand's point, and eq. 1: only the hand is kept off obstacles."""

    def __init__(self, name: str, problem: IkProblem) -> None:
        self.name = name
        self._ik = InverseKinematics(problem)
        self._problem = problem
        self._fields = [PointField() for _ in problem.tips]
        self._seen: Seen | None = None

    def begin(self, q_rad: Array) -> None:
        """The points are where the hands are."""
        self._q = q_rad
        self._seen = None
        for field, tip in zip(self._fields, self._problem.tips, strict=True):
            field.begin(tip.pose(q_rad)[1])

    def step(self, seen: Seen) -> Answer:
        """Move the points, then follow."""
        if self._seen is not seen:
            self._seen = seen
            self._world = world_of(
                [replace(one, margin_m=one.margin_m + HAND_M) for one in seen.obstacles]
            )
        targets, state = [], ""
        for field, goal in zip(self._fields, seen.goals, strict=True):
            found = field.step(goal.position_m, self._world, PERIOD_S)
            state = str(found.status)
            targets.append(TipTarget(found.position_m, goal.rotation))
        self._q = self._ik.track(targets, self._q).q_rad
        return Answer(self._q, state)


def ellipsoids(obstacles: Sequence[Obstacle]) -> list[Ellipsoid]:
    """Spheres and ellipsoids as the paper's obstacles; it knows no others."""
    found = []
    for one in obstacles:
        if one.shape not in (Shape.SPHERE, Shape.ELLIPSOID):
            raise ValueError(f"the paper's field has ellipsoids only, no {one.shape.name.lower()}")
        axes = one.size_m if one.shape is Shape.ELLIPSOID else (one.size_m[0],) * 3
        found.append(Ellipsoid(centre_m=one.position_m, semi_axes_m=axes, rotation=one.rotation))
    return found


def _scene(goal: Goal, obstacles: Sequence[Obstacle], params: FieldParams) -> Scene:
    x, y, z = goal.position_m.tolist()
    return scene_of([Target(position_m=(x, y, z))], ellipsoids(obstacles), params)
