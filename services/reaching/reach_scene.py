"""Where the main job reaches to and what stands in the way, drawn from a seed.

The ball stands above the straight way of the hand, and in it; and so beside the forearm in the end,
which has to make room: see `rotation_there`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix
from dforc.collision.obstacles import sphere, world_of
from dforc.rotation import angle_between
from dforc.virtual_arm.goal_postures import GoalSearch
from dforc.virtual_arm.goals import TipGoal
from services.fields.robot_body import robot_body
from services.messages import Vector3
from services.reaching.limb import find_limb, limb_joints, limb_problem
from services.robotfile.robot_tables import RobotFile

Vector = NDArray[np.float64]

# Forward and towards the middle of the body: the arm stays 16 degrees from every limit.
REACH_M = np.array([-0.14, -0.14, 0.0])  # base frame: x backwards, y to the robot's right, z up
TARGET_SPREAD_M = 0.02  # on each axis
BALL_RADIUS_M = 0.05
BALL_OFFSET_M = (0.035, 0.045)  # of its centre from the straight line: the hand would hit it
BALL_SIDE_RAD = (-0.8, 0.8)  # of that offset from straight up: the forearm comes from below
CLEAR_M, SELF_CLEAR_M = 0.025, 0.010  # of the whole arm at the target, where that can be had
TRIES = 300


@dataclass(frozen=True, slots=True)
class Scene:
    """One reach. Base frame, metres; the ball is None when nothing is in the way."""

    target_m: Vector3
    ball_centre_m: Vector3 | None
    ball_radius_m: float


def draw_scene(
    start_m: Vector,
    seed: int,
    target_m: Vector3 | None = None,
    ball: tuple[float, float, float, float] | None = None,
) -> Scene:
    """A scene for a hand that starts at `start_m` (3,): what is given is kept, the rest drawn.

    Targets and balls have generators of their own, so that giving one does not change the other.
    """
    for_target, for_ball = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    spread = for_target.uniform(-TARGET_SPREAD_M, TARGET_SPREAD_M, 3)
    target = start_m + REACH_M + spread if target_m is None else np.array(target_m)
    if ball is not None:
        return Scene(_vector3(target), (ball[0], ball[1], ball[2]), ball[3])
    centre = _above_the_line(start_m, target, for_ball)
    return Scene(_vector3(target), _vector3(centre), BALL_RADIUS_M)


def rotation_there(
    robot: RobotFile, scene: Scene, q_rad: Vector, kept: Matrix, seed: int
) -> Matrix:
    """How the hand is to be turned at the target: as near to `kept` as is clear of the ball.

    Args:
        robot: whose main limb reaches.
        scene: target and ball.
        q_rad: posture of the limb (n,), where the search begins; other joints as they are parked.
        kept: rotation (3, 3) that would be liked best.
        seed: of the search.
    """
    if scene.ball_centre_m is None:
        return kept
    limb, problem, body = find_limb(robot), limb_problem(robot), robot_body(robot)
    tips = [body.tips.index(tip.frame) for tip in limb.tips]
    columns = body.columns(limb_joints(robot))
    search = GoalSearch(body, columns, problem.limits, tips, problem.rest_rad, seed)
    goal = TipGoal.checked(scene.target_m, kept)
    others = np.radians([robot.joints[name].park_deg for name in body.joints])
    world = world_of([sphere("ball", scene.ball_centre_m, scene.ball_radius_m)])
    search.begin([goal], world, q_rad, others, CLEAR_M, SELF_CLEAR_M)
    search.advance(TRIES)
    turned = [problem.tips[0].pose(q)[0] for q in search.postures]
    return min(turned, key=lambda rotation: angle_between(rotation, kept), default=kept)


def _above_the_line(start_m: Vector, target_m: Vector, generator: np.random.Generator) -> Vector:
    line = target_m - start_m
    along = line / np.linalg.norm(line)
    up = np.array([0.0, 0.0, 1.0]) - along[2] * along
    up /= np.linalg.norm(up)
    side, offset = generator.uniform(*BALL_SIDE_RAD), generator.uniform(*BALL_OFFSET_M)
    away = np.cos(side) * up + np.sin(side) * np.cross(along, up)
    centre: Vector = start_m + 0.5 * line + offset * away
    return centre


def _vector3(values: Vector) -> Vector3:
    return (float(values[0]), float(values[1]), float(values[2]))
