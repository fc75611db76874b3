"""The second pair of hands: makes the limbs safe when the process that drives them is silent.

It has its own bus handles, sends nothing until asked, and lets in POSITION, STATUS,
ADDITIONAL_STATUS and replies only.
"""

from collections.abc import Mapping, Sequence

from hal.axis import Axis
from hal.buses.bus import FrameBus
from hal.description import RobotDescription
from hal.machine import Machine
from hal.motion import idle, stop
from hal.requests import wrong_posture
from hal.tasks import Sequence as Steps
from hal.tasks import Task, Tasks, together
from hal.wire import motor
from hal.wire.can import CLASS_MOTOR_PERIODIC, CLASS_MOTOR_POLLING, HOST, frame_id
from hal.wire.modes import ControlMode, InteractionMode
from hal.wire.motor_periodic import ADDITIONAL_STATUS, POSITION, STATUS

TRIES = 10
TRY_NS = 20_000_000
ANY_SOURCE_MASK = 0x70F


class Guard:
    """Switches axes without knowing what they were doing. A request ends the previous one."""

    def __init__(self, description: RobotDescription, buses: Mapping[int, FrameBus]) -> None:
        """`buses` by bus number, handles of its own; their filters are set.

        Raises:
            DescriptionError: a bus is missing, a board type is unknown, or a joint has no board.
        """
        heard = [
            frame_id(CLASS_MOTOR_PERIODIC, HOST, message.type)
            for message in (POSITION, STATUS, ADDITIONAL_STATUS)
        ]
        heard.append(frame_id(CLASS_MOTOR_POLLING, HOST, HOST))
        for bus in buses.values():
            bus.set_filters([{"can_id": can_id, "can_mask": ANY_SOURCE_MASK} for can_id in heard])
        self._machine = Machine(description, buses)
        self._tasks = Tasks()

    def step(self, now_ns: int) -> None:
        """Once per millisecond: listen, resume what was asked, send."""
        self._machine.receive(now_ns)
        self._tasks.step()
        self._machine.flush()

    def make_stiff(self, now_ns: int) -> Task:
        """Every axis that could be compliant becomes stiff.

        The first commands leave at once, and again each 20 ms until the board confirms.
        """
        axes = [axis for axis in self._machine.axes if axis.can_be_compliant]
        return self._start("stiff", now_ns, axes, together([_stiff(axis) for axis in axes]))

    def stop(self, now_ns: int, joints: Sequence[str] = (), q_rad: Sequence[float] = ()) -> Task:
        """Stiff, position mode, move to a posture (none = stay), idle; 3.2 s at most.

        A posture that does not fit is not taken; the limbs are stopped where they are.
        """
        axes = [self._machine.axes[i] for i in self._machine.indices(tuple(joints))]
        posture = list(q_rad) if q_rad and not wrong_posture(axes, q_rad) else []
        return self._start("stop", now_ns, axes, _stop(axes, posture))

    def idle_all(self, now_ns: int) -> Task:
        """All power off at once."""
        axes = list(self._machine.axes)
        for axis in axes:
            axis.send(motor.SET_CONTROL_MODE, ControlMode.FORCE_IDLE)
        return self._start("idle", now_ns, axes, idle(axes))

    def close(self) -> None:
        """Break off what is under way; the buses are closed by whoever opened them."""
        self._tasks.end_all("the guard is closed")

    def _start(self, action: str, now_ns: int, axes: list[Axis], sequence: Steps) -> Task:
        self._machine.now_ns = now_ns
        for line in self._machine.lines.values():
            line.now_ns = now_ns
        self._tasks.end_all(f"ended by {action}")
        task = self._tasks.start(Task(action, [axis.index for axis in axes], sequence))
        self._machine.flush()
        return task


def _stiff(axis: Axis) -> Steps:
    axis.interaction = InteractionMode.UNKNOWN
    for _ in range(TRIES):
        axis.send(motor.SET_INTERACTION_MODE, InteractionMode.STIFF)
        axis.send(motor.GET_INTERACTION_MODE)
        deadline_ns = axis.line.now_ns + TRY_NS
        while axis.line.now_ns < deadline_ns:
            yield
            if axis.interaction == InteractionMode.STIFF:
                return ""
    return f"{axis.name} did not become stiff"


def _stop(axes: list[Axis], q_rad: list[float]) -> Steps:
    """Ask for the states first: the guard has not heard what was set before it listened."""
    yield from together([_known(axis) for axis in axes])
    yield from together([_stiff(axis) for axis in axes if axis.is_powered])
    reason = yield from stop(axes, q_rad)
    return reason


def _known(axis: Axis) -> Steps:
    axis.mode = ControlMode.NO_REQUEST
    for _ in range(TRIES):
        axis.send(motor.GET_CALIBRATION_STATUS)
        deadline_ns = axis.line.now_ns + TRY_NS
        while axis.line.now_ns < deadline_ns:
            yield
            if axis.mode != ControlMode.NO_REQUEST:
                return ""
    return f"{axis.name} does not answer"
