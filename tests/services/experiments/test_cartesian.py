"""The Cartesian experiment: its courses, its arms, its tables, and one short run of it all."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rich.console import Console

from services.config import load_robot
from services.core.errors import ConfigError
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.comparison import cartesian
from services.experiments.cartesian.controllers import CONTENDERS
from services.experiments.cartesian.course import (
    CENTRE_M,
    GAIN_M,
    PAIR,
    lemniscate,
    lemniscate_points,
    point_to_point,
)
from services.experiments.cartesian.figures import Run, judged, metrics_of, summed_up
from services.experiments.cartesian.plants import ideal, lagged
from services.experiments.cartesian.rows import Cell, all_rows, print_tables
from services.experiments.cartesian.runs import offline_runs

Matrix = NDArray[np.float64]


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(load_robot("icub:reach"), "right_arm", torso=True)


@pytest.fixture(scope="module")
def short_arm() -> Arm:
    return Arm(load_robot("icub:reach"), "right_arm", torso=False)


def test_the_lemniscate_is_bernoullis_at_constant_speed() -> None:
    points = lemniscate_points(3000)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.std() / steps.mean() < 1e-4
    # the whole curve of half width 1 is 5.24412 long
    assert steps.mean() * 3000 == pytest.approx(5.24412 * GAIN_M, rel=1e-3)
    y, z = ((points - CENTRE_M) / GAIN_M)[:, 1:].T
    assert (y**2 + z**2) ** 2 == pytest.approx(y**2 - z**2, abs=2e-3)
    assert (points[:, 0] == CENTRE_M[0]).all()


def test_the_lemniscate_begins_as_the_recorded_one() -> None:
    """Its second of a hundred points is (0.0371230, -0.0370211)."""
    second = (lemniscate_points(3000)[30] - CENTRE_M) / GAIN_M
    # that file's steps are a 99th of the curve: it holds both ends of every quarter
    assert second == pytest.approx([0.0, 0.0371, -0.0370], abs=6e-4)


def test_both_poses_are_within_reach_with_the_torso_and_one_is_not_without(
    arm: Arm, short_arm: Arm
) -> None:
    whole, less = point_to_point(arm, 2), point_to_point(short_arm, 2)
    assert arm.degrees_of_freedom == 10
    assert whole.given_up_m < 2e-4
    assert math.degrees(whole.given_up_rad) < 1.0
    assert short_arm.degrees_of_freedom == 7
    assert less.given_up_m < 2e-4
    assert 5.0 < math.degrees(less.given_up_rad) < 15.0
    assert (less.q_rad[:, :3] == 0.0).all()


def test_the_pair_is_taken_in_turn_from_the_second_pose(arm: Arm) -> None:
    course = point_to_point(arm, 3, dwell_s=2.0)
    assert course.moves == (0, 200, 400)
    assert course.periods == 600
    assert arm.pose(course.q_start_rad).position_m == pytest.approx(PAIR[1].position_m, abs=2e-4)
    for period, pose in ((0, PAIR[0]), (199, PAIR[0]), (200, PAIR[1]), (400, PAIR[0])):
        assert course.position_m[period] == pytest.approx(pose.position_m, abs=2e-4)


def test_the_lagging_arm_answers_a_step_after_its_delay_with_its_lag() -> None:
    steps: Matrix = np.concatenate([np.zeros((1, 200)), np.ones((40, 200))])
    angles = lagged(steps, 0.01, seed=1)
    assert (angles[:3] == 0.0).all()  # 20 ms
    # 1 - 1/e of the step after 20 ms and 60 ms: the mean of 200 joints with lags of 48 to 72 ms
    assert angles[8].mean() == pytest.approx(1.0 - math.exp(-1.0), abs=0.02)
    assert angles[8].std() > 0.01
    assert (ideal(steps) == steps).all()


@pytest.fixture(scope="module")
def cells(arm: Arm) -> list[Cell]:
    course = point_to_point(arm, 1, dwell_s=5.0)
    made = []
    for contender in CONTENDERS:
        runs = offline_runs(arm, course, contender, ("ideal", "lagged"), 2)
        for plant in ("ideal", "lagged"):
            figures = summed_up([judged(run) for run in runs if run.plant == plant])
            made.append(
                Cell(
                    course=course,
                    degrees_of_freedom=10,
                    plant=plant,
                    controller=contender.name,
                    figures=figures,
                )
            )
    return made


def figure(cells: list[Cell], plant: str, controller: str, key: str) -> float:
    (cell,) = [c for c in cells if c.plant == plant and c.controller == controller]
    return cell.figures[key].mean


def test_controllers_show_what_they_are_known_for(cells: list[Cell]) -> None:
    assert figure(cells, "ideal", "ulna", "perpendicular") < 0.5
    assert 10.0 < figure(cells, "ideal", "reference", "perpendicular") < 16.0
    assert figure(cells, "ideal", "vite", "jerk") == pytest.approx(26.0, abs=6.0)
    assert figure(cells, "ideal", "vite", "peak") == pytest.approx(0.17, abs=0.02)
    assert figure(cells, "ideal", "vite-loop", "t98_s") > figure(cells, "ideal", "vite", "t98_s")
    assert figure(cells, "ideal", "dls", "t98_s") == pytest.approx(4.1, abs=0.4)
    assert figure(cells, "ideal", "dls", "row_deg") > 0.1
    assert figure(cells, "ideal", "ulna", "row_deg") == 0.0


def test_this_projects_controller_keeps_its_bars(cells: list[Cell]) -> None:
    rows = all_rows(cells)
    held = [row for row in rows if row.holds is not None]
    assert all("ulna" in row.name for row in held)
    assert [row.name for row in held if not row.holds] == []
    assert any(row.name.startswith("ulna, all of it: shoulder or elbow row") for row in held)
    spreads = [row for row in rows if "confidence interval of 2" in row.name]
    assert len(spreads) == len(CONTENDERS) * len(metrics_of(cells[0].course))


def test_a_controller_that_crosses_a_row_fails_its_bar(arm: Arm) -> None:
    course = point_to_point(arm, 1, dwell_s=1.0)
    crossing = np.repeat(course.q_start_rad[None], course.periods + 1, axis=0)
    crossing[50:, 4] = 0.0  # shoulder roll: the arm would be in the torso
    run = Run(
        controller="ulna",
        plant="ideal",
        seed=0,
        arm=arm,
        course=course,
        references_rad=crossing[1:],
        angles_rad=crossing,
    )
    found = judged(run)
    assert found["row_deg"] == pytest.approx(26.4188 - 0.042735 * math.degrees(crossing[0, 5]))
    assert found["crossed"] == pytest.approx(100.0 * 51 / 101)
    cell = Cell(
        course=course,
        degrees_of_freedom=10,
        plant="ideal",
        controller="ulna",
        figures=summed_up([found]),
    )
    failed = [row.name for row in all_rows([cell]) if row.holds is False]
    assert "ulna, all of it: shoulder or elbow row crossed by" in failed


def test_tables_name_every_controller_and_put_the_prototype_beside(
    cells: list[Cell], capsys: pytest.CaptureFixture[str]
) -> None:
    print_tables(Console(), cells)
    shown = capsys.readouterr().out
    assert "point to point, 10 DoF, T = 2.5 s" in shown
    assert "every pose is within reach" in shown
    assert "lagging arm, n = 2" in shown
    for contender in CONTENDERS:
        assert contender.name in shown
    assert len(re.findall(r"prototype +│", shown)) == 7
    assert "off line: off the straight line" in " ".join(shown.split())


def test_the_lemniscate_is_followed_by_this_project_and_lost_by_damped_least_squares(
    arm: Arm,
) -> None:
    course = lemniscate(arm, loop_s=10.0)
    found = {}
    for contender in CONTENDERS:
        if contender.name in ("ulna", "dls"):
            (run,) = offline_runs(arm, course, contender, ("ideal",), 1)
            found[contender.name] = judged(run)["tracking_mm"]
    assert found["ulna"] < 0.2
    assert found["dls"] > 30.0


def test_a_run_writes_its_report_and_figure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report, plot = tmp_path / "rows.json", tmp_path / "paths.png"
    status = cartesian(
        plants=("ideal",), controllers=("ulna", "vite"), short=True, json=report, plot=plot
    )
    assert status == 0
    names = [row["name"] for row in json.loads(report.read_text())["rows"]]
    assert "point to point, 10 DoF, ideal arm, vite: 98 % of the way after" in names
    assert plot.read_bytes().startswith(b"\x89PNG")
    shown = capsys.readouterr().out
    assert "what this project's controller is held to" in shown


def test_refuses_plants_and_controllers_that_do_not_exist() -> None:
    with pytest.raises(ConfigError, match="there are: ideal, lagged, boards"):
        cartesian(plants=("gantry",))
    with pytest.raises(ConfigError, match="there are: ulna, reference, vite, vite-loop, dls"):
        cartesian(controllers=("pid",))
