"""Runs the contact-free motion of the emulated robot in virtual time."""

from contextlib import closing

from services.core.errors import ServiceError
from services.emulated.simulation import Progress, Simulation
from services.experiments.forces.free_motion import FreeMotion
from services.robotfile.robot_tables import RobotFile
from services.wholebody.dynamics_messages import DynamicsSamples

LONGEST_TICKS = 300_000


def record(
    robot: RobotFile, seed: int, seconds: float, progress: Progress | None = None
) -> list[DynamicsSamples]:
    """What the dynamics service tells in `seconds` of full swing.

    `progress` is told the virtual seconds and what happens.

    Raises:
        ServiceError: the motion was not carried through, with the reason.
    """
    guest = FreeMotion(robot, seconds)
    with closing(Simulation(robot, seed, guests={"free_motion": guest})) as simulation:
        simulation.run(guest, progress, LONGEST_TICKS)
        faults = simulation.rig.board_faults
    if guest.failure or not guest.finished or faults:
        why = guest.failure or (f"{faults} faults of the boards" if faults else "no end")
        raise ServiceError(f"the contact-free motion failed: {why}")
    return guest.samples
