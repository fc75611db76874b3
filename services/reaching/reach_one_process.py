"""Runs the main job by the wall clock over real CAN interfaces, all services in one process.

For computers with one slow core, where a process per service cannot keep its time: frames go
through the kernel's SocketCAN as ever, messages between services as in virtual time.
"""

from collections.abc import Callable

from hal.errors import HalError
from services.core.clock import RealClock, wall_ns
from services.core.errors import ServiceError
from services.core.paced import PacedClock
from services.core.realtime import freeze_garbage, request_scheduling
from services.emulated.simulation import Simulation, paced_setting
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_virtual import LONGEST_S, Outcome, torque_loop_percentiles
from services.robotfile.robot_tables import RobotFile

TICKS_PER_REPORT = 200
PRIORITY = 50  # that of the boards and robot processes


def run_one_process(
    robot: RobotFile, options: ReachOptions, progress: Callable[[float, str], None]
) -> Outcome:
    """One run.

    Raises:
        ServiceError: a bus could not be opened.
    """
    job = Reach(robot, options)
    scheduler = request_scheduling(PRIORITY, 0)
    host = RealClock()
    clock = PacedClock(host)
    try:
        simulation = Simulation(
            robot,
            options.seed,
            guests={"reach": job},
            setting=paced_setting(robot, clock, host),
        )
    except HalError as error:
        raise ServiceError(str(error)) from error
    freeze_garbage()
    executor = simulation.executor
    start_ns = wall_ns()
    try:
        while not job.finished and executor.ticks < LONGEST_S * 1000:
            executor.tick()
            if executor.ticks % TICKS_PER_REPORT == 0:
                progress(executor.ticks * 1e-3, job.progress)
    except KeyboardInterrupt:
        job.recording.failure = "interrupted"
    elapsed_s = (wall_ns() - start_ns) * 1e-9
    simulation.close()
    report = job.recording.report()
    ik_p50_ns, ik_p99_ns = executor.step_times("ik").percentiles_ns(50, 99)
    late_p50_ns, late_p99_ns = clock.lateness.percentiles_ns(50, 99)
    loop_p50, loop_p99 = torque_loop_percentiles(job.recording.torque_loop_ms)
    report |= {
        "can": "socketcan",
        "processes": 1,
        "tick_slips": clock.slips,
        "steps": executor.ticks,
        "wall": {
            "ik_ms_p50": ik_p50_ns * 1e-6,
            "ik_ms_p99": ik_p99_ns * 1e-6,
            "torque_loop_ms_p50": loop_p50,
            "torque_loop_ms_p99": loop_p99,
            "tick_late_us_p50": late_p50_ns * 1e-3,
            "tick_late_us_p99": late_p99_ns * 1e-3,
            "realtime_factor": executor.ticks * 1e-3 / elapsed_s,
            "schedulers": {"all": scheduler},
        },
    }
    return Outcome(report=report, recording=job.recording)
