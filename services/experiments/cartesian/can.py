"""Controllers of the Cartesian experiment on the emulated robot, through its boards and CAN frames.

The service takes the place of `cartesian` in the stack: it takes the robot to the start of a
course, puts its joints into position-direct mode, stiff, and sends what the controller says. What
the plant truly did is kept beside it.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from firmware_sim.rig import Rig
from services.core.errors import ServiceError
from services.core.service import Period
from services.emulated.simulation import Progress, Simulation
from services.experiments.cartesian.arm import Arm
from services.experiments.cartesian.controllers import Contender
from services.experiments.cartesian.course import PERIOD_S, Course
from services.experiments.cartesian.figures import Run
from services.messages import JointCommand
from services.reaching.limb import split
from services.robotfile.robot_tables import RobotFile
from services.script import AbandonedError, Script, ScriptedService
from services.streams import JOINT_COMMAND, JOINT_STATE, ROBOT_CALL, ROBOT_STATUS

BOARDS = "boards"  # name of this plant
MOVE_S, SETTLE_S = 2.0, 1.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Job:
    """One controller along one course."""

    arm: Arm
    course: Course
    contender: Contender

    @property
    def text(self) -> str:
        """For the line of progress."""
        return (
            f"{self.contender.name}, {self.course.name}, {self.arm.limb.name.replace('_', ' ')}, "
            f"{self.arm.degrees_of_freedom} DoF"
        )


def run_on_boards(
    robot: RobotFile, jobs: Sequence[Job], seed: int, progress: Progress | None = None
) -> list[Run]:
    """All jobs, one after another, on one emulated robot in virtual time.

    Args:
        robot: with the parts that the jobs move.
        jobs: what to do.
        seed: draws plant masses and levers, sensor noise and offset.
        progress: is told the robot's time and what it does.

    Raises:
        ServiceError: the robot did not carry a job through.
    """
    trial = CartesianTrial(robot, jobs, seed)
    with closing(Simulation(robot, seed, replaced={"cartesian": trial})) as simulation:
        trial.surround(simulation.rig)
        simulation.run(trial, progress)
    if trial.failure:
        raise ServiceError(f"the emulated robot (plant {seed}) stopped: {trial.failure}")
    return trial.runs


class CartesianTrial(ScriptedService):
    """Takes the robot through the jobs; `runs` holds what came of them."""

    trigger = Period(PERIOD_S)
    calls = (ROBOT_CALL,)

    def __init__(self, robot: RobotFile, jobs: Sequence[Job], seed: int) -> None:
        self.runs: list[Run] = []
        self.failure = ""
        self._jobs = jobs
        self._seed = seed
        self._rig: Rig | None = None
        parts = dict.fromkeys(part for job in jobs for part in job.arm.limb.parts)
        self.reads = (ROBOT_STATUS, *(JOINT_STATE[part] for part in parts))
        self.writes = tuple(JOINT_COMMAND[part] for part in parts)
        super().__init__(tuple(joint for part in parts for joint in robot.parts[part]))

    def surround(self, rig: Rig) -> None:
        """Take the robot whose true angles are kept."""
        self._rig = rig

    def script(self) -> Script:
        """Calibrate, then every job."""
        try:
            yield from self.calibrate()
            for job in self._jobs:
                yield from self._prepare(job)
                yield from self._go(job)
        except AbandonedError as error:
            self.failure = str(error)

    def _prepare(self, job: Job) -> Script:
        joints = job.arm.joints
        start = tuple(job.course.q_start_rad.tolist())
        yield from self.ask("position mode", "mode", joints=joints, value="position")
        what = f"{job.text}: moving to the start"
        yield from self.ask(what, "move", joints=joints, q_rad=start, duration_s=MOVE_S)
        yield from self._wait(SETTLE_S)
        yield from self.ask("position-direct mode", "mode", joints=joints, value="direct")
        yield from self._wait(SETTLE_S)

    def _go(self, job: Job) -> Script:
        self.say(job.text)
        moving = job.contender.begin(job.arm, job.course)
        references, angles = [], [self._truth(job.arm)]
        for period in range(job.course.periods):
            q, dq = moving.step(period, self._measured(job.arm))
            self._command(job.arm, q, dq)
            yield
            self._check()
            references.append(q)
            angles.append(self._truth(job.arm))
        self.runs.append(
            Run(
                controller=job.contender.name,
                plant=BOARDS,
                seed=self._seed,
                arm=job.arm,
                course=job.course,
                references_rad=np.array(references),
                angles_rad=np.array(angles),
            )
        )

    def _command(self, arm: Arm, q_rad: Vector, dq_rad_s: Vector) -> None:
        limb = arm.limb.name
        speeds = split(arm.robot, tuple(dq_rad_s.tolist()), limb)
        for part, angles in split(arm.robot, tuple(q_rad.tolist()), limb).items():
            command = JointCommand(
                stamp_ns=self.now_ns, mode="direct", q_rad=angles, dq_rad_s=speeds[part]
            )
            self.outputs.put(JOINT_COMMAND[part], command)

    def _measured(self, arm: Arm) -> Vector:
        states = [self.inputs.latest(JOINT_STATE[part]) for part in arm.limb.parts]
        angles = [state.q_rad for state in states if state is not None]
        if len(angles) < len(states):
            raise AbandonedError("no joint states")
        return np.concatenate(angles)

    def _truth(self, arm: Arm) -> Vector:
        assert self._rig is not None, "nobody has called surround()"
        columns = [self._rig.joints.index(joint) for joint in arm.joints]
        truth: Vector = self._rig.plant.q_rad[columns]
        return truth

    def _wait(self, seconds: float) -> Script:
        for _ in range(round(seconds / PERIOD_S)):
            yield
            self._check()

    def _check(self) -> None:
        if self.status().fault_count:
            raise AbandonedError(f"fault{self.faults()}")
