"""A bare point follows a ball past another that falls: the better point's law and the paper's.

Both are told the same noisy places every 10 ms. The better point filters them; the paper's takes
them as they are. Neither is mode ulna, which moves an arm. The obstacle that counts for a touch is
the true one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix
from dforc.collision.obstacles import World, sphere, world_of
from dforc.compiled import compiled
from dforc.field.force import FieldParams, Target, ball, scene_of
from dforc.field.kernel_force import Scene
from dforc.field.kernel_force import advance as move_by_force
from dforc.field.point import PointParams, law_of, new_point, put
from dforc.field.point_kernel import Law, Point, step
from dforc.field.tracking import new_track
from dforc.field.tracking_kernel import Track, take
from services.experiments.field_scenes.moving_draw import (
    MOVES_S,
    NOISE_M,
    OBSTACLE_M,
    PERIOD_S,
    MovingScene,
    moving_scene,
)
from services.experiments.rows import Row, at_most

Array = NDArray[np.float64]

SPEEDS_M_S = (0.05, 0.15, 0.4)
RUNS, SHORT_RUNS = 500, 10
SIGMAS = 3.0  # margin for where the obstacle is
LAG_FROM_S = 2.0  # until the target stops
END_S = 1.0  # the final error is the mean over the last second
LAG_MM, FINAL_MM, JERK_SHARE = 30.0, 5.0, 0.2


@dataclass(frozen=True)
class Measured:
    """Figures of one run, in m and m/s^3."""

    clearance_m: float
    lag_m: float
    final_m: float
    jerk_m_s3: float


@compiled
def roll_field(
    point: Point,
    seen_target: Matrix,
    seen_obstacle: Matrix,
    tracks: tuple[Track, Track],
    covariance: Matrix,
    world: World,
    law: Law,
    dt: float,
    sigmas: float,
    places: Matrix,
) -> None:
    """Fill the point's places (k, 3), one for every sample; `world` holds the obstacle."""
    target, obstacle = tracks
    for i in range(len(seen_target)):
        take(target, i * dt, seen_target[i], covariance)
        take(obstacle, i * dt, seen_obstacle[i], covariance)
        variance = 0.0
        for k in range(3):
            world.centres[0, k], world.velocities[0, k] = obstacle.state[k], obstacle.state[3 + k]
            variance = max(variance, obstacle.P[k, k])
        world.margins[0] = sigmas * np.sqrt(variance)
        step(point, target.state[:3], target.state[3:], world, law, dt)
        places[i] = point.x


@compiled
def roll_paper(
    seen_target: Matrix, seen_obstacle: Matrix, scene: Scene, dt: float, places: Matrix
) -> None:
    """As roll_field, of the paper's force."""
    x, v, force = places[0].copy(), np.zeros(3), np.zeros(3)
    for i in range(len(seen_target)):
        scene.targets_m[0] = seen_target[i]
        if len(scene.centres_m) > 0:
            scene.centres_m[0] = seen_obstacle[i]
        move_by_force(x, v, scene, dt, force)
        places[i] = x


class MovingRunner:
    """Runs scenes with both fields, one room for all."""

    def __init__(self, params: PointParams | None = None, paper: FieldParams | None = None) -> None:
        self._params = params or PointParams()
        self._law = law_of(self._params)
        self._point = new_point(self._params, 1)
        self._paper = paper or FieldParams()

    def field(self, scene: MovingScene, noise_m: float = NOISE_M, obstacle: bool = True) -> Array:
        """Places of the better point."""
        put(self._point, scene.target_m[0], np.zeros(3))
        x, y, z = scene.seen_obstacle_m[0].tolist()
        if not obstacle:
            z = 100.0
        world = world_of([sphere("obstacle", (x, y, z), OBSTACLE_M)])
        seen = scene.seen_obstacle_m if obstacle else np.tile((x, y, z), (len(scene.target_m), 1))
        places = np.empty_like(scene.target_m)
        roll_field(
            self._point,
            scene.seen_target_m,
            seen,
            (new_track(), new_track()),
            max(noise_m, 1e-4) ** 2 * np.eye(3),
            world,
            self._law,
            PERIOD_S,
            SIGMAS,
            places,
        )
        return places

    def paper(self, scene: MovingScene, obstacle: bool = True) -> Array:
        """Places of the point in the paper's field."""
        x, y, z = scene.target_m[0].tolist()
        balls = [ball((x, y, z), OBSTACLE_M)] if obstacle else []
        forces = scene_of([Target(position_m=(x, y, z))], balls, self._paper)
        forces = forces._replace(
            targets_m=forces.targets_m.copy(), centres_m=forces.centres_m.copy()
        )
        places = np.empty_like(scene.target_m)
        places[0] = scene.target_m[0]
        roll_paper(scene.seen_target_m, scene.seen_obstacle_m, forces, PERIOD_S, places)
        return places


