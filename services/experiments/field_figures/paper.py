"""The paper's force field against an independent reference, and what its own constants do.

K = 4 N/m, D = 8 Ns/m, every 10 ms; a ball of 2 cm with G = 8 N as in figure 5, without margin.
"""

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.field.force import (
    Ellipsoid,
    FieldParams,
    PointState,
    Rows,
    Target,
    Triple,
    ball,
    force,
    scene_of,
)
from dforc.field.kernel_force import Scene
from dforc.field.rollout import PERIOD_S, roll_out
from dforc.rotation import matrix
from services.experiments.rows import Row, at_least, at_most, within

POINTS = 100_000
OBSTACLES = 4
GOAL: Triple = (0.3, 0.0, 0.0)
START = PointState(position_m=(0.0, 0.0, 0.0))
NEAR_M = 0.005
LONG_STEPS = 6000
BESIDE = ball((0.22, 0.04, 0.0), 0.05)  # its tails reach the goal, the ball does not
IN_FRONT = ball((0.15, 0.0, 0.0), 0.02)
PAPER_FIG5 = FieldParams(gain_n=8.0)


def paper_rows(short: bool = False, seed: int = 0) -> list[Row]:
    """Every figure, with its bar."""
    free_s = _arrival_s(scene_of((Target(position_m=GOAL),), (), FieldParams()))
    return [
        at_most("force against the reference, 1e5 points", _worst_n(short, seed), "N", 1e-12),
        within("free reach of 30 cm, within 5 mm", free_s, "s", 7.78 - 1e-9, 7.80 + 1e-9),
        at_least("with tails: rests beside the target", _rest_mm(truncated=False), "mm", 5.0),
        at_most("truncated: rests beside the target", _rest_mm(truncated=True), "mm", 1e-3),
        at_least("exactly head-on: stays away from the target", _stuck_mm(), "mm", 100.0),
    ]


def _worst_n(short: bool, seed: int) -> float:
    rng = np.random.default_rng(seed)
    worst = 0.0
    for truncated in (True, False):
        params = FieldParams(truncated=truncated, margin_m=0.005)
        target = Target(position_m=GOAL)
        obstacles = [_random_ellipsoid(rng) for _ in range(OBSTACLES)]
        x = rng.uniform(-0.2, 0.2, (POINTS // 10 if short else POINTS, 3))
        v = 0.2 * rng.normal(size=x.shape)
        scene = scene_of((target,), obstacles, params)
        found = [
            force(PointState(position_m=(a, b, c), velocity_m_s=(d, e, f)), scene)
            for (a, b, c), (d, e, f) in zip(x.tolist(), v.tolist(), strict=True)
        ]
        expected = _reference(x, v, np.array(GOAL), obstacles, params)
        worst = max(worst, float(np.abs(np.array(found) - expected).max()))
    return worst


def _random_ellipsoid(rng: np.random.Generator) -> Ellipsoid:
    a, b, c = rng.uniform(-0.1, 0.1, 3).tolist()
    r, s, t = rng.uniform(0.02, 0.12, 3).tolist()
    p, q, w = matrix(rng.normal(size=3)).tolist()
    rows: Rows = (tuple(p), tuple(q), tuple(w))
    return Ellipsoid(centre_m=(a, b, c), semi_axes_m=(r, s, t), rotation=rows)


def _reference(
    x: Matrix, v: Matrix, goal: Vector, obstacles: list[Ellipsoid], params: FieldParams
) -> Matrix:
    """Eqs. 3 to 5 as printed, all points (k, 3) at once, with the inverse of the covariance."""
    total = params.stiffness_n_m * (goal - x) - params.damping_ns_m * v
    for item in obstacles:
        turn, radii = np.array(item.rotation), np.array(item.semi_axes_m) + params.margin_m
        away = x - np.array(item.centre_m)
        q = np.einsum("ki,ij,kj->k", away, np.linalg.inv(turn * radii**2 @ turn.T), away)
        size = params.gain_n * np.exp(-q)
        if params.truncated:
            size[q > 1.0] = 0.0
        total += (size / np.linalg.norm(away, axis=1))[:, None] * away
    return total


def _arrival_s(scene: Scene) -> float:
    path = roll_out(START, scene, LONG_STEPS).positions_m
    outside = np.flatnonzero(np.linalg.norm(path - np.array(GOAL), axis=1) > NEAR_M)
    return float(outside[-1] + 1) * PERIOD_S


def _rest_mm(*, truncated: bool) -> float:
    scene = scene_of((Target(position_m=GOAL),), (BESIDE,), FieldParams(truncated=truncated))
    return _left_mm(scene)


def _stuck_mm() -> float:
    return _left_mm(scene_of((Target(position_m=GOAL),), (IN_FRONT,), PAPER_FIG5))


def _left_mm(scene: Scene) -> float:
    last = roll_out(START, scene, LONG_STEPS).positions_m[-1]
    return 1e3 * float(np.linalg.norm(last - np.array(GOAL)))
