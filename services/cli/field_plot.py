"""Figure of previews: paths from above and from the side, distance and clearance over time."""

import itertools
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dforc.arrays import Matrix
from dforc.collision.obstacles import Obstacle, Shape
from services.fields.messages import FieldInfo, Preview
from services.fields.seen import solid_of

mpl.use("Agg")

SIZE_INCHES = (11.0, 8.0)
PLANES = (("from above", 0, 1), ("from the side", 0, 2))
AXES = ("x [m]", "y [m]", "z [m]")
OVER_TIME = (
    ("goal_distance_m", "distance to the goal [mm]"),
    ("clearance_m", "clearance [mm]"),
)
TURN = np.linspace(0.0, 2.0 * np.pi, 73)
ROUND = np.column_stack((np.cos(TURN), np.sin(TURN)))  # (k, 2)
CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def draw_previews(found: list[Preview], info: FieldInfo, file: Path) -> None:
    """Write the figure."""
    figure = Figure(figsize=SIZE_INCHES, layout="constrained")
    axes = figure.subplots(2, 2)
    for panel, (title, across, up) in zip(axes[0], PLANES, strict=True):
        _draw_plane(panel, found, info, across, up)
        panel.set_title(title)
    for panel, (name, label) in zip(axes[1], OVER_TIME, strict=True):
        for one in found:
            times = [point.t_s for point in one.path]
            values = [1e3 * getattr(point, name) for point in one.path]
            panel.plot(times, np.where(np.isfinite(values), values, np.nan), ".-", label=one.mode)
        panel.set_xlabel("time [s]")
        panel.set_ylabel(label)
        panel.legend()
    figure.savefig(file)


def _draw_plane(panel: Axes, found: list[Preview], info: FieldInfo, across: int, up: int) -> None:
    for source in info.sources:
        for item in source.objects:
            solid = solid_of(item)
            panel.add_patch(mpl.patches.Polygon(outline(solid, across, up), alpha=0.3))
            panel.annotate(item.name, (solid.position_m[across], solid.position_m[up]))
    for one in found:
        hands = [[point.position_m for point in one.path]]
        hands.append([p.second_position_m for p in one.path if p.second_position_m is not None])
        for label, hand in zip((one.mode, None), hands, strict=True):
            place = np.array(hand).reshape(-1, 3)
            panel.plot(place[:, across], place[:, up], ".-", label=label)
    panel.set_xlabel(AXES[across])
    panel.set_ylabel(AXES[up])
    panel.set_aspect("equal", adjustable="datalim")
    panel.legend()


def outline(solid: Obstacle, across: int, up: int) -> Matrix:
    """Of a solid's shadow on a plane of two of the base's axes (k, 2), m."""
    size = np.array(solid.size_m)
    turned = np.array(solid.rotation)[[across, up]]
    centre = np.array(solid.position_m)[[across, up]]
    if solid.shape in {Shape.SPHERE, Shape.ELLIPSOID}:
        semi_axes = size if solid.shape is Shape.ELLIPSOID else np.full(3, size[0])
        flattened = turned * semi_axes
        outermost = ROUND @ flattened  # on the unit ball, in each direction of the plane
        outermost /= np.linalg.norm(outermost, axis=1, keepdims=True)
        ellipse: Matrix = outermost @ flattened.T + centre
        return ellipse
    if solid.shape is Shape.BOX:
        surface = CORNERS * size
    else:
        rim = size[0] * ROUND
        ends = [np.column_stack((rim, np.full(len(rim), z))) for z in (-size[1], size[1])]
        surface = np.concatenate(ends)
    flat = surface @ turned.T + centre
    farthest: Matrix = flat[np.argmax(flat @ ROUND.T, axis=0)]
    return farthest
