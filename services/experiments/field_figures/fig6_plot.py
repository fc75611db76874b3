"""The figure's right side: four trails of one run, for both fields, from the front and the side."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from services.experiments.field_scenes.moving_draw import OBSTACLE_M, PERIOD_S, MovingScene

Array = NDArray[np.float64]
Trails = tuple[str, Array, Array]  # title, virtual point and hand (k, 3)

OBSTACLE, TARGET, POINT, HAND = "tab:red", "tab:green", "tab:cyan", "tab:blue"
TARGET_M = 0.02  # radius of the green ball as drawn
ABOVE_M, BELOW_M = 0.14, 0.1  # of the target's way, that are shown


def draw(scene: MovingScene, trails: Sequence[Trails], path: Path) -> None:
    """Write the figure: a row for each field."""
    figure, panels = plt.subplots(
        len(trails), 3, figsize=(15, 5 * len(trails)), layout="constrained", squeeze=False
    )
    for row, (title, point, hand) in zip(panels, trails, strict=True):
        nearest = int(np.argmin(np.linalg.norm(hand - scene.obstacle_m, axis=1)))
        for panel, (across, name) in zip(row[:2], ((1, "y"), (0, "x")), strict=True):
            _trails(panel, scene, point, hand, across, nearest)
            panel.set(xlabel=f"{name} [m]", ylabel="z [m]", aspect="equal")
        row[0].set_title(f"{title}: from the front")
        row[1].set_title("from the side")
        _distances(row[2], scene, point, hand)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    figure.suptitle(
        "Following a moving ball past a descending one; 1: where the hand is nearest to it, 2: end"
    )
    figure.savefig(path, dpi=90)
    plt.close(figure)


def _trails(
    panel: Axes, scene: MovingScene, point: Array, hand: Array, across: int, nearest: int
) -> None:
    low = float(scene.target_m[:, 2].min()) - BELOW_M
    high = float(scene.target_m[:, 2].max()) + ABOVE_M
    seen = [
        (scene.seen_obstacle_m, OBSTACLE, "obstacle, as seen", 0.4),
        (scene.seen_target_m, TARGET, "target, as seen", 0.4),
        (point, POINT, "virtual point", 3.0),
        (hand, HAND, "hand", 1.0),
    ]
    for places, colour, label, width in seen:
        shown = places[(places[:, 2] > low) & (places[:, 2] < high)]
        panel.plot(shown[:, across], shown[:, 2], color=colour, lw=width, label=label)
    for number, i in enumerate((nearest, len(hand) - 1), start=1):
        for places, radius, colour in (
            (scene.obstacle_m, OBSTACLE_M, OBSTACLE),
            (scene.target_m, TARGET_M, TARGET),
        ):
            centre = places[i, across], places[i, 2]
            if low < centre[1] < high:
                panel.add_patch(Circle(centre, radius, color=colour, alpha=0.15 + 0.2 * number))
        panel.plot(hand[i, across], hand[i, 2], "o", color=HAND, ms=5)
        panel.annotate(
            f"{number}", (hand[i, across], hand[i, 2]), (4, 4), textcoords="offset points"
        )
    panel.set_ylim(low, high)
    panel.grid(visible=True, alpha=0.3)


def _distances(panel: Axes, scene: MovingScene, point: Array, hand: Array) -> None:
    t = PERIOD_S * np.arange(len(point))
    for places, colour in ((point, POINT), (hand, HAND)):
        away = 1e3 * np.linalg.norm(places - scene.target_m, axis=1)
        clear = 1e3 * (np.linalg.norm(places - scene.obstacle_m, axis=1) - OBSTACLE_M)
        panel.plot(t, away, color=colour, lw=1.2)
        panel.plot(t, clear, "--", color=colour, lw=1.2)
    panel.axhline(0.0, color="black", lw=0.8)
    panel.set(
        title="to the true target (-), to the obstacle (- -)",
        xlabel="time [s]",
        ylabel="[mm]",
        ylim=(-20.0, 220.0),
    )
    panel.grid(visible=True, alpha=0.3)
