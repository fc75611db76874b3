"""Runs the main job on a stack of processes of its own, by the wall clock."""

from collections.abc import Callable
from typing import cast

from services.config import load_robot
from services.core.clock import RealClock, wall_ns
from services.core.errors import ConfigError, ProcessDiedError
from services.core.live import TRANSPORTS, robot_name
from services.core.loop import LiveExecutor
from services.messages import ServiceStats
from services.reaching.reach import Reach, ReachOptions
from services.reaching.reach_record import Report
from services.reaching.reach_virtual import Outcome, torque_loop_percentiles
from services.stack import Stack
from services.stack_choice import Can, choose_can, rows_for
from services.streams import STATS

SHOW_EVERY_STEPS = 10
HELD_AFTER_DEATH_NS = 1_000_000_000
MEASURED = ("boards", "robot", "ik")


def run_live(
    robot: str,
    options: ReachOptions,
    can: str,
    progress: Callable[[float, str], None],
    say: Callable[[str], None],
    watch: Callable[[Stack, Reach], None] | None = None,
) -> Outcome:
    """Start a stack, do the job, and bring everything down again, whatever happens.

    `watch` is called ten times a second, for experiments that break something on purpose.

    Raises:
        ConfigError: an unknown transport.
        ServiceError: the stack could not be started.
    """
    if can and can not in TRANSPORTS:
        raise ConfigError(f"--can: unknown transport {can!r}; allowed: {', '.join(TRANSPORTS)}")
    robot_file = load_robot(robot)
    interfaces = tuple(bus.channel for bus in robot_file.buses.values())
    chosen, reason = choose_can(cast(Can, can) if can else None, interfaces)
    say(f"CAN over {chosen}: {reason}")
    job = Reach(robot_file, options)
    rows = rows_for(robot_file)
    progress(0.0, "starting the processes")
    stats: dict[str, ServiceStats] = {}
    with Stack(robot, can=chosen, seed=options.seed, rows=rows, report=say) as stack:
        try:
            elapsed_s, stats = _work(stack, robot_name(robot), job, progress, watch)
        except ProcessDiedError as error:
            job.recording.failure = str(error)
            say(f"the end of the log of {error.process}:\n{error.log_tail}")
            elapsed_s = 0.0
        except KeyboardInterrupt:
            job.recording.failure = "interrupted"
            elapsed_s = 0.0
    report = job.recording.report()
    report["can"] = chosen
    report |= _figures(job, stats, elapsed_s)
    return Outcome(report=report, recording=job.recording)


def _work(
    stack: Stack,
    robot: str,
    job: Reach,
    progress: Callable[[float, str], None],
    watch: Callable[[Stack, Reach], None] | None,
) -> tuple[float, dict[str, ServiceStats]]:
    client = stack.client
    for process in MEASURED:
        client.watch(STATS[process])
    executor = LiveExecutor("reach", job, client.session, robot, RealClock())
    start_ns = wall_ns()
    steps = 0
    death: ProcessDiedError | None = None
    death_ns = 0

    def finished() -> bool:
        nonlocal steps, death, death_ns
        steps += 1
        if steps % SHOW_EVERY_STEPS == 0:
            if watch is not None:
                watch(stack, job)
            try:
                stack.check()
            except ProcessDiedError as error:
                if death is None:
                    death, death_ns = error, wall_ns()
            progress((wall_ns() - start_ns) * 1e-9, job.progress)
        # A dead process means: hold, report, stop. In this time it can be seen to hold.
        return job.finished or (death is not None and wall_ns() - death_ns > HELD_AFTER_DEATH_NS)

    executor.run(finished)
    elapsed_s = (wall_ns() - start_ns) * 1e-9
    if death is not None:
        raise death
    stack.check()
    return elapsed_s, {p: s for p in MEASURED if (s := client.latest(STATS[p])) is not None}


def _figures(job: Reach, stats: dict[str, ServiceStats], elapsed_s: float) -> Report:
    boards, ik = stats.get("boards"), stats.get("ik")
    loop_p50, loop_p99 = torque_loop_percentiles(job.recording.torque_loop_ms)
    slips = sum(s.tick_slips for name, s in stats.items() if name != "ik")
    first, last = job.recording.plant_ticks
    span_s = (last - first) * 1e-3
    return {
        "tick_slips": slips,
        "steps": boards.steps if boards else 0,
        "wall": {
            "ik_ms_p50": ik.step_ms_p50 if ik else None,
            "ik_ms_p99": ik.step_ms_p99 if ik else None,
            "torque_loop_ms_p50": loop_p50,
            "torque_loop_ms_p99": loop_p99,
            "tick_late_us_p50": boards.late_us_p50 if boards else None,
            "tick_late_us_p99": boards.late_us_p99 if boards else None,
            "realtime_factor": span_s / elapsed_s if elapsed_s else None,
            "schedulers": {name: s.scheduler for name, s in stats.items()},
        },
    }
