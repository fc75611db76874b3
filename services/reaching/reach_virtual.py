"""Runs the main job in virtual time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from services.core.clock import wall_ns
from services.core.service import Service
from services.core.virtual import VirtualExecutor
from services.emulated.simulation import Progress, Simulation
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_record import Recording, Report
from services.robotfile.robot_tables import RobotFile

INNER_LOOP = ("boards", "robot", "dynamics")
LONGEST_S = 150.0  # of virtual time; every wait inside the job is shorter


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one run leaves behind."""

    report: Report
    recording: Recording


def run_virtual(
    robot: RobotFile,
    options: ReachOptions,
    hop_ticks: int = 1,
    progress: Progress | None = None,
    replaced: Mapping[str, Service] | None = None,
) -> Outcome:
    """One run.

    `progress` is told the virtual seconds and what the job is doing, ten times a virtual second.
    """
    job = Reach(robot, options)
    simulation = Simulation(robot, options.seed, hop_ticks, {"reach": job}, replaced)
    executor = simulation.executor
    start_ns = wall_ns()
    simulation.run(job, progress, LONGEST_S * 1000)
    elapsed_s = (wall_ns() - start_ns) * 1e-9
    simulation.close()
    report = job.recording.report()
    report["tick_slips"] = 0  # virtual time cannot slip
    report["steps"] = executor.ticks
    ik_p50, ik_p99 = executor.step_times("ik").percentiles_ns(50, 99)
    loop_p50, loop_p99 = torque_loop_percentiles(job.recording.torque_loop_ms)
    report["wall"] = {
        "ik_ms_p50": ik_p50 * 1e-6,
        "ik_ms_p99": ik_p99 * 1e-6,
        "torque_loop_ms_p50": loop_p50,
        "torque_loop_ms_p99": loop_p99,
        "tick_late_us_p50": None,  # there is no wall clock to be late by
        "tick_late_us_p99": None,
        "realtime_factor": executor.ticks * 1e-3 / elapsed_s,
        **{f"{name}_us_p50": median_us(executor, name) for name in INNER_LOOP},
    }
    return Outcome(report=report, recording=job.recording)


def median_us(executor: VirtualExecutor, name: str) -> float:
    """Median duration of one service's steps."""
    return executor.step_times(name).percentiles_ns(50)[0] * 1e-3


def torque_loop_percentiles(samples_ms: list[float]) -> tuple[float | None, float | None]:
    """Median and 99th percentile; None when no torque ever went round."""
    if not samples_ms:
        return None, None
    p50, p99 = np.percentile(samples_ms, (50, 99))
    return float(p50), float(p99)
