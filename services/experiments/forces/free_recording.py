"""Runs the contact-free motion of the emulated robot in virtual time."""

from collections.abc import Callable

from services.core.errors import ServiceError
from services.emulated.simulation import Simulation
from services.experiments.forces.free_motion import FreeMotion
from services.robotfile.robot_tables import RobotFile
from services.wholebody.dynamics_messages import DynamicsSamples

TICKS_PER_REPORT = 100
LONGEST_TICKS = 300_000

Progress = Callable[[float, str], None]


def record(
    robot: RobotFile, seed: int, seconds: float, progress: Progress | None = None
) -> list[DynamicsSamples]:
    """What the dynamics service tells in `seconds` of full swing.

    `progress` is told the virtual seconds and what happens.

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
    if guest.failure or not guest.finished or faults:
        why = guest.failure or (f"{faults} faults of the boards" if faults else "no end")
        raise ServiceError(f"the contact-free motion failed: {why}")
    return guest.samples
