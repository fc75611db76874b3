"""The figure of the closed loops: torque steps, pushes, hand guiding, velocity."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from services.experiments.loops.guiding import Guiding
from services.experiments.loops.impedance import PUSH_S, Deflection
from services.experiments.loops.torque import BAND, TorqueStep
from services.experiments.loops.velocity import Turn

TICK_S = 0.001
COLOURS = [f"C{k}" for k in range(10)] + ["gold", "navy", "black"]


def draw(
    steps: Sequence[TorqueStep],
    deflections: Sequence[Deflection],
    guidings: Sequence[Guiding],
    turns: Sequence[Turn],
    path: Path,
) -> None:
    """Write the figure as PNG, or what the file's ending asks for."""
    figure, panels = plt.subplots(2, 2, figsize=(14, 9), layout="constrained")
    _steps(panels[0, 0], steps)
    _pushes(panels[0, 1], deflections)
    _guiding(panels[1, 0], guidings)
    _turns(panels[1, 1], turns)
    for panel in panels.flat:
        panel.grid(visible=True, alpha=0.3)
    figure.suptitle("closed loops on the boards, emulated robot")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _paint(
    panel: Axes, x: ArrayLike, y: ArrayLike, of: str, kinds: Sequence[str], label: str
) -> None:
    """One colour a kind; right a thin dash over a broad left, so that both are seen."""
    colour = COLOURS[kinds.index(_kind(of)) % len(COLOURS)]
    if of.startswith("r"):
        panel.plot(x, y, color=colour, lw=1.1, ls=(0, (4, 2)), zorder=3, label=label)
    else:
        panel.plot(x, y, color=colour, lw=2.6, alpha=0.45, zorder=2, label=label)


def _kind(name: str) -> str:
    """A joint, limb or push without its side."""
    return name.partition("_")[2]


def _kinds(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(_kind(name) for name in names))


def _steps(panel: Axes, steps: Sequence[TorqueStep]) -> None:
    kinds = _kinds(step.joint for step in steps)
    for step in steps:
        share = (step.tau_nm - step.wanted_nm[0]) / step.amplitude_nm
        _paint(panel, step.at_s * 1e3, share, step.joint, kinds, step.joint)
    panel.axhspan(1.0 - BAND, 1.0 + BAND, color="0.93", zorder=0)
    panel.axvline(0.0, color="0.6", lw=0.8)
    panel.axhline(1.0, color="0.6", lw=0.8)
    panel.set(title="torque steps (left broad, right dashed)", xlabel="time [ms]")
    panel.set(xlim=(-50, 600), ylim=(-0.25, 1.5), ylabel="(torque - commanded before) / step")
    if steps:
        panel.legend(fontsize=6, ncols=2)


def _pushes(panel: Axes, deflections: Sequence[Deflection]) -> None:
    names = [f"{one.limb} {one.place} {one.axis}" for one in deflections]
    kinds = _kinds(names)
    for name, one in zip(names, deflections, strict=True):
        share = one.trace_m / np.linalg.norm(one.predicted_m)
        at_s = np.arange(len(share)) * TICK_S
        _paint(panel, at_s, share, name, kinds, name)
    panel.axvspan(0.0, PUSH_S, color="0.9")
    panel.set(title="20 N", xlabel="time [s]", ylabel="deflection / K⁻¹ Jᵀ F")
    if deflections:
        panel.legend(fontsize=6, ncols=2)


def _guiding(panel: Axes, guidings: Sequence[Guiding]) -> None:
    kinds = _kinds(one.limb for one in guidings)
    for one in guidings:
        way_mm, force_n = one.trace[:, 1] * 1e3, one.trace[:, 0]
        _paint(panel, way_mm, force_n, one.limb, kinds, f"{one.limb}, peak {one.peak_n:.1f} N")
    panel.set(title="hand guiding", xlabel="way of the end [mm]", ylabel="force of the person [N]")
    if guidings:
        panel.legend(fontsize=8)


def _turns(panel: Axes, turns: Sequence[Turn]) -> None:
    kinds = _kinds(one.joint for one in turns)
    for one in turns:
        at_s = np.arange(len(one.q_rad)) * TICK_S
        error_deg = np.degrees(one.q_rad - one.reference_rad)
        _paint(panel, at_s, error_deg, one.joint, kinds, one.joint)
    panel.set(
        title="velocity on impedance: there, back, there with 20 N",
        xlabel="time [s]",
        ylabel="angle - reference [deg]",
    )
    if turns:
        panel.legend(fontsize=6, ncols=2)
