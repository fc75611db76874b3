"""Figure 5's scenes on the robot's own arm: targets of PMP's table that it can attain.

The robot keeps rows of shoulder and elbow that PMP does not know; a target whose position they put
out of reach is none for the robot, and left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.field.force import FieldParams, ball, scene_of
from dforc.field.kernel_force import Scene
from dforc.ik.inverse_kinematics import IkStatus, InverseKinematics
from dforc.ik.problem import TipTarget
from dforc.rotation import matrix, rotation_vector
from services.experiments.field_figures.fig5_stack import StackScene
from services.experiments.field_figures.pmp import ASIDE_M, GAIN_N, RADIUS_M, targets_of
from services.experiments.field_figures.pmp_arm import OWN, HandPose, PmpArm, arm_of
from services.messages import Obstacle, Vector3
from services.reaching.limb import limb_problem
from services.robotfile.robot_tables import RobotFile

MOST_TARGETS = 60  # looked at
STARTS, BUDGET = 20, 4000
SHORTEST_M = 0.15  # way of the scene that is repeated


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Figure5:
    """What the figure shows, and targets beside it."""

    arm: PmpArm
    easy: HandPose  # A
    hard: HandPose  # B to E
    ball: Obstacle  # C and E
    others: tuple[tuple[str, HandPose], ...]

    @property
    def free(self) -> StackScene:
        """D."""
        return stack_scene("D, free", self.hard)

    @property
    def blocked(self) -> StackScene:
        """E."""
        return stack_scene("E, obstacle", self.hard, self.ball)

    @property
    def obstacle(self) -> Scene:
        """C: the ball as PMP feels it."""
        item = ball(self.ball.centre_m, self.ball.radius_m)
        return scene_of((), (item,), FieldParams(gain_n=GAIN_N))


def figure_scenes(robot: RobotFile, seed: int, others: int) -> Figure5:
    """The first targets of PMP's table that the robot attains: `others` of each kind."""
    arm = arm_of(OWN)
    targets = targets_of(arm, seed, MOST_TARGETS)
    inverse = InverseKinematics(limb_problem(robot))
    easy = list(_attained(inverse, arm, targets[False], others + 1))
    hard = list(_attained(inverse, arm, targets[True], others + 1))
    centre = _beside_the_way(arm.home_m, hard[0].position_m, np.random.default_rng(seed))
    named = [("mid-range", t) for t in easy[1:]] + [("edge", t) for t in hard[1:]]
    return Figure5(
        arm=arm,
        easy=easy[0],
        hard=hard[0],
        ball=Obstacle(_vector3(centre), RADIUS_M),
        others=tuple(named),
    )


def stack_scene(name: str, target: HandPose, obstacle: Obstacle | None = None) -> StackScene:
    """A reach to a target through the stack."""
    return StackScene(
        name=name,
        target_m=_vector3(target.position_m),
        rotation_rad=_vector3(rotation_vector(target.rotation)),
        ball=obstacle,
    )


def nearest_orientation_rad(robot: RobotFile, scene: StackScene) -> float:
    """The smallest angle to a target's orientation with its position, of many starts."""
    problem = limb_problem(robot)
    wanted = TipTarget(np.array(scene.target_m), matrix(scene.rotation_rad))
    home = np.radians(robot.reach.home_deg)
    answer = InverseKinematics(problem).solve([wanted], home, budget=BUDGET, starts=STARTS)
    return answer.orientation_error_rad


def _attained(
    inverse: InverseKinematics, arm: PmpArm, targets: list[HandPose], count: int
) -> Iterator[HandPose]:
    """Those whose position is in reach, and far enough from home to be a reach."""
    home = arm.home_m
    for target in targets:
        if count == 0:
            return
        if float(np.linalg.norm(target.position_m - home)) < SHORTEST_M:
            continue
        wanted = TipTarget(target.position_m, target.rotation)
        answer = inverse.solve([wanted], arm.home_rad, budget=BUDGET, starts=STARTS)
        if answer.status is IkStatus.CONVERGED:
            count -= 1
            yield target


def _beside_the_way(start_m: Vector, end_m: Vector, rng: np.random.Generator) -> Vector:
    way = end_m - start_m
    aside = np.cross(way, rng.normal(size=3))
    centre: Vector = start_m + 0.5 * way + ASIDE_M * aside / np.linalg.norm(aside)
    return centre


def _vector3(values: Vector) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