def measure(scene: MovingScene, places: Array) -> Measured:
    """Against the true balls."""
    away = np.linalg.norm(places - scene.target_m, axis=1)
    beside = np.linalg.norm(places - scene.obstacle_m, axis=1) - OBSTACLE_M
    jerk = np.diff(places, 3, axis=0) / PERIOD_S**3
    first, last = round(LAG_FROM_S / PERIOD_S), round(MOVES_S / PERIOD_S)
    return Measured(
        clearance_m=float(beside.min()),
        lag_m=float(away[first : last + 1].mean()),
        final_m=float(away[-round(END_S / PERIOD_S) :].mean()),
        jerk_m_s3=float(np.sqrt((jerk**2).sum(axis=1).mean())),
    )


def moving_rows(short: bool, seed: int = 0) -> list[Row]:
    """All speeds, both fields, on the same runs."""
    runner = MovingRunner()
    rows: list[Row] = []
    for number, speed in enumerate(SPEEDS_M_S):
        rng = np.random.default_rng([seed, 300 + number])
        scenes = [moving_scene(rng, speed) for _ in range(SHORT_RUNS if short else RUNS)]
        ours = [measure(scene, runner.field(scene)) for scene in scenes]
        free = [measure(scene, runner.field(scene, obstacle=False)) for scene in scenes]
        papers = [measure(scene, runner.paper(scene)) for scene in scenes]
        rows += _rows(f"moving, {speed:g} m/s", ours, free, papers)
    return rows


def _rows(
    name: str, ours: Sequence[Measured], free: Sequence[Measured], papers: Sequence[Measured]
) -> list[Row]:
    jerk, paper_jerk = _rms(ours), _rms(papers)
    lag, final = (1e3 * np.mean([getattr(o, f) for o in ours]) for f in ("lag_m", "final_m"))
    return [
        at_most(f"{name}: touched", float(sum(o.clearance_m < 0.0 for o in ours)), "runs", 0.0),
        Row(f"{name}: smallest clearance", 1e3 * min(o.clearance_m for o in ours), "mm"),
        at_most(f"{name}: mean distance from the target, 2 to 6 s", float(lag), "mm", LAG_MM),
        Row(f"{name}: the same without the obstacle", _mean_mm(free, "lag_m"), "mm"),
        at_most(f"{name}: final error, mean", float(final), "mm", FINAL_MM),
        Row(f"{name}: final error, largest", 1e3 * max(o.final_m for o in ours), "mm"),
        at_most(f"{name}: jerk, share of the paper's", jerk / paper_jerk, "", JERK_SHARE),
        Row(f"{name}: jerk, rms", jerk, "m/s^3"),
        Row(f"{name}: paper's field, jerk, rms", paper_jerk, "m/s^3"),
        Row(f"{name}: paper's field, touched", _percent_hit(papers), "%"),
        Row(f"{name}: paper's field, worst", 1e3 * min(o.clearance_m for o in papers), "mm"),
        Row(f"{name}: paper's field, mean distance, 2 to 6 s", _mean_mm(papers, "lag_m"), "mm"),
        Row(f"{name}: paper's field, final error, mean", _mean_mm(papers, "final_m"), "mm"),
    ]


def _rms(runs: Sequence[Measured]) -> float:
    return float(np.sqrt(np.mean([one.jerk_m_s3**2 for one in runs])))


def _mean_mm(runs: Sequence[Measured], field: str) -> float:
    return 1e3 * float(np.mean([getattr(one, field) for one in runs]))


def _percent_hit(runs: Sequence[Measured]) -> float:
    return 100.0 * float(np.mean([one.clearance_m < 0.0 for one in runs]))
