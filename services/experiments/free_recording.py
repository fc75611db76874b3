"""Runs the contact-free motion in virtual time and brings its signals to one instant.

Encoders and force/torque sensors pass the same polynomial smoother, centred on the instant, so that
neither is later than the other: a delay between the two would be read as a force.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from dforc.arrays import Matrix, Vector
from services.core.errors import ServiceError
from services.experiments.free_motion import FreeMotion, Log
from services.messages import Wrench
from services.robot_tables import RobotFile
from services.simulation import Simulation

TICKS_PER_REPORT = 100
LONGEST_TICKS = 300_000
WINDOW_S = 0.16
DEGREE = 3

Progress = Callable[[float, str], None]


@dataclass(frozen=True, slots=True, eq=False)
class FreeRecording:
    """One run, a row per joint state; smoothed, and all of one row belongs to one instant."""

    at_s: Vector  # (rows,), from the beginning of the rest
    joints: tuple[str, ...]
    q_rad: Matrix  # (rows, joints)
    dq_rad_s: Matrix
    ddq_rad_s2: Matrix
    wrenches: dict[str, Matrix]  # by sensor, (rows, 6): force, moment
    resting: NDArray[np.bool_]  # (rows,)
    moving: NDArray[np.bool_]  # in full swing


def record(
    robot: RobotFile, seed: int, seconds: float, progress: Progress | None = None
) -> FreeRecording:
    """`seconds` of full swing; `progress` is told the virtual seconds and what happens.

    Raises:
        ServiceError: the motion was not carried through, with the reason.
    """
    guest = FreeMotion(robot, seconds)
    simulation = Simulation(robot, seed, guests={"free_motion": guest})
    executor = simulation.executor
    try:
        while not guest.finished and executor.ticks < LONGEST_TICKS:
            executor.tick()
            if progress is not None and executor.ticks % TICKS_PER_REPORT == 0:
                progress(executor.ticks * 1e-3, guest.progress)
        faults = simulation.rig.board_faults
    finally:
        simulation.close()
    if guest.log.failure or not guest.finished or faults:
        why = guest.log.failure or (f"{faults} faults of the boards" if faults else "no end")
        raise ServiceError(f"the contact-free motion failed: {why}")
    return aligned(guest.log, robot)


def aligned(log: Log, robot: RobotFile) -> FreeRecording:
    """The log's signals, smoothed alike, at the instants of its joint states."""
    at_ns = np.array([state.stamp_ns for state in next(iter(log.states.values()))])
    period_s = float(np.median(np.diff(at_ns))) * 1e-9
    q_rad = np.hstack([[state.q_rad for state in states] for states in log.states.values()])
    at_s = (at_ns - log.rest_ns[0]) * 1e-9
    keep = slice(*_inside(len(at_ns), period_s))
    return FreeRecording(
        at_s=at_s[keep],
        joints=tuple(joint for part in log.states for joint in robot.parts[part]),
        q_rad=smoothed(q_rad, period_s, 0)[keep],
        dq_rad_s=smoothed(q_rad, period_s, 1)[keep],
        ddq_rad_s2=smoothed(q_rad, period_s, 2)[keep],
        wrenches={
            sensor: smoothed(at_instants(at_ns, wrenches), period_s, 0)[keep]
            for sensor, wrenches in log.wrenches.items()
        },
        resting=_between(at_ns, log.rest_ns)[keep],
        moving=_between(at_ns, log.motion_ns)[keep],
    )


def smoothed(values: Matrix, period_s: float, derivative: int) -> Matrix:
    """A column's derivative of order 0, 1 or 2, without delay."""
    result: Matrix = savgol_filter(
        values, _window(period_s), DEGREE, deriv=derivative, delta=period_s, axis=0
    )
    return result


def at_instants(at_ns: NDArray[np.int64], wrenches: list[Wrench]) -> Matrix:
    """Mean of the wrenches that arrived between one instant and the next, (instants, 6)."""
    arrival_ns = np.array([wrench.arrival_ns for wrench in wrenches])
    values = np.array([(*wrench.force_n, *wrench.torque_nm) for wrench in wrenches])
    sums = np.vstack([np.zeros(6), np.cumsum(values, axis=0)])
    period_ns = int(np.median(np.diff(at_ns)))
    last = np.searchsorted(arrival_ns, at_ns, side="right")
    first = np.searchsorted(arrival_ns, at_ns - period_ns, side="right")
    first = np.clip(np.minimum(first, last - 1), 0, None)
    means: Matrix = (sums[last] - sums[first]) / np.maximum(last - first, 1)[:, None]
    return means


def _window(period_s: float) -> int:
    return 2 * round(WINDOW_S / period_s / 2.0) + 1


def _inside(rows: int, period_s: float) -> tuple[int, int]:
    """Rows whose whole window was recorded."""
    half = _window(period_s) // 2
    return half, rows - half


def _between(at_ns: NDArray[np.int64], span_ns: tuple[int, int]) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = (at_ns >= span_ns[0]) & (at_ns < span_ns[1])
    return inside
