"""Draws figure 5: five reaches, seen across the plane of the way and the obstacle."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from dforc.arrays import Matrix, Vector
from services.messages import Obstacle

SIGMAS = 3.0  # the band, either way
COLUMNS = 3
STRAIGHT_M = 1e-5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Panel:
    """One reach: paths (k, 3) [m] with name and colour; of several runs the hand's (r, k, 3)."""

    title: str
    start_m: Vector
    target_m: Vector
    paths: tuple[tuple[str, str, Matrix], ...]
    ball: Obstacle | None = None
    runs: Matrix | None = None


def draw(panels: Sequence[Panel], file: Path) -> None:
    """Write the figure as PNG (or what the file's ending asks for)."""
    rows = -(-len(panels) // COLUMNS)
    figure, grid = plt.subplots(rows, COLUMNS, figsize=(16, 5 * rows), layout="constrained")
    axes = list(grid.ravel())
    for axis, panel in zip(axes, panels, strict=False):
        _panel(axis, panel)
    for axis in axes[len(panels) :]:
        axis.axis("off")
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _panel(axis: Axes, panel: Panel) -> None:
    view = _view(panel)
    if panel.ball is not None:
        x, y = 100.0 * (view @ (np.array(panel.ball.centre_m) - panel.start_m))
        axis.add_patch(Circle((x, y), 100.0 * panel.ball.radius_m, color="tab:red", alpha=0.5))
    for name, colour, path in panel.paths:
        x, y = 100.0 * (view @ (path - panel.start_m).T)
        axis.plot(x, y, color=colour, lw=1.2, label=name)
    if panel.runs is not None:
        _runs(axis, view, panel.start_m, panel.runs)
    axis.plot(0.0, 0.0, "o", color="tab:blue", ms=5, label="start")
    x, y = 100.0 * (view @ (panel.target_m - panel.start_m))
    axis.plot(x, y, "*", color="tab:green", ms=12, label="target")
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("along the straight line [cm]")
    axis.set_ylabel("beside it [cm]")
    axis.set_title(panel.title, fontsize=10)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8)


def _runs(axis: Axes, view: Matrix, start_m: Vector, runs: Matrix) -> None:
    seen = 100.0 * np.einsum("ij,rkj->rki", view, runs - start_m)
    x, y = seen.mean(axis=0).T
    spread = SIGMAS * np.linalg.norm(seen.std(axis=0), axis=1)
    axis.fill_between(x, y - spread, y + spread, color="tab:blue", alpha=0.25, lw=0)
    largest_mm = 10.0 * float(spread.max()) / SIGMAS
    label = f"hand (plant), mean; sigma at most {largest_mm:.2f} mm"
    axis.plot(x, y, color="tab:blue", lw=1.8, label=label)


def _view(panel: Panel) -> Matrix:
    """Two unit vectors (2, 3): along the way, and across it where there is most to be seen."""
    along = panel.target_m - panel.start_m
    along = along / np.linalg.norm(along)
    path = panel.paths[0][2] if panel.runs is None else panel.runs[0]
    away = path - panel.start_m
    if panel.ball is not None:
        away = np.array([np.array(panel.ball.centre_m) - panel.start_m])
    across = away - np.outer(away @ along, along)
    farthest = across[int(np.argmax(np.linalg.norm(across, axis=1)))]
    if np.linalg.norm(farthest) < STRAIGHT_M:  # nothing to be seen: across the flattest axis
        axis = np.eye(3)[int(np.argmin(np.abs(along)))]
        farthest = axis - (axis @ along) * along
    return np.array([along, farthest / np.linalg.norm(farthest)])
