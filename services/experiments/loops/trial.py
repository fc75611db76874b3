"""A guest of the stack that takes the whole robot through the trials of the closed loops.

Reads   robot/status, dynamics/health, boards/plant_truth (frames lost), torque_estimate,
        impedance_offset and joint_state of every limb
Writes  joint_command of every limb
Calls   robot/request, dynamics/zero_ft
The trials themselves are functions of their own (loop_torque, loop_impedance, loop_guiding,
loop_velocity): scripts that use what stands here. What the robot is judged by is the plant's truth.
"""

from collections.abc import Callable, Sequence

import numpy as np

from services.core.service import Period
from services.experiments.loops.limbs import Limb, limbs
from services.experiments.loops.world import World
from services.messages import Floats, FtRequest, JointCommand, TorqueEstimate
from services.robotfile.robot_tables import RobotFile
from services.script import TASK_TIMEOUT_S, AbandonedError, Script, ScriptedService
from services.streams import (
    DYNAMICS_HEALTH,
    FT_CALL,
    IMPEDANCE_OFFSET,
    JOINT_COMMAND,
    JOINT_STATE,
    PLANT_TRUTH,
    ROBOT_CALL,
    ROBOT_STATUS,
    TORQUE_ESTIMATE,
)

PERIOD_S = 0.001
COMMAND_TICKS = 10
MOVE_S, RETURN_S, SETTLE_S = 3.0, 1.0, 1.0
GUIDED_NMS_RAD = 1.0

Trial = Callable[["LoopTrial"], Script]
Values = dict[str, float]  # by joint


