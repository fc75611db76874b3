"""A bare point among balls: the better field and the paper's on the same scenes."""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.collision.kernel_shapes import world_distance
from dforc.collision.obstacles import World, world_of
from dforc.compiled import compiled
from dforc.field.force import FieldParams, Target, ball, scene_of
from dforc.field.kernel_force import Scene
from dforc.field.kernel_force import advance as move_by_force
from dforc.field.point import PointParams, law_of, new_point, put
from dforc.field.point_kernel import Law, Point, step
from services.experiments.field_scenes.point_draw import (
    FAMILIES,
    PointScene,
    hard_scene,
    random_scene,
)
from services.experiments.rows import Row, at_least, at_most

COUNTS = (1, 2, 5, 10)
SCENES, SHORT_SCENES = 1000, 20
HARD_SCENES, SHORT_HARD = 50, 4
REACHED_PERCENT = {1: 99.9, 2: 99.9, 5: 99.9, 10: 99.5}
PERIOD_S = 0.01
STEPS = 2000
STAY_STEPS = 100  # after the goal is reached: it must not be left through something
WITHIN_M = 0.005
MOST_BALLS = 64


@dataclass(frozen=True)
class Outcome:
    """What became of one scene."""

    reached_s: float  # inf if it was not
    clearance_m: float  # the smallest; negative inside a ball

    @property
    def is_good(self) -> bool:
        """Reached, and nothing touched."""
        return self.reached_s < np.inf and self.clearance_m >= 0.0


@compiled
def roll_field(
    point: Point, goal: Vector, world: World, law: Law, dt: float, steps: int, stay: int
) -> tuple[float, float]:
    """When the goal is reached [s], and the smallest distance from any ball [m]."""
    still = np.zeros(3)
    least, when = np.inf, np.inf
    left = steps
    while left > 0:
        left -= 1
        step(point, goal, still, world, law, dt)
        least = min(least, world_distance(point.x, world))
        if when == np.inf and _apart(point.x, goal) < WITHIN_M:
            when = (steps - left) * dt
            left = min(left, stay)
    return when, least


@compiled
def roll_paper(
    x: Vector, scene: Scene, goal: Vector, world: World, dt: float, steps: int
) -> tuple[float, float]:
    """As roll_field, of the paper's force."""
    v, force = np.zeros(3), np.zeros(3)
    least = np.inf
    for i in range(steps):
        move_by_force(x, v, scene, dt, force)
        least = min(least, world_distance(x, world))
        if _apart(x, goal) < WITHIN_M:
            return (i + 1) * dt, least
    return np.inf, least


@compiled
def _apart(a: Vector, b: Vector) -> float:
    total = 0.0
    for k in range(3):
        total += (a[k] - b[k]) ** 2
    return float(np.sqrt(total))


class PointRunner:
    """Runs scenes with both fields, one room for all."""

    def __init__(self, params: PointParams | None = None) -> None:
        self._params = params or PointParams()
        self._law = law_of(self._params)
        self._point = new_point(self._params, MOST_BALLS)
        self._paper = FieldParams()

    def field(self, scene: PointScene) -> Outcome:
        """The better field."""
        put(self._point, scene.start_m, np.zeros(3))
        world = world_of(scene.obstacles())
        return Outcome(
            *roll_field(self._point, scene.goal_m, world, self._law, PERIOD_S, STEPS, STAY_STEPS)
        )

    def paper(self, scene: PointScene) -> Outcome:
        """The paper's, with its constants and no margin."""
        x, y, z = scene.goal_m.tolist()
        balls = [ball(tuple(c.tolist()), r) for c, r in scene.balls]
        forces = scene_of([Target(position_m=(x, y, z))], balls, self._paper)
        world = world_of(scene.obstacles())
        return Outcome(
            *roll_paper(scene.start_m.copy(), forces, scene.goal_m, world, PERIOD_S, STEPS)
        )


def point_scene_rows(short: bool, seed: int = 0) -> list[Row]:
    """Random scenes and hard families, both fields."""
    runner = PointRunner()
    rows: list[Row] = []
    for count in COUNTS:
        rng = np.random.default_rng([seed, count])
        scenes = [random_scene(rng, count) for _ in range(SHORT_SCENES if short else SCENES)]
        rows += _rows(f"point, {count} balls", runner, scenes, REACHED_PERCENT[count])
    for number, family in enumerate(FAMILIES):
        rng = np.random.default_rng([seed, 100 + number])
        scenes = [hard_scene(rng, family) for _ in range(SHORT_HARD if short else HARD_SCENES)]
        rows += _rows(f"point, {family}", runner, scenes, 100.0)
    return rows


def _rows(name: str, runner: PointRunner, scenes: list[PointScene], bar: float) -> list[Row]:
    ours = [runner.field(scene) for scene in scenes]
    papers = [runner.paper(scene) for scene in scenes]
    times = [one.reached_s for one in ours if one.is_good]
    return [
        at_least(f"{name}: reached, nothing touched", _percent(ours), "%", bar),
        at_most(f"{name}: touched", float(sum(o.clearance_m < 0.0 for o in ours)), "scenes", 0.0),
        Row(f"{name}: smallest clearance", 1e3 * min(o.clearance_m for o in ours), "mm"),
        Row(f"{name}: time to 5 mm, median", float(np.median(times)) if times else None, "s"),
        Row(f"{name}: paper's field, reached, nothing touched", _percent(papers), "%"),
        Row(
            f"{name}: paper's field, touched",
            100.0 * float(np.mean([o.clearance_m < 0.0 for o in papers])),
            "%",
        ),
    ]


def _percent(outcomes: list[Outcome]) -> float:
    return 100.0 * float(np.mean([one.is_good for one in outcomes]))
