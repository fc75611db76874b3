"""The scene of a reach: what the seed draws and what the caller fixes."""

import numpy as np
import pytest

from services.reaching.reach_scene import BALL_OFFSET_M, BALL_RADIUS_M, draw_scene

START = np.array([-0.3, 0.2, 0.03])


@pytest.mark.parametrize("seed", range(20))
def test_ball_stands_in_the_way(seed: int) -> None:
    scene = draw_scene(START, seed)
    assert scene.ball_centre_m is not None
    target, centre = np.array(scene.target_m), np.array(scene.ball_centre_m)
    along = (target - START) / np.linalg.norm(target - START)
    foot = START + along * ((centre - START) @ along)
    assert BALL_OFFSET_M[0] <= np.linalg.norm(centre - foot) <= BALL_OFFSET_M[1] + 1e-12
    assert 0.15 < np.linalg.norm(target - START) < 0.25
    assert scene.ball_radius_m == BALL_RADIUS_M


def test_same_seed_same_scene_and_other_seed_another() -> None:
    assert draw_scene(START, 3) == draw_scene(START, 3)
    assert draw_scene(START, 3) != draw_scene(START, 4)


def test_a_given_target_does_not_change_how_the_ball_is_drawn() -> None:
    drawn = draw_scene(START, 5)
    given = draw_scene(START, 5, target_m=drawn.target_m)
    assert given == drawn


def test_given_ball_is_kept() -> None:
    scene = draw_scene(START, 0, ball=(-0.4, 0.1, 0.0, 0.03))
    assert scene.ball_centre_m == (-0.4, 0.1, 0.0)
    assert scene.ball_radius_m == 0.03
