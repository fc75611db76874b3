"""The figure of the Cartesian experiment: paths of the hand, and its speed over time."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from dforc.arrays import Matrix
from services.experiments.cartesian.course import PERIOD_S
from services.experiments.cartesian.figures import Run
from services.experiments.cartesian.metrics import minimum_jerk

PLANTS = ("ideal", "lagged", "boards")
TITLES = {"ideal": "ideal arm", "lagged": "lagging arm", "boards": "boards and CAN"}
COLOURS = {
    "ulna": "C0",
    "reference": "C1",
    "vite": "C2",
    "vite-loop": "C4",
    "dls": "C3",
}
SHOWN_S = 4.0  # of a move


def draw(runs: Sequence[Run], path: Path) -> None:
    """Write the figure: a column for each arm. The first repetition with the most joints."""
    plants = [plant for plant in PLANTS if any(run.plant == plant for run in runs)]
    figure, panels = plt.subplots(
        3, len(plants), figsize=(5.2 * len(plants), 13), layout="constrained", squeeze=False
    )
    for column, plant in enumerate(plants):
        chosen = _first([run for run in runs if run.plant == plant])
        moves = [run for run in chosen if run.course.moves]
        curves = [run for run in chosen if not run.course.moves]
        _paths(panels[0, column], moves)
        _speeds(panels[1, column], moves)
        _curves(panels[2, column], curves)
        panels[0, column].set_title(f"{TITLES[plant]}: there and back (dashed)")
        panels[2, column].set_title("lemniscate")
    for panel in panels.flat:
        panel.grid(visible=True, alpha=0.3)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], color="black", linestyle="--", linewidth=0.8))
    labels.append("asked for")
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    figure.suptitle(f"Cartesian controllers, right hand, {_joints(runs)} joints")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def _joints(runs: Sequence[Run]) -> int:
    return max((run.arm.degrees_of_freedom for run in runs), default=0)


def _first(runs: Sequence[Run]) -> list[Run]:
    """The first repetition of each controller and course, with the most joints."""
    most, seen = _joints(runs), set()
    chosen = []
    for run in runs:
        kind = (run.controller, run.course.name)
        if run.arm.degrees_of_freedom == most and kind not in seen:
            seen.add(kind)
            chosen.append(run)
    return chosen


def _paths(panel: Axes, runs: Sequence[Run]) -> None:
    """How far the hand leaves the straight line, there and back."""
    for run in runs:
        course, positions = run.course, run.hand[0]
        ends = (*course.moves[1:], course.periods)[:2]
        for begin, end, style in zip(course.moves, ends, ("-", "--"), strict=False):
            start, goal = positions[begin], course.position_m[begin]
            gone, way = positions[begin : end + 1] - start, goal - start
            share = gone @ way / (way @ way)
            off_mm = np.linalg.norm(gone - np.outer(share, way), axis=1) * 1e3
            label = run.controller if begin == 0 else None
            colour = COLOURS[run.controller]
            panel.plot(share * 100.0, off_mm, style, color=colour, lw=1.2, label=label)
    panel.set(xlabel="way [%]", ylabel="off the straight line [mm]")


def _speeds(panel: Axes, runs: Sequence[Run]) -> None:
    """Along the first move."""
    for run in runs:
        end = min(run.course.periods, round(SHOWN_S / PERIOD_S))
        speed = np.linalg.norm(np.diff(run.hand[0][: end + 1], axis=0), axis=1) / PERIOD_S
        at_s = (np.arange(end) + 0.5) * PERIOD_S
        panel.plot(at_s, speed, color=COLOURS[run.controller], lw=1.2)
    if runs:
        panel.plot(*_ideal_speed(runs[0]), "k--", lw=0.8)
    panel.set(
        title="speed of the first move", xlabel="time [s]", ylabel="speed [m/s]", xlim=(0, SHOWN_S)
    )


def _ideal_speed(run: Run) -> tuple[Matrix, Matrix]:
    """Of the minimum-jerk motion over the trajectory time."""
    way_m = float(np.linalg.norm(run.course.position_m[0] - run.hand[0][0]))
    time_s = run.course.trajectory_time_s
    at_s = np.linspace(0.0, time_s, 200)
    return at_s, way_m * np.gradient(minimum_jerk(at_s / time_s), at_s)


def _curves(panel: Axes, runs: Sequence[Run]) -> None:
    for run in runs:
        hand = run.hand[0]
        panel.plot(hand[:, 1], hand[:, 2], color=COLOURS[run.controller], lw=1.2)
    if runs:
        curve = runs[0].course.position_m
        panel.plot(curve[:, 1], curve[:, 2], "k--", lw=0.8)
    panel.set(xlabel="y [m]", ylabel="z [m]", aspect="equal")
    panel.set_adjustable("datalim")
