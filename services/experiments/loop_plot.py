"""The figure of the closed loops: torque steps, pushes, hand guiding, velocity."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from services.experiments.loop_guiding import Guiding
from services.experiments.loop_impedance import PUSH_S, Deflection
from services.experiments.loop_torque import TorqueStep
from services.experiments.loop_velocity import Turn

TICK_S = 0.001


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


def _steps(panel: Axes, steps: Sequence[TorqueStep]) -> None:
    for step in steps:
        share = (step.tau_nm - step.wanted_nm[0]) / step.amplitude_nm
        panel.plot(step.at_s * 1e3, share, lw=0.9, label=step.joint)
    panel.axvline(0.0, color="0.6", lw=0.8)
    panel.axhline(1.0, color="0.6", lw=0.8)
    panel.set(title="torque steps", xlabel="time [ms]", ylabel="change / asked")
    panel.set(xlim=(-50, 400), ylim=(-0.25, 1.5))
    if steps:
        panel.legend(fontsize=6, ncols=2)


def _pushes(panel: Axes, deflections: Sequence[Deflection]) -> None:
    for one in deflections:
        share = one.trace_m / np.linalg.norm(one.predicted_m)
        at_s = np.arange(len(share)) * TICK_S
        panel.plot(at_s, share, lw=0.9, label=f"{one.limb} {one.place}")
    panel.axvspan(0.0, PUSH_S, color="0.9")
    panel.set(title="20 N", xlabel="time [s]", ylabel="deflection / K⁻¹ Jᵀ F")
    if deflections:
        panel.legend(fontsize=6, ncols=2)


def _guiding(panel: Axes, guidings: Sequence[Guiding]) -> None:
    for one in guidings:
        panel.plot(one.trace[:, 1] * 1e3, one.trace[:, 0], lw=1.0, label=one.limb)
    panel.set(title="hand guiding", xlabel="way of the end [mm]", ylabel="force of the person [N]")
    if guidings:
        panel.legend(fontsize=8)


def _turns(panel: Axes, turns: Sequence[Turn]) -> None:
    for one in turns:
        at_s = np.arange(len(one.q_rad)) * TICK_S
        error_deg = np.degrees(one.q_rad - one.reference_rad)
        panel.plot(at_s, error_deg, lw=0.9, label=one.joint)
    panel.set(
        title="velocity on impedance: there, back, there with 20 N",
        xlabel="time [s]",
        ylabel="angle - reference [deg]",
    )
    if turns:
        panel.legend(fontsize=6, ncols=2)
