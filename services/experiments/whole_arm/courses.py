"""Scenes in which something changes: an obstacle passes, the other arm works, a cage opens.

passing     one ball of 3 to 6 cm crosses the hand's line at right angles, 0.1 to 0.4 m/s, two
            others stand. Its whole way is clear of start and goal posture by 5 cm. Every 10 ms its
            place is told with 10 mm of noise, and a tracker makes of it what the law is told
other arm   the left arm swings between two postures, its hand near the line of the right one; at
            all times it is clear of the right arm's start and goal posture by 3 cm
enclosed    a shell of balls around the goal leaves no way in for 8 s, then it is taken away
both arms   two hands over one waist, whose straight lines cross; three balls
switch      five balls; after 0.7 s the goal is another one
"""

from dataclasses import dataclass, replace

import numpy as np

from dforc.collision.obstacles import Obstacle, Triple, sphere
from dforc.field.rollout import PERIOD_S
from dforc.field.tracking import ObjectTracker
from services.experiments.whole_arm.draw import (
    CLEAR_M,
    MOST_TRIES,
    ArmScene,
    Hands,
    NoSceneError,
    ball_near,
    line_axes,
    make_scene,
    point_segments,
)
from services.experiments.whole_arm.laws import Seen
from services.experiments.whole_arm.referee import Array
from services.experiments.whole_arm.run import Course, Moment
from services.experiments.whole_arm.setting import ArmSetting
from services.fields.seen import SIGMAS, WIDEST_M
from services.reaching.limb import limb_joints, limb_limits

NOISE_M = 0.010
SLOWEST_M_S, FASTEST_M_S = 0.1, 0.4
PASSING_CLEAR_M, SWING_CLEAR_M = 0.05, 0.03
HALF_WAY_M = 0.5  # of the passing ball, on either side of the line
LATEST_S = 2.0
STANDING = 2

LEFT_ARM = "left_arm"
SWING_LOOKS = 24  # postures of a swing that are checked
NEAR_LINE_M = 0.15
SWING_S = (4.0, 8.0)

CAGE_BALLS, CAGE_M, CAGE_BALL_M = 44, 0.11, 0.03
OPENS_S = 8.0
GONE_M = 100.0

SWITCH_S, SWITCH_BALLS = 0.7, 5

CROSSING_M = 0.10
BOTH_BALLS = 3
SAMPLES = np.linspace(0.0, 1.0, 21)


@dataclass(frozen=True, eq=False)
class Passage:
    """A ball on its way past the arm."""

    from_m: Array
    velocity_m_s: Array
    begins_s: float
    ends_s: float

    def at(self, t_s: float) -> Array:
        """Where it is."""
        place: Array = self.from_m + self.velocity_m_s * (
            min(max(t_s, self.begins_s), self.ends_s) - self.begins_s
        )
        return place


class PassingCourse:
    """The ball as it is, and as it is seen."""

    def __init__(self, scene: ArmScene, passage: Passage, rng: np.random.Generator) -> None:
        self._scene, self._passage, self._rng = scene, passage, rng
        self._tracker = ObjectTracker()
        self._others = np.array([one.position_m for one in scene.obstacles[1:]]).reshape(-1, 3)

    def __call__(self, tick: int) -> Moment:
        """What is so in this tick."""
        t_s = tick * PERIOD_S
        place = self._passage.at(t_s)
        self._tracker.update(t_s, place + self._rng.normal(0.0, NOISE_M, 3), NOISE_M**2 * np.eye(3))
        position, velocity, sigma_m = self._tracker.avoided_at(t_s)
        ball = replace(
            self._scene.obstacles[0],
            position_m=_triple(position),
            velocity_m_s=_triple(velocity),
            margin_m=min(WIDEST_M, SIGMAS * sigma_m),
        )
        seen = Seen(self._scene.goals, (ball, *self._scene.obstacles[1:]))
        return Moment(seen, np.vstack([self._passage.at(t_s + PERIOD_S), self._others]))


