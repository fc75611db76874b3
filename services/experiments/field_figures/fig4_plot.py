"""Draws figure 4: two paths that part, at a coarse step and at the paper's; drift over step."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d import Axes3D

from dforc.arrays import Matrix, Vector

PURPLE, BLACK, BLUE, GREEN = "#8e44ad", "#111111", "#1f6fd0", "#2e9e4f"  # as in the paper


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """One reach of variant A: its point and its arm's hand (k, 3), and the target (3,) [m]."""

    step_ms: float
    point_m: Matrix
    hand_m: Matrix
    target_m: Vector


def draw(drifts: Sequence[tuple[float, Vector]], examples: Sequence[Example], file: Path) -> None:
    """One panel for each example, and the drifts (k,) [m] of each step [ms]."""
    figure = plt.figure(figsize=(17, 5.5))
    columns = len(examples) + 1
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.12, top=0.92, wspace=0.3)
    for number, example in enumerate(examples):
        _paths(figure.add_subplot(1, columns, number + 1, projection="3d"), example)
    axis = figure.add_subplot(1, columns, columns)
    steps = [step_ms for step_ms, _ in drifts]
    values = [1e3 * found for _, found in drifts]
    axis.loglog(steps, [np.median(v) for v in values], "o-", color=PURPLE, label="median")
    axis.loglog(steps, [v.max() for v in values], "^--", color=PURPLE, label="largest")
    first = float(np.median(values[0])) / steps[0]
    axis.loglog(steps, [first * s for s in steps], ":", color=BLACK, label="first order")
    axis.set_xlabel("step [ms]")
    axis.set_ylabel("from the hand after 3 s [mm]")
    axis.set_title("drift of variant A, mid-range targets; variant B has none", fontsize=10)
    axis.grid(alpha=0.3, which="both")
    axis.legend()
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _paths(axis: Axes3D, example: Example) -> None:
    apart_mm = 1e3 * float(np.linalg.norm(example.point_m[-1] - example.hand_m[-1]))
    axis.plot(*(100.0 * example.point_m).T, color=PURPLE, label="integral of J dq (eq. 6)")
    axis.plot(*(100.0 * example.hand_m).T, color=BLACK, lw=1.0, label="kin of the arm (eq. 7)")
    axis.scatter(*(100.0 * example.point_m[0]), color=BLUE, label="start")
    axis.scatter(*(100.0 * example.target_m), color=GREEN, label="target")
    axis.set_xlabel("x [cm]")
    axis.set_ylabel("y [cm]")
    axis.set_zlabel("z [cm]")
    axis.set_title(f"step {example.step_ms:g} ms: {apart_mm:.1f} mm apart", fontsize=10)
    axis.legend(fontsize=8, loc="upper left")
