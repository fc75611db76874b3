"""Draws solvers of inverse kinematics: how often they are right against how long they take."""

from collections.abc import Mapping
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np

from services.experiments.ik.measure import LOOSE_M, percent
from services.experiments.ik.poses import COLD, ORIENTATION, POSITION, Sample

MARKERS = ("o", "*")  # others, ours
EMPTY = "empty call"
TITLES = {
    COLD: "reachable: 1 mm, limits, best objective",
    ORIENTATION: "orientation out of reach: 1 mm, limits, within 0.5 deg",
    POSITION: "position out of reach: limits, within 1 mm of nearest",
}


def draw(samples: Mapping[str, Sample], file: Path) -> None:
    """Three panels; each solver is a bar from its median to its p99."""
    figure, axes = plt.subplots(1, len(TITLES), figsize=(15, 5), layout="constrained", sharey=True)
    names = [name for name in samples[COLD].runs if name != EMPTY]
    colours = dict(zip(names, plt.get_cmap("tab20")(np.linspace(0, 1, len(names))), strict=True))
    for axis, (which, title) in zip(axes, TITLES.items(), strict=True):
        sample = samples[which]
        for name in names:
            right = _right(sample, name)
            run = sample.runs[name]
            low, high = run.ms_at(50), run.ms_at(99)
            axis.plot([low, high], [right, right], color=colours[name], lw=1.5, alpha=0.6)
            axis.plot([low], [right], MARKERS[name[:4] == "ours"], color=colours[name], label=name)
        axis.set_xscale("log")
        axis.set_xlabel("median .. p99 [ms]")
        axis.set_title(title, fontsize=9)
        axis.set_ylim(-4, 104)
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("right [%]")
    axes[-1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5), fontsize=8)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _right(sample: Sample, name: str) -> float:
    w = sample.worths[name]
    if sample.name == ORIENTATION:
        return percent(w.loosely_feasible() & (np.degrees(sample.excess(name)) <= 0.5))
    if sample.name == POSITION:
        near = sample.excess(name) <= LOOSE_M
        return percent(near & (w.outside_rad <= 1e-5))
    return percent(w.loosely_feasible() & w.optimal(sample.targets.best))