def passing_scene(setting: ArmSetting, number: int, seed: int) -> tuple[ArmScene, Course]:
    """A ball passes."""
    rng = np.random.default_rng([seed, 2001, number])

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        return [ball_near(rng, a, b, k) for k in range(STANDING)]

    for _ in range(MOST_TRIES):
        scene = make_scene(setting, "passing", number, rng, place)
        passage, radius = _passage(setting, scene, rng)
        if passage is not None:
            x, y, z = passage.from_m.tolist()
            obstacles = (sphere("passing", (x, y, z), radius), *scene.obstacles)
            scene = replace(scene, obstacles=obstacles)
            return scene, PassingCourse(scene, passage, rng)
    raise NoSceneError("no ball passes")


def _passage(
    setting: ArmSetting, scene: ArmScene, rng: np.random.Generator
) -> tuple[Passage | None, float]:
    a, b = setting.hands(scene.start_rad)[0][1], scene.goals[0].position_m
    radius = float(rng.uniform(0.03, 0.06))
    speed = float(rng.uniform(SLOWEST_M_S, FASTEST_M_S))
    begins_s = float(rng.uniform(0.0, LATEST_S))
    segments = np.vstack(
        [setting.moved_segments(scene.start_rad), setting.moved_segments(scene.goal_rad)]
    )
    radii = np.tile(setting.moved_radii, 2)
    for _ in range(50):
        across = line_axes(b - a, float(rng.uniform(0.0, 2.0 * np.pi)))[1]
        crossing = a + rng.uniform(0.3, 0.7) * (b - a)
        way = [crossing + s * HALF_WAY_M * across for s in np.linspace(-1.0, 1.0, 41)]
        near = min(float((point_segments(p, segments) - radii).min()) for p in way)
        if near - radius >= PASSING_CLEAR_M:
            ends_s = begins_s + 2.0 * HALF_WAY_M / speed
            return Passage(way[0], speed * across, begins_s, ends_s), radius
    return None, radius


class SwingCourse:
    """The left arm goes to and fro."""

    def __init__(self, scene: ArmScene, bodies: Array, period_s: float) -> None:
        """`bodies` (2, N): the whole body's joints at both ends of the swing."""
        self._seen = Seen(scene.goals, scene.obstacles)
        self._middle, self._half = 0.5 * bodies.sum(axis=0), 0.5 * (bodies[0] - bodies[1])
        self._rate = 2.0 * np.pi / period_s

    def __call__(self, tick: int) -> Moment:
        """What is so in this tick: the law is told where the arm is now, and how fast."""
        t = self._rate * tick * PERIOD_S
        after = t + self._rate * PERIOD_S
        seen = replace(
            self._seen,
            others_rad=self._middle + np.cos(t) * self._half,
            others_rad_s=-self._rate * np.sin(t) * self._half,
        )
        return Moment(seen, body_rad=self._middle + np.cos(after) * self._half)


def other_arm_scene(setting: ArmSetting, number: int, seed: int) -> tuple[ArmScene, Course]:
    """The left arm works beside the right one."""
    rng = np.random.default_rng([seed, 2002, number])
    joints = limb_joints(setting.robot, LEFT_ARM)
    limits = limb_limits(setting.robot, LEFT_ARM)
    left = [k for k, name in enumerate(joints) if name not in setting.joints]
    columns = [setting.body.joints.index(joints[k]) for k in left]
    hand = next(t for t in setting.body.tips if t not in setting.tips)
    for _ in range(MOST_TRIES):
        scene = make_scene(setting, "other arm", number, rng, lambda *_: [])
        a, b = setting.hands(scene.start_rad)[0][1], scene.goals[0].position_m
        for _ in range(200):
            q = rng.uniform(limits.lower_rad, limits.upper_rad)
            if limits.violation(q) > 0.0:
                continue
            ends = np.tile(setting.body_home_rad, (2, 1))
            ends[1, columns] = q[left]
            place = setting.referee.frame_pose(ends[1], hand)[1]
            near = point_segments(place, np.array([[a, b]]))[0]
            if near <= NEAR_LINE_M and _swing_is_clear(setting, scene, ends):
                return scene, SwingCourse(scene, ends, float(rng.uniform(*SWING_S)))
    raise NoSceneError("no swing of the left arm is clear")


