"""Whole-arm scenes in which something changes: what the law is told, and how it truly is."""

import numpy as np
import pytest

from services.experiments.whole_arm.courses import (
    GONE_M,
    OPENS_S,
    STANDING,
    Passage,
    both_arms_scene,
    enclosed_scene,
    other_arm_scene,
    passing_scene,
)
from services.experiments.whole_arm.jobs import setting_for
from services.experiments.whole_arm.setting import ArmSetting


@pytest.fixture(scope="module")
def setting() -> ArmSetting:
    return setting_for("passing")


def test_a_passage_begins_and_ends_at_rest() -> None:
    passage = Passage(np.zeros(3), np.array([0.2, 0.0, 0.0]), 1.0, 3.0)
    assert [passage.at(t)[0] for t in (0.0, 1.0, 2.0, 3.0, 9.0)] == pytest.approx(
        [0.0, 0.0, 0.2, 0.4, 0.4]
    )


def test_the_law_is_told_of_a_ball_with_noise_and_margin(setting: ArmSetting) -> None:
    scene, course = passing_scene(setting, 0, 0)
    told = [course(tick) for tick in range(100)][-1]
    assert told.centres_m is not None
    seen, true = np.array(told.seen.obstacles[0].position_m), told.centres_m[0]
    assert 0.0 < np.linalg.norm(seen - true) < 0.03
    assert 0.0 < told.seen.obstacles[0].margin_m < 0.03
    assert told.seen.obstacles[1:] == scene.obstacles[1:]


def test_the_cage_is_gone_when_it_opens(setting: ArmSetting) -> None:
    scene, course = enclosed_scene(setting, 0, 0)
    shut, opened = course(0), course(round(OPENS_S / 0.01))
    assert shut.is_waiting
    assert not opened.is_waiting
    assert opened.seen.obstacles == scene.obstacles[:STANDING]
    assert opened.centres_m is not None
    assert opened.centres_m[STANDING:, 2].min() > 0.9 * GONE_M


@pytest.mark.slow
def test_the_other_arm_keeps_off_start_and_goal() -> None:
    setting = setting_for("other arm")
    scene, course = other_arm_scene(setting, 0, 0)
    for tick in range(0, 800, 20):
        body = course(tick).body_rad
        assert body is not None
        for q in (scene.start_rad, scene.goal_rad):
            assert setting.referee.itself(setting.whole(q, body)).distance_m > 0.0


@pytest.mark.slow
def test_both_hands_have_lines_that_cross() -> None:
    setting = setting_for("both arms")
    scene = both_arms_scene(setting, 0, 0)
    assert len(scene.goals) == 2
    starts = setting.hands(scene.start_rad)
    ways = [
        a[1] + np.linspace(0, 1, 101)[:, None] * (g.position_m - a[1])
        for a, g in zip(starts, scene.goals, strict=True)
    ]
    assert np.linalg.norm(ways[0][:, None] - ways[1][None], axis=2).min() <= 0.1
