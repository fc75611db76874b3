"""Figure 6: the same balls for both fields, and a hand behind each virtual point."""

from pathlib import Path

import numpy as np
import pytest

from services.config import load_robot
from services.experiments.cartesian.arm import Arm
from services.experiments.field_figures.fig6 import (
    BETTER,
    DFORC,
    EXPLANATION,
    LIMB,
    ROBOT,
    Run,
    both_fields,
    dforc_fig6,
    figure_rows,
)
from services.experiments.field_figures.fig6_arm import PerfectArm
from services.experiments.field_figures.fig6_draw import fig6_scene


def test_the_hand_follows_a_still_point_to_where_it_is() -> None:
    start = fig6_scene(np.random.default_rng(0)).target_m[0]
    hand = PerfectArm(Arm(load_robot(ROBOT), LIMB, torso=True)).hand(np.tile(start, (20, 1)))
    np.testing.assert_allclose(hand, np.tile(start, (20, 1)), atol=1e-3)


def test_a_bare_point_is_not_called_by_the_mode_that_moves_an_arm() -> None:
    scene = fig6_scene(np.random.default_rng(0))
    run = Run(scene, scene.target_m, scene.target_m)
    names = {row.name.partition(":")[0] for row in figure_rows(BETTER, [run])}
    assert names == {"better point", "better point, hand"}
    assert "not mode ulna" in EXPLANATION
    ours = [row.bar for row in figure_rows("ulna on boards", [run])]
    assert ours == [row.bar for row in figure_rows(BETTER, [run])]
    assert "<= 0" in ours
    assert {row.bar for row in figure_rows(DFORC, [run])} == {""}


@pytest.mark.slow
def test_both_fields_see_the_same_balls() -> None:
    found = both_fields(5, 1, lambda _: None)
    paper, ours = found[DFORC][0], found[BETTER][0]
    assert paper.scene is ours.scene
    assert ours.measured[1].clearance_m > 0.0
    assert ours.measured[1].final_m < 0.005
    assert ours.measured[0].jerk_m_s3 < 0.2 * paper.measured[0].jerk_m_s3


@pytest.mark.slow
def test_writes_the_figure(tmp_path: Path) -> None:
    plot, table = tmp_path / "fig6.png", tmp_path / "fig6.json"
    assert dforc_fig6(seed=5, short=True, json=table, plot=plot) == 0
    assert plot.stat().st_size > 50_000
    assert table.stat().st_size > 1000
