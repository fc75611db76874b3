"""Figure 5: PMP's reaches (A to C) and DForC's (D, E) on the same targets, by the paper's numbers.

A to C are calculated; D and E go through the whole stack in virtual time, several plants.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console

from services.config import load_robot
from services.experiments.field_figures.fig5_plot import Panel, draw
from services.experiments.field_figures.fig5_scenes import (
    Figure5,
    figure_scenes,
    nearest_orientation_rad,
    stack_scene,
)
from services.experiments.field_figures.fig5_stack import StackReach, run_scenes
from services.experiments.field_figures.pmp import SETTINGS, path_of, pmp_rows
from services.experiments.field_figures.targets import dforc_targets_rows
from services.experiments.reporting import tell_motion, working
from services.experiments.rows import Row, at_most, publish
from services.robotfile.robot_tables import RobotFile

OTHERS, SHORT_OTHERS = 8, 0  # targets of each kind beside the figure's, with the first plant
RUNS, SHORT_RUNS = 10, 1
POSITION_MM, ORIENTATION_DEG = 2.0, 1.0

Report = Callable[[float, str], None]

EXPLANATION = """\
PMP: distance of the virtual hand from the target at the end, 200 targets a line on iCubGazeboV2_5,
bars: medians of the literature notes, a quarter either way. How the targets were drawn was not
published; here: mid-range, each arm joint up to 30 deg from home; edge, elbow bent by 15 to 25 deg
and wrist pitch or yaw at its upper limit. With the time base the way along an eigenvector of K J A
J' is left to (eps / (1 + eps))^l, at home l = 0.09, 0.90, 1.12: clamped joints are only part of it.
DForC: virtual point of eq. 3 and the stack's inverse kinematics on the same targets; then through
boards and CAN in virtual time, stiff, judged by the plant, figures of the worst run."""


def dforc_fig5(
    *,
    robot: str = "icub:reach",
    seed: int = 0,
    runs: int = RUNS,
    short: bool = False,
    json: Path | None = None,
    plot: Path = Path("dforc-fig5.png"),
) -> int:
    """The table and the plot; 0 when every bar holds."""
    console = Console()
    loaded = load_robot(robot)
    with working(console, f"figure 5, seed {seed}") as tell:
        rows = pmp_rows(short, seed)
        rows += dforc_targets_rows(short, seed, tell)
        shown = figure_scenes(loaded, seed, SHORT_OTHERS if short else OTHERS)
        plants = range(seed, seed + (SHORT_RUNS if short else runs))
        reaches = stack_reaches(loaded, shown, plants, lambda s: partial(tell_motion, tell, s))
    rows += stack_rows(loaded, reaches)
    draw(panels(shown, reaches), plot)
    status = publish(f"DForC figure 5, seed {seed}", rows, json)
    console.print(EXPLANATION)
    console.print(f"plot: {plot}")
    return status


def stack_reaches(
    robot: RobotFile,
    shown: Figure5,
    plants: Sequence[int],
    report: Callable[[int], Report] | None = None,
) -> list[StackReach]:
    """D and E on every plant, and the other targets on the first one."""
    found = []
    for plant in plants:
        scenes = [shown.free, shown.blocked]
        if plant == plants[0]:
            scenes += [stack_scene(f"{kind} target", target) for kind, target in shown.others]
        found += run_scenes(robot, scenes, plant, None if report is None else report(plant))
    return found


def stack_rows(robot: RobotFile, reaches: Sequence[StackReach]) -> list[Row]:
    """Bars on the worst of each scene."""
    rows = []
    for name in dict.fromkeys(reach.scene.name for reach in reaches):
        of_name = [reach for reach in reaches if reach.scene.name == name]
        what = f"stack, {name}, {len(of_name)} reaches"
        rows += _rows_of(what, robot, of_name)
    return rows


def _rows_of(what: str, robot: RobotFile, reaches: Sequence[StackReach]) -> list[Row]:
    error_mm = 1e3 * max(reach.error_m for reach in reaches)
    excess_deg = math.degrees(max(_excess_rad(robot, reach) for reach in reaches))
    worst_deg = math.degrees(max(reach.error_rad for reach in reaches))
    crossed = float(sum(reach.violations for reach in reaches))
    rows = [
        at_most(f"{what}: position error", error_mm, "mm", POSITION_MM),
        Row(f"{what}: orientation error", worst_deg, "deg"),
        at_most(f"{what}: the same beyond what is attainable", excess_deg, "deg", ORIENTATION_DEG),
        at_most(f"{what}: ticks beyond a joint's range", crossed, "", 0.0),
    ]
    if reaches[0].scene.ball is not None:
        point_mm = 1e3 * min(reach.clearance_m(reach.point_m) for reach in reaches)
        hand_mm = 1e3 * min(reach.clearance_m(reach.hand_m) for reach in reaches)
        rows.append(Row(f"{what}: virtual point from the ball's surface", point_mm, "mm"))
        rows.append(Row(f"{what}: hand from the ball's surface", hand_mm, "mm"))
    if len(reaches) > 1:
        rows.append(Row(f"{what}: standard deviation, largest", 1e3 * band_m(reaches), "mm"))
    return rows


def band_m(reaches: Sequence[StackReach]) -> float:
    """Largest standard deviation of the hand's path over the runs."""
    paths = np.array([reach.path_m for reach in reaches])
    return float(np.linalg.norm(paths.std(axis=0), axis=1).max())


