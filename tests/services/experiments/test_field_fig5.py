"""Figure 5's scenes and rows, and the paper's field once through boards and CAN frames."""

from pathlib import Path

import numpy as np
import pytest

from services.config import load_robot
from services.experiments.field_figures.fig5 import band_m, panels, stack_reaches, stack_rows
from services.experiments.field_figures.fig5_plot import draw
from services.experiments.field_figures.fig5_scenes import Figure5, figure_scenes
from services.experiments.field_figures.fig5_stack import StackReach
from services.robotfile.robot_tables import RobotFile


@pytest.fixture(scope="module")
def robot() -> RobotFile:
    return load_robot("icub:reach")


@pytest.fixture(scope="module")
def shown(robot: RobotFile) -> Figure5:
    return figure_scenes(robot, 0, 1)


def made(shown: Figure5, seed: int, aside_m: float) -> StackReach:
    """A straight reach that ends where it should, moved aside on its way."""
    scene = shown.blocked
    share = np.linspace(0.0, 1.0, 101)[:, None]
    way = shown.arm.home_m + share * (np.array(scene.target_m) - shown.arm.home_m)
    bent = way + np.outer(np.sin(np.pi * share), [0.0, 0.0, aside_m])
    reach = StackReach(scene=scene, seed=seed)
    reach.hand_m = [(x, y, z) for x, y, z in bent.tolist()]
    reach.point_m = reach.hand_m
    reach.hand_rotation_rad = [scene.rotation_rad] * len(share)
    return reach


def test_the_ball_stands_a_centimetre_beside_the_straight_line(shown: Figure5) -> None:
    straight = made(shown, 0, 0.0)
    assert straight.clearance_m(straight.hand_m) == pytest.approx(0.01 - 0.02, abs=1e-4)


def test_band_is_the_standard_deviation_of_the_runs(shown: Figure5) -> None:
    reaches = [made(shown, 0, 0.03), made(shown, 1, 0.05)]
    assert band_m(reaches) == pytest.approx(0.01)


def test_rows_tell_a_hand_that_misses_and_a_joint_beyond_its_range(
    robot: RobotFile, shown: Figure5
) -> None:
    good, bad = made(shown, 0, 0.05), made(shown, 1, 0.05)
    assert all(row.holds is not False for row in stack_rows(robot, [good]))
    x, y, z = bad.hand_m[-1]
    bad.hand_m[-1] = (x, y, z + 0.0025)
    bad.violations = 3
    failed = {
        row.name.split(": ")[1] for row in stack_rows(robot, [good, bad]) if row.holds is False
    }
    assert failed == {"position error", "ticks beyond a joint's range"}


def test_five_panels_are_drawn(shown: Figure5, tmp_path: Path) -> None:
    free = made(shown, 0, 0.05)
    free.scene = shown.free
    drawn = panels(shown, [free, made(shown, 0, 0.05), made(shown, 1, 0.051)])
    assert [panel.title[0] for panel in drawn] == ["A", "B", "C", "D", "E"]
    draw(drawn, tmp_path / "fig5.png")
    assert (tmp_path / "fig5.png").stat().st_size > 30_000


@pytest.mark.slow
def test_paper_s_field_goes_round_the_ball_through_the_whole_stack(
    robot: RobotFile, shown: Figure5
) -> None:
    reaches = stack_reaches(robot, shown, [0])
    assert [row.name for row in stack_rows(robot, reaches) if row.holds is False] == []
    blocked = next(reach for reach in reaches if reach.scene.ball is not None)
    assert blocked.clearance_m(blocked.point_m) > -0.003
