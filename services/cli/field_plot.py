"""Figure of previews: paths from above and from the side, distance and clearance over time."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from services.fields.messages import FieldInfo, Preview

mpl.use("Agg")

SIZE_INCHES = (11.0, 8.0)
PLANES = (("from above", 0, 1), ("from the side", 0, 2))
AXES = ("x m", "y m", "z m")


def draw_previews(found: list[Preview], info: FieldInfo, file: Path) -> None:
    """Write the figure."""
    figure = Figure(figsize=SIZE_INCHES, layout="constrained")
    axes = figure.subplots(2, 2)
    for panel, (title, across, up) in zip(axes[0], PLANES, strict=True):
        _draw_plane(panel, found, info, across, up)
        panel.set_title(title)
    for panel, name in zip(axes[1], ("goal_distance_m", "clearance_m"), strict=True):
        for one in found:
            times = [point.t_s for point in one.path]
            values = [1e3 * getattr(point, name) for point in one.path]
            panel.plot(times, np.where(np.isfinite(values), values, np.nan), label=one.mode)
        panel.set_xlabel("s")
        panel.set_ylabel(name.replace("_m", " mm").replace("_", " "))
        panel.legend()
    figure.savefig(file)


def _draw_plane(panel: Axes, found: list[Preview], info: FieldInfo, across: int, up: int) -> None:
    for source in info.sources:
        for item in source.objects:
            radius = max(item.size_m, default=0.0)
            centre = (item.position_m[across], item.position_m[up])
            panel.add_patch(mpl.patches.Circle(centre, radius, alpha=0.3))
            panel.annotate(item.name, centre)
    for one in found:
        place = np.array([point.position_m for point in one.path]).reshape(-1, 3)
        panel.plot(place[:, across], place[:, up], label=one.mode)
    panel.set_xlabel(AXES[across])
    panel.set_ylabel(AXES[up])
    panel.set_aspect("equal", adjustable="datalim")
    panel.legend()
