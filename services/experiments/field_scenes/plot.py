"""Draws the scenes of the force fields: what each law reaches and touches, and one scene."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d import Axes3D

from services.experiments.whole_arm.draw import ArmScene
from services.experiments.whole_arm.referee import Array
from services.experiments.whole_arm.run import Trace
from services.experiments.whole_arm.setting import ArmSetting

HANDS = {"dforc": "tab:red", "ulna": "tab:blue"}


def draw(
    kinds: Sequence[str],
    reached: Mapping[str, Sequence[float]],
    touched: Mapping[str, Sequence[float]],
    file: Path,
    example: "tuple[ArmSetting, ArmScene, Mapping[str, Trace]] | None" = None,
) -> None:
    """Two panels of percents by kind of scene and law; a third with one scene."""
    panels = 2 if example is None else 3
    figure = plt.figure(figsize=(6.5 * panels, 5), layout="constrained")
    for k, (values, title) in enumerate(
        ((reached, "reached 5 mm without contact [%]"), (touched, "touched something [%]"))
    ):
        _bars(figure.add_subplot(1, panels, k + 1), kinds, values, title)
    if example is not None:
        axis = figure.add_subplot(1, panels, 3, projection="3d")
        assert isinstance(axis, Axes3D)
        _scene(axis, *example)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _bars(
    axis: Axes, kinds: Sequence[str], values: Mapping[str, Sequence[float]], title: str
) -> None:
    width = 0.8 / max(1, len(values))
    for k, (law, percents) in enumerate(values.items()):
        places = np.arange(len(kinds)) + (k - 0.5 * (len(values) - 1)) * width
        axis.bar(places, percents, width, label=law)
    axis.set_xticks(np.arange(len(kinds)), kinds, rotation=30)
    axis.set_ylim(0, 105)
    axis.set_title(title)
    axis.grid(axis="y", alpha=0.3)
    axis.legend(fontsize=8)


def _scene(axis: Axes3D, setting: ArmSetting, scene: ArmScene, traces: Mapping[str, Trace]) -> None:
    """Obstacles, the arm where it starts and ends, and the hand's way by each law."""
    for obstacle in scene.obstacles:
        _ball(axis, np.array(obstacle.position_m), obstacle.size_m[0])
    for posture, colour in ((scene.start_rad, "tab:gray"), (scene.goal_rad, "tab:green")):
        for a, b in setting.moved_segments(posture):
            axis.plot(*np.array([a, b]).T, color=colour, lw=4, alpha=0.6)
    for law, trace in traces.items():
        way = np.array([setting.hands(q)[0][1] for q in trace.q_rad])
        axis.plot(*way.T, color=HANDS.get(law, "k"), lw=1.5, label=law)
    axis.set_title(f"{scene.family}, scene {scene.number}")
    axis.set_aspect("equal")
    axis.legend(fontsize=8)


def _ball(axis: Axes3D, centre: Array, radius: float) -> None:
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 17), np.linspace(0.0, np.pi, 9))
    directions = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    x, y, z = centre[:, None, None] + radius * directions
    axis.plot_surface(x, y, z, color="tab:orange", alpha=0.5)
