"""Scenes for a whole arm: a posture to start from, a pose to go to, and what is in between.

    start      the limb's home posture, each joint up to 8 degrees off
    goal       a posture drawn at random within limits and rows; its hand's pose is what is asked
               for. The hand is 25 to 45 cm away in a straight line
    spheres    2 to 6 cm, centred near that line (normal, 4 cm each way)
    feasible   start and goal are clear of all of them by 15 mm, and of the body itself by 10 mm:
               a posture that reaches without touching exists. Whether a way to it does is open

The hard families stand on the same line: a ball head-on, two with a cusp between them, a wall, a
ring, and a cup that is open towards the start.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dforc.collision.obstacles import Obstacle, sphere
from services.experiments.whole_arm.referee import Array
from services.experiments.whole_arm.setting import ArmSetting

NEAR_HOME_RAD = np.radians(8.0)
SHORTEST_M, LONGEST_M = 0.25, 0.45
SMALLEST_M, LARGEST_M = 0.02, 0.06
BESIDE_M = 0.04
CLEAR_M, SELF_CLEAR_M = 0.015, 0.010
MOST_TRIES = 20_000
BALLS_PER_GOAL = 400  # draws of one goal's spheres before another goal is drawn

COUNTS = (1, 2, 5, 10)


@dataclass(frozen=True, eq=False)
class Goal:
    """Where one hand is to be."""

    position_m: Array  # (3,)
    rotation: Array  # (3, 3)


@dataclass(frozen=True, eq=False)
class ArmScene:
    """One task. Postures in the order of the limb's joints."""

    family: str  # "random 5", "wall", ...
    number: int
    obstacles: tuple[Obstacle, ...]
    start_rad: Array
    goal_rad: Array
    goals: tuple[Goal, ...]  # one per tip


class NoSceneError(RuntimeError):
    """So many draws gave no scene."""


Hands = list[tuple[Array, Array]]  # rotation and position of each
Place = Callable[[np.random.Generator, Array, Array], list[Obstacle]]
Accept = Callable[[Hands, Hands], bool]


def random_scene(setting: ArmSetting, count: int, number: int, seed: int) -> ArmScene:
    """`count` spheres near the line."""

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        return [ball_near(rng, a, b, k) for k in range(count)]

    rng = np.random.default_rng([seed, count, number])
    return make_scene(setting, f"random {count}", number, rng, place)


def family_scene(setting: ArmSetting, family: str, number: int, seed: int) -> ArmScene:
    """One of the hard families."""
    index = list(FAMILIES).index(family)
    rng = np.random.default_rng([seed, 1000 + index, number])
    balls = FAMILIES[family]

    def place(rng: np.random.Generator, a: Array, b: Array) -> list[Obstacle]:
        axes = line_axes(b - a, float(rng.uniform(0.0, 2.0 * np.pi)))
        middle = 0.5 * (a + b)
        return [
            sphere(f"{family} {k}", tuple((middle + axes.T @ at).tolist()), r)
            for k, (at, r) in enumerate(balls)
        ]

    return make_scene(setting, family, number, rng, place, one_by_one=False)


def make_scene(
    setting: ArmSetting,
    family: str,
    number: int,
    rng: np.random.Generator,
    place: Place,
    *,
    one_by_one: bool = True,
    accept: Accept | None = None,
) -> ArmScene:
    """Draw until everything is clear, and to the liking of `accept`.

    Obstacles that are in the way of start or goal are drawn again one by one, or with the goal.

    Raises:
        NoSceneError: there seems to be none.
    """
    start = near_home(setting, rng)
    at_start = setting.hands(start)
    taken = setting.moved_segments(start)
    for _ in range(MOST_TRIES):
        goal = setting.posture(rng)
        hands = setting.hands(goal)
        away = [float(np.linalg.norm(b[1] - a[1])) for a, b in zip(at_start, hands, strict=True)]
        if not all(SHORTEST_M <= d <= LONGEST_M for d in away):
            continue
        if accept is not None and not accept(at_start, hands):
            continue
        if setting.self_distance(goal) < SELF_CLEAR_M:
            continue
        side = int(rng.integers(len(hands)))  # whose way is in the way
        segments = np.vstack([taken, setting.moved_segments(goal)])
        balls = _clear_balls(
            setting, rng, place, segments, (at_start[side][1], hands[side][1]), one_by_one
        )
        if balls is not None:
            goals = tuple(Goal(p, R) for R, p in hands)
            return ArmScene(family, number, tuple(balls), start, goal, goals)
    raise NoSceneError(f"{family}, scene {number}: no scene in {MOST_TRIES} draws")


