"""The HAL as a service: boards on CAN buses on one side, typed streams on the other.

Reads   joint_command, torque_estimate, impedance_offset of every part
Writes  joint_state of every part, wrench of every FT sensor, what other sensor boards measure
        (sensor_streams.py), robot/status (its heartbeat)
Serves  robot/request: calibrate, move, mode, interaction, stop, park, idle, tune
When commands go silent the boards hold their last reference. When torques go silent for 60 ms
compliant joints are made stiff. What is not finite, out of order or too old is refused and counted;
hal.Robot keeps every limit.
"""

from collections import Counter
from collections.abc import Callable, Mapping

from hal.buses.bus import FrameBus
from hal.readings import ForceTorqueSample
from hal.robot import Robot
from hal.tasks import Task
from services.board_news import Reports, bus_statuses
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import ImpedanceOffset, JointCommand, JointState, Reply, Vector3, Wrench
from services.robot_messages import RobotRequest, RobotStatus
from services.robotfile.rates import Rates
from services.robotfile.robot_tables import RobotFile
from services.robotfile.wiring import parked, robot_description
from services.streams import (
    IMPEDANCE_OFFSET,
    JOINT_COMMAND,
    JOINT_STATE,
    ROBOT_CALL,
    ROBOT_STATUS,
    TORQUE_ESTIMATE,
    WRENCH,
)
from services.tuning_requests import TuningError, tuning_of
from services.wholebody.sensor_streams import LOOK_HZ, SensorStreams

STATUS_HZ = 50
COMMAND_AGE_NS = 100_000_000  # ten control periods: a command older than this is history
FAILURES_KEPT = 8