def panels(shown: Figure5, reaches: Sequence[StackReach]) -> list[Panel]:
    """The five panels of the figure."""
    drawn = [_pmp_panel(shown, *panel) for panel in PMP_PANELS]
    for scene, title in ((shown.free, "D: DForC"), (shown.blocked, "E: DForC, obstacle")):
        own = [reach for reach in reaches if reach.scene.name == scene.name]
        drawn.append(
            Panel(
                title=f"{title}, {len(own)} runs",
                start_m=shown.arm.home_m,
                target_m=np.array(scene.target_m),
                ball=scene.ball,
                paths=(("virtual point", "tab:green", np.array(own[0].point_m)),),
                runs=np.array([reach.path_m for reach in own]),
            )
        )
    return drawn


# Title, whether it is the target at the edge and with the ball, and the settings with colours.
PMP_PANELS = (
    ("A: PMP (paper: 4 mm)", False, False, (("A", "tab:blue"),)),
    (
        "B: PMP at the edge (paper: 3 cm, 5 cm, diverges)",
        True,
        False,
        (("B blue", "tab:blue"), ("B black", "black"), ("B raw", "tab:green")),
    ),
    ("C: PMP, obstacle (paper: target missed)", True, True, (("C", "tab:blue"),)),
)


def _pmp_panel(
    shown: Figure5,
    title: str,
    at_edge: bool,
    with_ball: bool,
    lines: tuple[tuple[str, str], ...],
) -> Panel:
    target = shown.hard if at_edge else shown.easy
    paths = []
    for key, colour in lines:
        setting = next(s for s in SETTINGS if s.key == key)
        obstacle = shown.obstacle if with_ball else None
        path = path_of(shown.arm, setting.params, target, obstacle, setting.seconds)
        left_mm = 1e3 * float(np.linalg.norm(path[-1] - target.position_m))
        paths.append((f"{key}: {left_mm:.0f} mm left", colour, path))
    return Panel(
        title=title,
        start_m=shown.arm.home_m,
        target_m=target.position_m,
        ball=shown.ball if with_ball else None,
        paths=tuple(paths),
    )


def _excess_rad(robot: RobotFile, reach: StackReach) -> float:
    """By how much the orientation is missed beyond what the arm can attain there."""
    if reach.error_rad <= math.radians(ORIENTATION_DEG):
        return 0.0
    return max(0.0, reach.error_rad - nearest_orientation_rad(robot, reach.scene))
