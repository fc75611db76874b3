"""Draws the comparisons of learners."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np

from dforc.arrays import Vector

FIRST_ROW = 20  # averages over fewer are noise
STYLES = {
    "RFRR 200": ("tab:blue", "-"),
    "RFRR 500": ("tab:cyan", "-"),
    "RFRR 1000": ("tab:purple", "-"),
    "KRR, static": ("tab:red", "-"),
    "KRR, refitted": ("tab:red", "--"),
    "persistence": ("black", ":"),
    "linear, incremental": ("tab:brown", ":"),
    "CAD + offset": ("tab:gray", "-"),
    "rigid bodies identified": ("tab:gray", "--"),
    "semi-parametric": ("tab:green", "-"),
    "semi-parametric, 1 s late": ("tab:green", "--"),
    "semi-parametric, 5 s late": ("tab:green", ":"),
}


class Drawn(Protocol):
    """A curve as it is drawn."""

    @property
    def name(self) -> str:
        """What the legend says."""
        ...

    @property
    def values(self) -> Vector:
        """One per row."""
        ...


def draw_fig7(curves: Sequence[Drawn], path: Path) -> None:
    """Average nMSE over the number of test samples."""
    figure, axes = plt.subplots(figsize=(10, 6), layout="constrained")
    for curve in curves:
        colour, line = STYLES.get(curve.name, ("tab:olive", "-"))
        rows = np.arange(1, len(curve.values) + 1)
        kept = rows >= FIRST_ROW
        label = f"{curve.name}: {curve.values[-1]:.4f}"
        axes.plot(rows[kept], curve.values[kept], color=colour, ls=line, lw=1.4, label=label)
    axes.set_yscale("log")
    axes.set_xlabel("test samples (28 a second)")
    axes.set_ylabel("nMSE, mean of six channels, average so far")
    axes.set_title("Wrench of the recorded right arm: predict, then update")
    axes.grid(visible=True, which="both", alpha=0.25)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="after all samples")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_fig6(
    errors: Mapping[str, tuple[Vector, Vector]], joints: Sequence[str], path: Path
) -> None:
    """Error per joint, a bar per learner: mean, and a standard deviation up and down."""
    figure, axes = plt.subplots(figsize=(12, 6), layout="constrained")
    width = 0.85 / len(errors)
    places = np.arange(len(joints))
    for index, (name, (mean, deviation)) in enumerate(errors.items()):
        axes.bar(
            places + (index - (len(errors) - 1) / 2) * width,
            mean,
            width,
            yerr=deviation if deviation.any() else None,
            label=f"{name}: {mean.mean():.3f}",
            capsize=2,
        )
    axes.set_yscale("log")
    axes.set_xticks(places, joints, rotation=20)
    axes.set_ylabel("nMSE on unseen motion")
    axes.set_title("Torques of a seven-joint arm with friction")
    axes.grid(visible=True, axis="y", which="both", alpha=0.25)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="mean of the joints")
    figure.savefig(path, dpi=110)
    plt.close(figure)
