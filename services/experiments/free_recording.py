"""Runs the contact-free motion of the emulated robot in virtual time."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dforc.arrays import Matrix, Vector
from services.core.errors import ServiceError
from services.experiments.free_motion import FreeMotion
from services.robot_tables import RobotFile
from services.simulation import Simulation

TICKS_PER_REPORT = 100
LONGEST_TICKS = 300_000

Progress = Callable[[float, str], None]


@dataclass(frozen=True, slots=True, eq=False)
class FreeRecording:
    """One run, 100 rows a second; all of one row belongs to one instant."""

    at_s: Vector  # (rows,)
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
    if guest.failure or not guest.finished or faults:
        why = guest.failure or (f"{faults} faults of the boards" if faults else "no end")
        raise ServiceError(f"the contact-free motion failed: {why}")
    return _table(guest)


def _table(guest: FreeMotion) -> FreeRecording:
    rows = guest.rows
    phases = np.array([row.phase for row in rows])
    motions = [row.motion for row in rows]
    return FreeRecording(
        at_s=np.array([row.at_s for row in rows]),
        joints=guest.joints,
        q_rad=np.array([motion.q_rad for motion in motions]),
        dq_rad_s=np.array([motion.dq_rad_s for motion in motions]),
        ddq_rad_s2=np.array([motion.ddq_rad_s2 for motion in motions]),
        wrenches={
            sensor: np.array([row.wrenches[i] for row in rows])
            for i, sensor in enumerate(guest.sensors)
        },
        resting=phases == "rest",
        moving=phases == "swing",
    )