def _swing_is_clear(setting: ArmSetting, scene: ArmScene, ends: Array) -> bool:
    """The right arm may stay at start and at goal through all of the swing."""
    for q in (scene.start_rad, scene.goal_rad):
        for share in np.linspace(0.0, 1.0, SWING_LOOKS):
            body = setting.whole(q, ends[0] + share * (ends[1] - ends[0]))
            if setting.referee.itself(body).distance_m < SWING_CLEAR_M:
                return False
    return True


def enclosed_scene(setting: ArmSetting, number: int, seed: int) -> tuple[ArmScene, Course]:
    """A goal in a cage that opens."""
    rng = np.random.default_rng([seed, 2003, number])

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        return [ball_near(rng, a, b, k) for k in range(STANDING)]

    for _ in range(MOST_TRIES):
        scene = make_scene(setting, "enclosed", number, rng, place)
        shell = scene.goals[0].position_m + CAGE_M * _directions(CAGE_BALLS)
        segments, radii = setting.moved_segments(scene.start_rad), setting.moved_radii
        near = min(float((point_segments(p, segments) - radii).min()) for p in shell)
        if near - CAGE_BALL_M < PASSING_CLEAR_M:
            continue
        cage = tuple(
            sphere(f"cage {k}", (x, y, z), CAGE_BALL_M)
            for k, (x, y, z) in enumerate(shell.tolist())
        )
        scene = replace(scene, obstacles=(*scene.obstacles, *cage))
        return scene, _opening(scene)
    raise NoSceneError("no cage is clear of the start")


def _opening(scene: ArmScene) -> Course:
    closed_m = np.array([one.position_m for one in scene.obstacles])
    open_m = closed_m.copy()
    open_m[STANDING:, 2] += GONE_M
    shut = Moment(Seen(scene.goals, scene.obstacles), closed_m, is_waiting=True)
    opened = Moment(Seen(scene.goals, scene.obstacles[:STANDING]), open_m)
    return lambda tick: shut if tick * PERIOD_S < OPENS_S else opened


def both_arms_scene(setting: ArmSetting, number: int, seed: int) -> ArmScene:
    """Two goals, crossing paths."""
    rng = np.random.default_rng([seed, 2004, number])

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        return [ball_near(rng, a, b, k) for k in range(BOTH_BALLS)]

    return make_scene(setting, "both arms", number, rng, place, accept=_cross)


def _cross(starts: Hands, goals: Hands) -> bool:
    lines = [a[1] + SAMPLES[:, None] * (b[1] - a[1]) for a, b in zip(starts, goals, strict=True)]
    apart = np.linalg.norm(lines[0][:, None] - lines[1][None, :], axis=2)
    return float(apart.min()) <= CROSSING_M


def _triple(values: Array) -> Triple:
    x, y, z = values.tolist()
    return x, y, z


def _directions(count: int) -> Array:
    """Unit vectors, evenly over the sphere."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


class SwitchCourse:
    """Another goal in the middle of a motion."""

    def __init__(self, first: ArmScene, scene: ArmScene) -> None:
        self._before = Moment(Seen(first.goals, scene.obstacles), is_waiting=True)
        self._after = Moment(Seen(scene.goals, scene.obstacles))

    def __call__(self, tick: int) -> Moment:
        """The first goal, then the scene's own."""
        return self._before if tick * PERIOD_S < SWITCH_S else self._after


def switch_scene(setting: ArmSetting, number: int, seed: int) -> tuple[ArmScene, Course]:
    """Two goals from the same start, among obstacles that leave all three clear."""
    rng = np.random.default_rng([seed, 2005, number])

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        return [ball_near(rng, a, b, k) for k in range(SWITCH_BALLS)]

    for _ in range(MOST_TRIES):
        scene = make_scene(setting, "switch", number, rng, place)
        first = make_scene(setting, "switch", number, rng, lambda *_: [])
        segments, radii = setting.moved_segments(first.goal_rad), setting.moved_radii
        near = min(
            float((point_segments(np.array(o.position_m), segments) - radii).min()) - o.size_m[0]
            for o in scene.obstacles
        )
        if near >= CLEAR_M:
            return scene, SwitchCourse(first, scene)
    raise NoSceneError("no two goals")
