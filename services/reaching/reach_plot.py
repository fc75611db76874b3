"""Draws one reach: the path in space, errors, clearance, forces and torques over time."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d import Axes3D

from services.reaching.reach_record import Recording

SHOWN_TORQUES = ("r_shoulder_pitch", "r_shoulder_roll", "r_shoulder_yaw", "r_elbow")


def draw(recording: Recording, path: Path) -> None:
    """Write the figure as PNG (or what the file's ending asks for)."""
    figure = plt.figure(figsize=(14, 9), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.1, 1.0), wspace=0.1)
    space = figure.add_subplot(grid[:, 0], projection="3d")
    assert isinstance(space, Axes3D)
    _draw_space(space, recording)
    axes = [figure.add_subplot(grid[row, 1]) for row in range(3)]
    _draw_errors(axes[0], recording)
    _draw_clearance(axes[1], recording)
    _draw_torques(axes[2], recording)
    for axis in axes:
        _mark_events(axis, recording)
        axis.grid(visible=True, alpha=0.3)
    axes[-1].set_xlabel("time since the goal was given [s]")
    figure.suptitle(_title(recording))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _title(recording: Recording) -> str:
    report = recording.report()
    reached = "reached" if report["reached"] else f"not reached {report['failure']}"
    figures = [
        f"{report[key]:.2f} {unit}"
        for key, unit in (
            ("position_error_mm", "mm"),
            ("orientation_error_deg", "deg"),
            ("min_clearance_mm", "mm clearance"),
        )
        if isinstance(report[key], float)
    ]
    return f"seed {report['seed']}: {reached}  {',  '.join(figures)}"


def _draw_space(axes: Axes3D, recording: Recording) -> None:
    trace, scene = recording.trace, recording.scene
    for points, style, label in (
        (trace.point_m, {"color": "tab:green", "lw": 1.0, "ls": "--"}, "virtual point"),
        (trace.plan_m, {"color": "tab:orange", "lw": 1.0}, "plan"),
        (trace.tip_m, {"color": "tab:blue", "lw": 2.0}, "hand (plant)"),
    ):
        if points:
            x, y, z = np.array(points).T
            axes.plot(x, y, z, label=label, **style)
    if scene is not None:
        axes.scatter(*scene.target_m, color="tab:red", marker="x", s=60, label="target")
        if scene.ball_centre_m is not None:
            _draw_ball(axes, np.array(scene.ball_centre_m), scene.ball_radius_m)
    _look_across(axes, recording)
    axes.set_xlabel("x [m] (backwards)")
    axes.set_ylabel("y [m] (right)")
    axes.set_zlabel("z [m] (up)")
    axes.set_aspect("equal")
    if trace.tip_m:
        axes.legend(loc="upper left")


def _look_across(axes: Axes3D, recording: Recording) -> None:
    """Turn the view so that the detour around the ball is seen from the side."""
    if recording.scene is None or not recording.trace.tip_m:
        return
    path, target = np.array(recording.trace.tip_m), np.array(recording.scene.target_m)
    along = target - path[0]
    along /= max(float(np.linalg.norm(along)), 1e-9)
    aside = path - path[0] - np.outer((path - path[0]) @ along, along)
    sight = np.cross(along, aside[int(np.linalg.norm(aside, axis=1).argmax())])
    if np.linalg.norm(sight) < 1e-9:
        return
    x, y, z = sight / np.linalg.norm(sight) * (1.0 if sight[2] >= 0.0 else -1.0)
    axes.view_init(elev=float(np.degrees(np.arcsin(z))), azim=float(np.degrees(np.arctan2(y, x))))


def _draw_ball(
    axes: Axes3D, centre: "np.ndarray[tuple[int], np.dtype[np.float64]]", radius: float
) -> None:
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 24), np.linspace(0, np.pi, 12))
    axes.plot_surface(
        centre[0] + radius * np.cos(u) * np.sin(v),
        centre[1] + radius * np.sin(u) * np.sin(v),
        centre[2] + radius * np.cos(v),
        color="tab:red",
        alpha=0.25,
        linewidth=0,
    )


def _draw_errors(axes: Axes, recording: Recording) -> None:
    trace = recording.trace
    axes.semilogy(trace.time_s, np.maximum(np.array(trace.position_error_m) * 1e3, 1e-2))
    axes.set_ylabel("hand to target [mm]", color="tab:blue")
    other = axes.twinx()
    other.plot(trace.time_s, np.degrees(trace.orientation_error_rad), color="tab:orange")
    other.set_ylabel("orientation error [deg]", color="tab:orange")


def _draw_clearance(axes: Axes, recording: Recording) -> None:
    trace = recording.trace
    if trace.clearance_m:
        axes.plot(trace.time_s, np.array(trace.clearance_m) * 1e3, label="hand to ball")
        axes.plot(trace.time_s, np.array(trace.arm_clearance_m) * 1e3, label="arm to ball")
        axes.axhline(0.0, color="tab:red", lw=0.8)
    axes.plot(
        trace.time_s, trace.external_force_n, color="tab:gray", lw=0.8, label="estimated push [N]"
    )
    axes.set_ylabel("clearance [mm], force [N]")
    axes.legend(loc="upper right", fontsize="small")


def _draw_torques(axes: Axes, recording: Recording) -> None:
    trace = recording.trace
    full = len(recording.joints)
    estimated = [row if len(row) == full else (np.nan,) * full for row in trace.estimated_nm]
    if estimated:
        values, motor = np.array(estimated), np.array(trace.motor_nm)
        for i, name in enumerate(SHOWN_TORQUES):
            column = recording.joints.index(name)
            axes.plot(trace.time_s, values[:, column], color=f"C{i}", label=name)
            axes.plot(trace.time_s, motor[:, column], color=f"C{i}", lw=0.6, ls=":")
    axes.set_ylabel("joint torque [Nm]\n(dotted: plant's motor)")
    if axes.lines:
        axes.legend(loc="upper right", fontsize="small", ncols=2)


def _mark_events(axes: Axes, recording: Recording) -> None:
    begin_s = recording.begin_ns * 1e-9
    for instant_ns, colour in (
        (recording.reached_ns, "tab:green"),
        (recording.push_begin_ns, "tab:red"),
        (recording.push_end_ns, "tab:red"),
    ):
        if instant_ns is not None:
            axes.axvline(instant_ns * 1e-9 - begin_s, color=colour, lw=0.8, ls="--")
