"""Going along a path of postures, and noticing that nothing happens."""

import numpy as np
import pytest

from dforc.virtual_arm.progress import Progress
from dforc.virtual_arm.way import LEAD_RAD, SHARE, Way

PATH = np.array([[0.0, 0.0], [0.6, 0.0], [0.6, 0.3]])
SPEEDS = np.array([1.0, 1.0])
PERIOD_S = 0.01


def test_leads_to_the_end_at_a_share_of_the_joints_speeds() -> None:
    way, q = Way(PATH, SPEEDS), PATH[0].copy()
    fastest, steps = 0.0, 0
    while not way.is_at_end(q) and steps < 1000:
        wanted = way.wanted(q, 1.0, PERIOD_S)
        fastest = max(fastest, float(np.abs(wanted).max()))
        q += PERIOD_S * wanted
        steps += 1
    assert way.is_at_end(q)
    assert SHARE * 0.9 <= fastest <= SHARE * 1.2
    assert 0.9 / SHARE <= steps * PERIOD_S <= 2.5 * 0.9 / SHARE


def test_the_point_waits_for_a_posture_that_does_not_move() -> None:
    way = Way(PATH, SPEEDS)
    for _ in range(500):
        way.wanted(PATH[0], 1.0, PERIOD_S)
    assert way.at * 0.6 < LEAD_RAD
    assert way.left_rad(PATH[0]) == pytest.approx(0.9)


def test_half_the_share_is_half_the_speed() -> None:
    whole, half = Way(PATH, SPEEDS), Way(PATH, SPEEDS)
    np.testing.assert_allclose(
        half.wanted(PATH[0], 0.5, PERIOD_S), 0.5 * whole.wanted(PATH[0], 1.0, PERIOD_S), rtol=0.05
    )


def test_a_path_of_one_posture_is_at_its_end() -> None:
    way = Way(PATH[:1], SPEEDS)
    assert way.is_at_end(PATH[0])
    assert way.left_rad(PATH[0]) == 0.0


def test_is_stuck_only_after_the_window_and_not_while_it_moves() -> None:
    progress = Progress(0.4)
    for _ in range(39):
        progress.note(0.0, 1.0, PERIOD_S)
    assert not progress.is_stuck
    progress.note(0.0, 1.0, PERIOD_S)
    progress.note(0.0, 1.0, PERIOD_S)
    assert progress.is_stuck
    for _ in range(40):
        progress.note(1.0, 1.0, PERIOD_S)
    assert progress.is_advancing
    progress.restart()
    assert not progress.is_stuck