class RobotService(Service):
    """Drives one hal.Robot."""

    serves = (ROBOT_CALL,)

    def __init__(
        self,
        robot: RobotFile,
        buses: Mapping[int, FrameBus],
        rates: Rates,
        clock: Callable[[], int] | None = None,
    ) -> None:
        self._robot = robot
        description = robot_description(robot)
        self._hal = Robot(description, buses, clock)
        self._reports = Reports()
        self._parts = {
            part: [self._hal.joint_index(joint) for joint in joints]
            for part, joints in robot.parts.items()
        }
        self._sensor_streams = SensorStreams(self._hal)
        self._sensors = tuple(sensor.name for sensor in description.sensors)
        self.trigger = Period(1.0 / rates.hal_hz)
        self._wrench_every = rates.steps_per_message(rates.wrench_hz)
        self._state_every = rates.steps_per_message(rates.joint_state_hz)
        self._look_every = rates.steps_per_message(LOOK_HZ)
        self._status_every = rates.steps_per_message(STATUS_HZ)
        self._tasks: dict[int, Task] = {}
        self._last_task = 0
        self._finished = 0
        self._failures: list[tuple[int, str]] = []
        self._newest_ns: dict[tuple[str, str], int] = {}  # stamps taken, by kind and part
        self._refusals: Counter[str] = Counter()
        self._steps = 0
        self.reads = tuple(
            stream[part]
            for part in self._parts
            for stream in (JOINT_COMMAND, TORQUE_ESTIMATE, IMPEDANCE_OFFSET)
        )
        self.writes = (
            *(JOINT_STATE[part] for part in self._parts),
            *(WRENCH[sensor] for sensor in self._sensors),
            *self._sensor_streams.streams,
            ROBOT_STATUS,
        )

    @property
    def faults(self) -> tuple[str, ...]:
        """Texts of the last faults, newest last."""
        return tuple(fault.text for fault in self._hal.fault_events)

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """Take in set-points and torques, run the HAL, publish what is due."""
        self._serve(inputs, outputs)
        self._take_inputs(now_ns, inputs)
        self._hal.step(now_ns)
        self._collect_tasks()
        self._steps += 1
        self._publish(now_ns, outputs)

    def close(self, now_ns: int, outputs: Outputs) -> None:  # noqa: ARG002
        """Every axis idle, boards silent."""
        self._hal.close(now_ns)

    def _take_inputs(self, now_ns: int, inputs: Inputs) -> None:
        for part, joints in self._parts.items():
            command = inputs.new(JOINT_COMMAND[part])
            if command is not None:
                self._take_command(now_ns, part, joints, command)
            estimate = inputs.new(TORQUE_ESTIMATE[part])
            if estimate is not None:
                self._hal.set_joint_torques(joints, estimate.tau_nm, estimate.arrival_ns)
            offset = inputs.new(IMPEDANCE_OFFSET[part])
            if offset is not None:
                self._take_offset(now_ns, part, joints, offset)

    def _publish(self, now_ns: int, outputs: Outputs) -> None:
        if self._steps % self._state_every == 0:
            for part, joints in self._parts.items():
                outputs.put(JOINT_STATE[part], self._joint_state(now_ns, joints))
        if self._steps % self._wrench_every == 0:
            for sensor in self._sensors:
                samples = self._hal.take_samples(sensor)
                if samples:
                    outputs.put(WRENCH[sensor], averaged(now_ns, samples))
        if self._steps % self._look_every == 0:
            self._sensor_streams.publish(now_ns, outputs)
        if self._steps % self._status_every == 0:
            outputs.put(ROBOT_STATUS, self._status(now_ns))

    def _serve(self, inputs: Inputs, outputs: Outputs) -> None:
        for token, asked in inputs.requests(ROBOT_CALL):
            task = self._start(parked(self._robot, asked))
            self._last_task += 1
            self._tasks[self._last_task] = task
            refused = task.done and not task.ok
            outputs.reply(
                ROBOT_CALL, token, Reply(ok=not refused, reason=task.reason, task=self._last_task)
            )

    def _start(self, request: RobotRequest) -> Task:
        if request.action != "tune":
            return self._hal.request(
                request.action, request.joints, request.value, request.q_rad, request.duration_s
            )
        try:
            joint, change = tuning_of(request)
        except TuningError as error:
            return Task.refused("tune", str(error))
        return self._hal.tune(joint, change)

    def _collect_tasks(self) -> None:
        if not self._tasks:
            return
        for number, task in list(self._tasks.items()):
            if task.done:
                del self._tasks[number]
                if not task.ok:
                    self._failures.append((number, f"{task.action}: {task.reason}"))
                    del self._failures[:-FAILURES_KEPT]
        self._finished = min(self._tasks, default=self._last_task + 1) - 1

    def _is_in_time(self, kind: str, part: str, stamp_ns: int, now_ns: int) -> bool:
        """Whether a message is newer than the last one taken and young enough; if not, counted."""
        if stamp_ns <= self._newest_ns.get((kind, part), -1):
            self._refusals[f"{kind} out of order"] += 1
        elif now_ns - stamp_ns > COMMAND_AGE_NS:
            self._refusals[f"{kind} too old"] += 1
        elif stamp_ns - now_ns > COMMAND_AGE_NS:  # taken in, it would shut out all others
            self._refusals[f"{kind} from the future"] += 1
        else:
            return True
        return False

    def _take_command(
        self, now_ns: int, part: str, joints: list[int], command: JointCommand
    ) -> None:
        if not self._is_in_time("command", part, command.stamp_ns, now_ns):
            return
        if command.joints:
            named = {name: j for j, name in zip(joints, self._robot.parts[part], strict=True)}
            if not named.keys() >= set(command.joints):
                self._refusals[f"command for joints that {part} has not got"] += 1
                return
            joints = [named[name] for name in command.joints]
        self._newest_ns["command", part] = command.stamp_ns
        if command.mode == "direct":
            self._hal.set_positions(joints, command.q_rad)
        elif command.mode == "velocity":
            self._hal.set_velocities(joints, command.dq_rad_s)
        elif command.mode == "torque":
            self._hal.set_torques(joints, command.tau_nm)
        elif command.mode == "pwm":
            self._hal.set_duties(joints, command.duty_percent)
        else:
            self._refusals[f"unknown command mode {command.mode!r}"] += 1

    def _take_offset(
        self, now_ns: int, part: str, joints: list[int], offset: ImpedanceOffset
    ) -> None:
        if self._is_in_time("impedance offset", part, offset.stamp_ns, now_ns):
            self._newest_ns["impedance offset", part] = offset.stamp_ns
            self._hal.set_impedance_offsets(joints, offset.tau_nm)

    def _joint_state(self, now_ns: int, joints: list[int]) -> JointState:
        readings = self._hal.joints
        return JointState(
            stamp_ns=now_ns,
            q_rad=tuple([readings.q_rad[j] for j in joints]),
            dq_rad_s=tuple([readings.dq_rad_s[j] for j in joints]),
            tau_nm=tuple([readings.tau_nm[j] for j in joints]),
            control_mode=tuple([int(readings.control_mode[j]) for j in joints]),
            compliant=tuple([readings.compliant[j] for j in joints]),
            valid=all(self._hal.is_fresh(j, now_ns) for j in joints),
        )

    def _status(self, now_ns: int) -> RobotStatus:
        status = self._hal.status()
        refusals = Counter(dict(status.refusals)) + self._refusals
        return RobotStatus(
            stamp_ns=now_ns,
            phase=status.phase,
            calibrated=status.calibrated,
            compliant=status.compliant,
            faults=status.faults,
            fault_count=status.fault_count,
            frames_received=status.frames_received,
            frames_sent=status.frames_sent,
            frames_lost=status.frames_lost,
            frames_dropped=status.frames_dropped,
            drops=status.drops,
            refused_commands=status.refused_commands + self._refusals.total(),
            torque_loop_ms=status.torque_loop_ms,
            foreign_frames=status.foreign_frames,
            busy=status.busy or bool(self._tasks),
            refusals=tuple(sorted(refusals.items())),
            finished_task=self._finished,
            failed_tasks=tuple(self._failures),
            clamped=status.clamped,
            boards=self._reports.boards(status.boards),
            buses=bus_statuses(status.buses),
            calibration=status.calibration,
        )


def averaged(now_ns: int, samples: list[ForceTorqueSample]) -> Wrench:
    """Mean of the samples of one publishing period; a single one is passed on as it is."""
    newest = samples[-1]
    if len(samples) == 1:
        force, torque = newest.force_n, newest.torque_nm
    else:
        force = _mean([sample.force_n for sample in samples])
        torque = _mean([sample.torque_nm for sample in samples])
    return Wrench(
        stamp_ns=now_ns,
        force_n=force,
        torque_nm=torque,
        arrival_ns=newest.arrival_ns,
        saturated=any(sample.saturated for sample in samples),
        samples=len(samples),
        frozen=any(sample.frozen for sample in samples),
    )


def _mean(rows: list[Vector3]) -> Vector3:
    x, y, z = (sum(column) / len(rows) for column in zip(*rows, strict=True))
    return (x, y, z)


def build(context: Context) -> RobotService:
    """Open every bus of the robot file."""
    robot = load_robot(context.robot)
    buses = {bus.number: context.open_bus(bus.number, bus.channel) for bus in robot.buses.values()}
    return RobotService(robot, buses, Rates.live(robot), context.clock.now_ns)


if __name__ == "__main__":
    raise SystemExit(run_process("robot", build))
