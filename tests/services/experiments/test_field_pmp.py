"""PMP's targets, and its table on a few of them: what stays away, and what runs away."""

from pathlib import Path

import numpy as np
import pytest

from services.experiments.field_figures.fig4 import dforc_fig4, drift_rows
from services.experiments.field_figures.paper import paper_rows
from services.experiments.field_figures.pmp import SETTINGS, Outcome, run_setting, targets_of
from services.experiments.field_figures.pmp_arm import (
    HOME_DEG,
    MEASURED,
    OWN,
    PmpArm,
    arm_of,
    edge,
    mid_range,
    spread,
)
from services.experiments.field_figures.targets import reach

FEW = 40


@pytest.fixture(scope="module")
def arm() -> PmpArm:
    return arm_of(MEASURED)


def outcome(arm: PmpArm, key: str, count: int = FEW) -> Outcome:
    setting = next(s for s in SETTINGS if s.key == key)
    return run_setting(arm, setting, targets_of(arm, 0, count)[setting.at_edge], 0)


def test_latin_hypercube_fills_every_column_evenly() -> None:
    numbers = np.sort(spread(np.random.default_rng(1), 10, 3), axis=0)
    assert (np.arange(10) == np.floor(10.0 * numbers).T).all()


@pytest.mark.parametrize("urdf", [MEASURED, OWN])
def test_mid_range_targets_are_near_home_and_away_from_the_limits(urdf: str) -> None:
    arm = arm_of(urdf)
    q = np.degrees(mid_range(arm, np.random.default_rng(0), FEW))
    assert np.abs(q - np.array(HOME_DEG)).max() <= 30.0 + 1e-9
    assert (q[:, :3] == 0.0).all()
    assert (q >= np.degrees(arm.model.lower_rad) + 5.0 - 1e-9).all()
    assert (q <= np.degrees(arm.model.upper_rad) - 5.0 + 1e-9).all()


def test_edge_targets_have_a_stretched_elbow_and_one_wrist_joint_at_its_limit(
    arm: PmpArm,
) -> None:
    q = edge(arm, np.random.default_rng(0), FEW)
    assert np.degrees(q[:, 6]).min() >= 15.0 - 1e-9
    assert np.degrees(q[:, 6]).max() <= 25.0
    at_limit = q[:, 8:] == arm.model.upper_rad[8:]
    assert (at_limit.sum(axis=1) == 1).all()
    assert (at_limit.sum(axis=0) == FEW // 2).all()


def test_targets_come_again_with_their_seed(arm: PmpArm) -> None:
    first, again = (targets_of(arm, 3, 5)[True] for _ in range(2))
    other = targets_of(arm, 4, 5)[True]
    assert (first[0].q_rad == again[0].q_rad).all()
    assert (first[0].q_rad != other[0].q_rad).any()


def test_time_base_and_limit_fields_leave_the_target_unattained_and_patience_does_not(
    arm: PmpArm,
) -> None:
    medians = {key: outcome(arm, key).error_mm(50) for key in ("A", "A 30 s", "A fields")}
    assert medians["A 30 s"] < 4.0
    assert 8.0 < medians["A"] < 18.0
    assert 30.0 < medians["A fields"] < 60.0


def test_orientation_by_raw_difference_runs_away_and_by_the_logarithm_does_not(
    arm: PmpArm,
) -> None:
    raw, log = (outcome(arm, key, 20) for key in ("B raw", "B log"))
    assert raw.diverged > 20.0
    assert raw.error_mm(100) > 500.0
    assert log.diverged < 15.0


def test_obstacle_on_the_way_is_entered_by_two_millimetres_at_most(arm: PmpArm) -> None:
    depths = outcome(arm, "C").depths_m
    assert 0.0 < depths.max() < 0.003


def test_paper_s_field_holds_its_figures() -> None:
    rows = paper_rows(short=True)
    assert [row.name for row in rows if row.holds is not True] == []


def test_drift_is_of_first_order_and_variant_b_has_none() -> None:
    rows = {row.name: row for row in drift_rows(short=True)}
    assert rows["drift over step, slope of the logarithms"].holds
    assert rows["drift of variant B, largest"].holds
    largest = rows["drift of variant A at 10 ms, largest"].value
    assert isinstance(largest, float)
    assert 0.1 < largest < 2.0


def test_figure_4_writes_table_and_plot(tmp_path: Path) -> None:
    folder = tmp_path
    plot, file = folder / "fig4.png", folder / "fig4.json"
    assert dforc_fig4(short=True, json=file, plot=plot) == 0
    assert plot.stat().st_size > 20_000
    assert '"holds": true' in file.read_text(encoding="utf-8")


def test_dforc_attains_a_target_at_the_edge_with_its_orientation(arm: PmpArm) -> None:
    found = reach(arm, targets_of(arm, 0, 4)[True][0])
    assert found.error_m < 0.002
    assert np.degrees(found.error_rad) < 1.0
    assert found.outside_rad <= 0.0