def _clear_balls(
    setting: ArmSetting,
    rng: np.random.Generator,
    place: Place,
    segments: Array,
    line: tuple[Array, Array],
    one_by_one: bool,
) -> list[Obstacle] | None:
    """Obstacles that leave both postures clear; those in the way are drawn again, or all fail."""
    radii = np.tile(setting.moved_radii, len(segments) // len(setting.moved))
    balls = place(rng, *line)
    for k in range(len(balls)):
        for _ in range(BALLS_PER_GOAL):
            centre, radius = np.array(balls[k].position_m), balls[k].size_m[0]
            if (point_segments(centre, segments) - radii - radius).min() >= CLEAR_M:
                break
            if not one_by_one:
                return None
            balls[k] = ball_near(rng, *line, k)
        else:
            return None
    return balls


def near_home(setting: ArmSetting, rng: np.random.Generator) -> Array:
    """A posture near the limb's home that is clear of itself."""
    for _ in range(MOST_TRIES):
        off = rng.uniform(-NEAR_HOME_RAD, NEAR_HOME_RAD, setting.n)
        q: Array = setting.home_rad + off
        if setting.limits.violation(q) <= 0.0 and setting.self_distance(q) >= SELF_CLEAR_M:
            return q
    raise NoSceneError("no posture near home is clear of itself")


def ball_near(rng: np.random.Generator, a: Array, b: Array, k: int) -> Obstacle:
    """A ball near the line from a to b, of 2 to 6 cm."""
    centre = a + rng.uniform() * (b - a) + rng.normal(0.0, BESIDE_M, 3)
    x, y, z = centre.tolist()
    return sphere(f"ball {k}", (x, y, z), float(rng.uniform(SMALLEST_M, LARGEST_M)))


def point_segments(point: Array, segments: Array) -> Array:
    """Distance of a point to each segment (k, 2, 3)."""
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length2 = np.maximum((along * along).sum(axis=1), 1e-18)
    share = np.clip(((point - a) * along).sum(axis=1) / length2, 0.0, 1.0)
    distances: Array = np.linalg.norm(a + share[:, None] * along - point, axis=1)
    return distances


def line_axes(along: Array, turned_rad: float) -> Array:
    """Rows: along the line, and two at right angles to it and each other."""
    u = along / np.linalg.norm(along)
    other = np.eye(3)[int(np.argmin(np.abs(u)))]
    v = np.cross(u, other)
    v /= np.linalg.norm(v)
    w = np.cross(u, v)
    c, s = np.cos(turned_rad), np.sin(turned_rad)
    return np.array([u, c * v + s * w, c * w - s * v])


def _grid(side: int, pitch: float) -> list[Array]:
    steps = pitch * (np.arange(side) - 0.5 * (side - 1))
    return [np.array([0.0, y, z]) for y in steps for z in steps]


def _circle(count: int, radius: float, along: float = 0.0) -> list[Array]:
    turns = 2.0 * np.pi * np.arange(count) / count
    return [np.array([along, radius * np.cos(t), radius * np.sin(t)]) for t in turns]


def _bowl(radius: float) -> list[Array]:
    """Half a sphere that is open towards the start."""
    found = [np.array([radius, 0.0, 0.0])]
    for turn_deg, count in ((25.0, 5), (50.0, 9), (75.0, 12)):
        turn = np.radians(turn_deg)
        found += _circle(count, radius * np.sin(turn), radius * np.cos(turn))
    return found


def _all(places: Sequence[Array], radius: float) -> list[tuple[Array, float]]:
    return [(place, radius) for place in places]


# Centres along the line and at right angles to it, from its middle; radii [m].
FAMILIES: dict[str, list[tuple[Array, float]]] = {
    "head-on": _all([np.zeros(3)], 0.05),
    "cusp": _all([np.array([0.0, 0.035, 0.0]), np.array([0.0, -0.035, 0.0])], 0.04),
    "wall": _all(_grid(5, 0.04), 0.025),
    "ring": _all(_circle(16, 0.12), 0.025),
    "cup": _all(_bowl(0.08), 0.02),
}
