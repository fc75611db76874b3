"""Where the main job reaches to and what stands in the way, drawn from a seed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from services.messages import Vector3

Vector = NDArray[np.float64]

# Forward and towards the middle of the body: the arm stays 16 degrees from every limit.
REACH_M = np.array([-0.14, -0.14, 0.0])  # base frame: x backwards, y to the robot's right, z up
TARGET_SPREAD_M = 0.02  # on each axis
BALL_RADIUS_M = 0.05
BALL_OFFSET_M = (0.010, 0.020)  # of its centre from the straight line


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
    centre = _beside_the_line(start_m, target, for_ball)
    return Scene(_vector3(target), _vector3(centre), BALL_RADIUS_M)


def _beside_the_line(start_m: Vector, target_m: Vector, generator: np.random.Generator) -> Vector:
    line = target_m - start_m
    along = line / np.linalg.norm(line)
    aside = np.cross(along, generator.normal(size=3))
    aside /= np.linalg.norm(aside)
    centre: Vector = start_m + 0.5 * line + generator.uniform(*BALL_OFFSET_M) * aside
    return centre


def _vector3(values: Vector) -> Vector3:
    return (float(values[0]), float(values[1]), float(values[2]))
