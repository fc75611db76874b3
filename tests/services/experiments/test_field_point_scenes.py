"""Scenes of balls for a bare point, and what the two fields make of them."""

import numpy as np
import pytest

from services.experiments.field_scenes.point_draw import (
    CLEAR_M,
    FAMILIES,
    hard_scene,
    random_scene,
)
from services.experiments.field_scenes.point_scenes import PointRunner, point_scene_rows


def test_balls_leave_start_and_goal_free() -> None:
    for number in range(50):
        scene = random_scene(np.random.default_rng(number), 5)
        for end in (scene.start_m, scene.goal_m):
            assert min(np.linalg.norm(c - end) - r for c, r in scene.balls) >= CLEAR_M


def test_the_same_seed_draws_the_same_scene() -> None:
    first, again = (random_scene(np.random.default_rng(3), 2) for _ in range(2))
    np.testing.assert_array_equal(first.goal_m, again.goal_m)
    np.testing.assert_array_equal(first.balls[1][0], again.balls[1][0])


@pytest.mark.parametrize("family", [name for name in FAMILIES if name != "ring"])
def test_hard_scenes_are_in_the_way_of_the_papers_field(family: str) -> None:
    runner = PointRunner()
    scenes = [hard_scene(np.random.default_rng(number), family) for number in range(10)]
    assert sum(runner.paper(scene).is_good for scene in scenes) <= 5


@pytest.mark.slow
def test_the_better_field_reaches_and_touches_nothing() -> None:
    rows = point_scene_rows(short=True, seed=11)
    assert len(rows) == 9 * 6
    assert [row.name for row in rows if row.holds is False] == []