class LoopTrial(ScriptedService):
    """Prepares the robot, then runs one trial after another."""

    trigger = Period(PERIOD_S)
    calls = (ROBOT_CALL, FT_CALL)

    def __init__(self, robot: RobotFile, world: World, trials: Sequence[Trial]) -> None:
        self.robot = robot
        self.world = world
        self.limbs = limbs(robot)
        self.failure = ""
        self.estimates: dict[str, list[TorqueEstimate]] = {limb.part: [] for limb in self.limbs}
        self.holds_gravity = False  # in all joints with a torque loop, which are in torque mode
        self._trials = trials
        self._listening = False
        self._ticks = 0
        parts = [limb.part for limb in self.limbs]
        self.reads = (
            *(ROBOT_STATUS, DYNAMICS_HEALTH, PLANT_TRUTH),
            *(TORQUE_ESTIMATE[part] for part in parts),
            *(IMPEDANCE_OFFSET[part] for part in parts),
            *(JOINT_STATE[part] for part in parts),
        )
        self.writes = tuple(JOINT_COMMAND[part] for part in parts)
        super().__init__(tuple(joint for names in robot.parts.values() for joint in names))

    def script(self) -> Script:
        """The whole experiment."""
        try:
            yield from self._prepare()
            for trial in self._trials:
                yield from trial(self)
                yield from self.go_back()
        except AbandonedError as error:
            self.failure = str(error)

    def observe(self) -> None:
        """Keep the torques while a trial wants them, and hold the limbs against gravity."""
        if self._listening:
            for part, heard in self.estimates.items():
                heard += self.inputs.all_new(TORQUE_ESTIMATE[part])
        self._ticks += 1
        if self.holds_gravity and self._ticks % COMMAND_TICKS == 0:
            for limb in self.limbs:
                self.command_torques(limb, self._weightless(limb))

    @property
    def frames_lost(self) -> int:
        """On either side of the buses so far."""
        truth = self.inputs.latest(PLANT_TRUTH)
        return self.status().frames_lost + (0 if truth is None else truth.frames_lost)

    def _prepare(self) -> Script:
        yield from self.calibrate()
        yield from self._to_posture("moving to the posture of the trials", MOVE_S)
        yield from self.wait(SETTLE_S)
        self.say("removing the offsets of the force/torque sensors")
        yield from self.answered(self.outputs.call(FT_CALL, FtRequest()), "zero_ft")
        yield from self.until(self._knows_offsets, TASK_TIMEOUT_S, "FT offsets known")

    def _knows_offsets(self) -> bool:
        health = self.inputs.latest(DYNAMICS_HEALTH)
        return health is not None and all(sensor.ok for sensor in health.sensors)

    def go_back(self) -> Script:
        """Stiff, in position mode, in the posture of the trials."""
        self.world.let_go()
        joints = self.joints(lambda limb: limb.torque)
        yield from self.ask("making the limbs stiff", "interaction", joints=joints, value="stiff")
        yield from self.ask("position mode", "mode", joints=joints, value="position")
        yield from self._to_posture("moving back", RETURN_S)

    def _to_posture(self, what: str, seconds: float) -> Script:
        joints = self.joints(lambda limb: self.robot.parts[limb.part])
        posture = tuple(float(np.radians(deg)) for limb in self.limbs for deg in limb.posture_deg)
        yield from self.ask(what, "move", joints=joints, q_rad=posture, duration_s=seconds)

    def joints(self, of: Callable[[Limb], Sequence[str]]) -> tuple[str, ...]:
        """Joints of every limb."""
        return tuple(joint for limb in self.limbs for joint in of(limb))

    def make_compliant(self) -> Script:
        """Position-direct mode, and every joint that can be a spring made one."""
        joints = self.joints(lambda limb: limb.compliant)
        yield from self.ask("position-direct mode", "mode", joints=joints, value="direct")
        yield from self.ask("going compliant", "interaction", joints=joints, value="compliant")

    def wait(self, seconds: float, each: Callable[[float], None] | None = None) -> Script:
        """Let time pass; `each` is called every 10 ms with the time since the beginning."""
        for tick in range(round(seconds / PERIOD_S)):
            if each is not None and tick % COMMAND_TICKS == 0:
                each(tick * PERIOD_S)
            yield
            if self.status().fault_count:
                raise AbandonedError(f"fault{self.faults()}")

    def gravity(self, limb: Limb) -> Values:
        """Gravity torques (Nm) of a limb's joints, as the dynamics service publishes them."""
        offset = self.inputs.latest(IMPEDANCE_OFFSET[limb.part])
        if offset is None:
            raise AbandonedError(f"no gravity torques of {limb.part}")
        return dict(zip(self.robot.parts[limb.part], offset.tau_nm, strict=True))

    def _weightless(self, limb: Limb) -> Values:
        """Gravity, and a little damping: the torque loops take away most of the drives' own."""
        state = self.inputs.latest(JOINT_STATE[limb.part])
        if state is None:
            raise AbandonedError(f"no joint states of {limb.part}")
        speeds = dict(zip(self.robot.parts[limb.part], state.dq_rad_s, strict=True))
        gravity = self.gravity(limb)
        return {joint: gravity[joint] - GUIDED_NMS_RAD * speeds[joint] for joint in limb.torque}

    def command_torques(self, limb: Limb, tau_nm: Values) -> None:
        """Torque set-points of some joints."""
        self._put(limb, "torque", tau_nm)

    def command_velocities(self, limb: Limb, dq_rad_s: Values) -> None:
        """Velocity set-points of some joints."""
        self._put(limb, "velocity", dq_rad_s)

    def _put(self, limb: Limb, mode: str, values: Values) -> None:
        given: Floats = tuple(values.values())
        command = JointCommand(
            stamp_ns=self.now_ns,
            mode=mode,
            joints=tuple(values),
            tau_nm=given if mode == "torque" else (),
            dq_rad_s=given if mode == "velocity" else (),
        )
        self.outputs.put(JOINT_COMMAND[limb.part], command)

    def listen(self) -> None:
        """Keep the torque estimates from now on, and forget the old ones."""
        for heard in self.estimates.values():
            heard.clear()
        self._listening = True

    def deafen(self) -> None:
        """Keep them no longer."""
        self._listening = False
