"""The robot as the host sees it: joints and sensors in SI units, over CAN buses handed in.

A Robot has no clock and no thread: `step(now_ns)` once per millisecond polls the buses, resumes
what is under way, watches deadlines and sends what is due. Set-points and torques given between two
steps leave with the next step.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import TypeVar, overload

from hal.buses.bus import FrameBus
from hal.commands import Commands
from hal.description import RobotDescription
from hal.errors import DescriptionError
from hal.faults import Fault
from hal.foreign import ForeignHost
from hal.liveness import Liveness
from hal.machine import Machine
from hal.readings import ForceTorqueSample, HalStatus, JointReadings
from hal.requests import Requests
from hal.setpoints import Setpoints
from hal.startup import Startup
from hal.tasks import Task, Tasks
from hal.tuning import Tuning
from hal.wire import motor
from hal.wire.modes import ControlMode

Sample = TypeVar("Sample")

KEPT_LOOP_TIMES = 4096
KEPT_SAMPLES = 256
TOLD_FAULTS = 32  # in a status; fault_events has all that are kept
FRESH_NS = 100_000_000


class Robot:
    """Configures, commands and supervises every board of one robot.

    Opening starts with the first step: phases opening, handshake, configuring, then idle (every
    axis off), or failed with the reason in `status().faults`. `joints` holds the state of every
    joint in description order; step() updates it in place.
    """

    def __init__(
        self,
        description: RobotDescription,
        buses: Mapping[int, FrameBus],
        clock: Callable[[], int] | None = None,
    ) -> None:
        """`buses` by bus number, already open; `clock` stamps the end of torque_loop_ms only.

        Without a clock that end is the step's `now_ns`.

        Raises:
            DescriptionError: a board's bus is not there, its type is unknown, or a joint has no
            board.
        """
        self.description = description
        self._machine = machine = Machine(description, buses)
        self.joints: JointReadings = machine.readings
        timeout_s = description.velocity_timeout_ms / 1000.0
        self._setpoints = tuple(Setpoints(axis, machine.faults, timeout_s) for axis in machine.axes)
        self._tasks = Tasks()
        self._requests = Requests(machine, self._tasks)
        self._commands = Commands(machine, self._setpoints)
        self._liveness = Liveness(machine)
        self._foreign = ForeignHost(machine, self._setpoints)
        self._startup = Startup(machine)
        self._opening = Task("open", (), self._startup.run())
        self._clock = clock
        self._loop_ms: list[float] = []
        self._untaken: dict[str, list[object]] = {}

    @property
    def phase(self) -> str:
        """opening, handshake, configuring, idle, calibrating, ready, stopping or failed."""
        if not self._opening.done:
            return self._startup.phase
        if not self._opening.ok:
            return "failed"
        actions = self._tasks.actions
        if "stop" in actions:
            return "stopping"
        if "calibrate" in actions:
            return "calibrating"
        return "ready" if any(axis.is_powered for axis in self._machine.axes) else "idle"

    def joint_index(self, name: str) -> int:
        """Position of a joint in description order.

        Raises:
            DescriptionError: unknown name; the known ones are listed.
        """
        return self._machine.indices((name,))[0]

    def step(self, now_ns: int) -> None:
        """One millisecond: receive, decode, resume sequences, watch deadlines, send."""
        machine, commands = self._machine, self._commands
        machine.stalls.note(now_ns)
        machine.receive(now_ns)
        if not self._opening.done:
            self._open(now_ns)
        self._tasks.step()
        self._liveness.step(now_ns, boards_talk=self._opening.done and self._opening.ok)
        self._foreign.step(now_ns)
        for sensor in machine.virtual_sensors:
            sensor.step(now_ns)
        for setpoints in self._setpoints:
            if setpoints.due_ns <= now_ns:
                setpoints.step(now_ns)
        machine.flush()
        if commands.arrivals_ns:
            sent_ns = now_ns if self._clock is None else self._clock()
            self._loop_ms += [(sent_ns - arrival_ns) / 1e6 for arrival_ns in commands.arrivals_ns]
            commands.arrivals_ns.clear()
            del self._loop_ms[:-KEPT_LOOP_TIMES]

    def _open(self, now_ns: int) -> None:
        self._opening.resume()
        if self._opening.done and self._opening.ok:
            self._liveness.start(self._startup.unavailable)
        elif self._opening.done:
            self._machine.faults.report(now_ns, self._opening.reason)

    def status(self) -> HalStatus:
        """Phase, faults, counters, and the torque_loop_ms samples since the previous call."""
        machine, faults = self._machine, self._machine.faults
        lines = machine.lines.values()
        skipped = max(0, len(faults.events) - TOLD_FAULTS)
        loop_ms, self._loop_ms = tuple(self._loop_ms), []
        return HalStatus(
            phase=self.phase,
            calibrated=all(self.joints.calibrated),
            compliant=tuple(axis.name for axis in machine.axes if axis.is_compliant),
            faults=tuple(fault.text for fault in islice(faults.events, skipped, None)),
            fault_count=faults.count,
            frames_received=sum(line.frames_received for line in lines),
            frames_sent=sum(line.frames_sent for line in lines),
            frames_lost=sum(line.frames_lost for line in lines),
            frames_dropped=sum(faults.drops.values()),
            drops=tuple(faults.drops.items()),
            refused_commands=sum(faults.refusals.values()),
            refusals=tuple(faults.refusals.items()),
            clamped=tuple(faults.clamps.items()),
            torque_loop_ms=loop_ms,
            foreign_frames=self._foreign.count,
            busy=bool(self._tasks.actions) or not self._opening.done,
            boards=machine.inventory.reports(),
            buses=tuple(line.report() for line in lines),
            calibration=tuple((axis.name, axis.calibration) for axis in machine.axes),
        )

    @property
    def fault_events(self) -> tuple[Fault, ...]:
        """The last faults with time and evidence, newest last."""
        return tuple(self._machine.faults.events)

    @property
    def sensors(self) -> dict[str, tuple[str, ...]]:
        """Names of the sensors by kind: force_torque, hall, skin, inertial, imu."""
        return self._machine.sensors_by_kind()

    @overload
    def take_samples(self, sensor: str) -> list[ForceTorqueSample]: ...

    @overload
    def take_samples(self, sensor: str, kind: type[Sample]) -> list[Sample]: ...

    def take_samples(self, sensor: str, kind: type = ForceTorqueSample) -> Sequence[object]:
        """Samples of one kind since the previous call for it, oldest first.

        The last 256 of all kinds are kept. `sensors` tells names and kinds.

        Raises:
            DescriptionError: no such sensor; the known ones are listed.
        """
        if sensor not in self._machine.sensors:
            known = ", ".join(self._machine.sensors)
            raise DescriptionError(f"unknown sensor {sensor!r}; known: {known}")
        samples = [*self._untaken.get(sensor, ()), *self._machine.sensors[sensor].take()]
        taken = [sample for sample in samples if isinstance(sample, kind)]
        if len(taken) < len(samples):
            samples = [sample for sample in samples if not isinstance(sample, kind)]
            self._untaken[sensor] = samples[-KEPT_SAMPLES:]
        elif sensor in self._untaken:
            del self._untaken[sensor]
        return taken

    def is_fresh(self, joint: int, now_ns: int) -> bool:
        """Whether a joint is calibrated and was heard within the last 100 ms."""
        joints = self.joints
        age_ns = self._machine.stalls.age_ns(now_ns, joints.heard_ns[joint])
        return joints.calibrated[joint] and age_ns <= FRESH_NS

    def set_positions(self, joints: Sequence[int], q_rad: Sequence[float]) -> bool:
        """Position-direct references.

        False when refused: not finite, wrong length, or a joint not in direct mode.

        Clamped to the limits and moved there at max_velocity at most, from where the joint was last
        told to be.
        """
        return self._commands.set_positions(joints, q_rad)

    def set_velocities(self, joints: Sequence[int], dq_rad_s: Sequence[float]) -> bool:
        """Velocity references; the board drops them 100 ms after the last. False when refused."""
        return self._commands.set_velocities(joints, dq_rad_s)

    def set_torques(self, joints: Sequence[int], tau_nm: Sequence[float]) -> bool:
        """Torque references; after 100 ms without a new one the joints go to position mode.

        False when refused.
        """
        return self._commands.set_torques(joints, tau_nm)

    def set_duties(self, joints: Sequence[int], duty_percent: Sequence[float]) -> bool:
        """Open-loop PWM in percent of the bridge's full scale, in the board's own sign.

        False when refused. After 100 ms without a new one, and near a limit, the joints go to
        position mode.
        """
        return self._commands.set_duties(joints, duty_percent)

    def set_joint_torques(
        self, joints: Sequence[int], tau_nm: Sequence[float], arrival_ns: int
    ) -> bool:
        """Estimated joint torques for the boards; `arrival_ns` of the FT sample behind them.

        False when refused (not finite or wrong length). 60 ms without one: compliant joints are
        made stiff.
        """
        return self._commands.set_joint_torques(joints, tau_nm, arrival_ns)

    def set_impedance_offsets(self, joints: Sequence[int], tau_nm: Sequence[float]) -> bool:
        """Torque that a compliant joint adds to its spring (gravity). False when refused."""
        return self._commands.set_impedance_offsets(joints, tau_nm)

    def request(
        self,
        action: str,
        joints: Sequence[str] = (),
        value: str = "",
        q_rad: Sequence[float] = (),
        duration_s: float = 0.0,
    ) -> Task:
        """Start something that takes time; the Task tells when it is done and why it failed.

        No joints means all. Actions:
            calibrate: in the groups of Calibration.order; ends in position mode, stiff. Joints
                that are calibrated are only switched on, unless value is "again".
            move: to q_rad in duration_s, slower where max_velocity says so; not from idle.
            mode: value idle, position, direct, velocity, torque, pwm; idle leaves a hardware fault.
            interaction: value stiff or compliant.
            stop: stiff, position mode, move to q_rad (empty = stay), idle; 3 s at most.
            park: the same with a q_rad, but duration_s at most (30 s at most, and where it is 0).
            idle: all power off at once.

        Stop and idle end every other task.
        """
        reason = "" if action == "idle" else self._not_open()
        if reason:
            return Task.refused(action, reason)
        return self._requests.take(action, joints, value, q_rad, duration_s)

    def tune(self, joint: str, change: Tuning) -> Task:
        """Change gains, impedance or a limit of one joint; done when the board has confirmed it."""
        reason = self._not_open()
        return Task.refused("tune", reason) if reason else self._requests.tune(joint, change)

    def _not_open(self) -> str:
        if not self._opening.done:
            return f"the robot is still in phase {self._startup.phase}"
        return "" if self._opening.ok else f"the robot has failed: {self._opening.reason}"

    def close(self, now_ns: int) -> None:
        """Every axis idle, broadcasts and sensors silent, sent at once; the buses stay open."""
        self._tasks.end_all("the robot is closed")
        for line in self._machine.lines.values():
            line.now_ns = now_ns
            line.discard()
        for board in self._machine.boards:
            frames = [
                motor.SET_CONTROL_MODE.request(axis.address, axis.number, ControlMode.FORCE_IDLE)
                for axis in board.axes
            ]
            board.line.send_directly([*frames, *board.quiesce()])
