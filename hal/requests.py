"""Requests to the robot: checked, then turned into tasks."""

import math
from collections.abc import Callable, Sequence

from hal.axis import Axis
from hal.calibration import calibrate, with_partners
from hal.checks import owner_of
from hal.errors import DescriptionError
from hal.machine import Machine
from hal.motion import idle, move, stop
from hal.registry import motor_board_type
from hal.switching import INTERACTIONS, MODES, switch_interaction, switch_mode
from hal.tasks import Sequence as Steps
from hal.tasks import Task, Tasks, together
from hal.tuning import Tuning, tune
from hal.units import AxisUnits
from hal.wire import motor
from hal.wire.modes import ControlMode, InteractionMode

Axes = list[Axis]
PARK_S = 30.0
AGAIN = "again"
# From a standstill a full torque takes an axis so far before anybody can tell and brake it.
TORQUE_ROOM_DEG = 5.0
SPRING_ROOM_DEG = 2.0  # the spring holds back
Prepared = Steps | str  # the work, or why it is refused


class Requests:
    """Answers requests for one machine."""

    def __init__(self, machine: Machine, tasks: Tasks) -> None:
        self._machine = machine
        self._tasks = tasks

    def take(
        self,
        action: str,
        joints: Sequence[str],
        value: str,
        q_rad: Sequence[float],
        duration_s: float,
    ) -> Task:
        """Start it, or refuse it with the reason."""
        prepare: dict[str, Callable[[Axes], Prepared]] = {
            "calibrate": lambda axes: self._calibrate(axes, value),
            "move": lambda axes: self._move(axes, q_rad, duration_s),
            "mode": lambda axes: self._mode(axes, value),
            "interaction": lambda axes: self._interaction(axes, value),
            "stop": lambda axes: self._stop(axes, q_rad),
            "park": lambda axes: self._park(axes, q_rad, duration_s),
            "idle": self._idle,
        }
        if action not in prepare:
            return self._refused(action, f"unknown action {action!r}; known: {', '.join(prepare)}")
        try:
            indices = self._machine.indices(tuple(joints))
        except DescriptionError as error:
            return self._refused(action, str(error))
        if len(set(indices)) != len(indices):
            return self._refused(action, "a joint is named twice")
        if action == "calibrate":
            indices = tuple(axis.index for axis in with_partners(self._chosen(indices)))
        if action in ("stop", "idle"):
            self._tasks.end_all(f"ended by {action}")
        conflict = self._tasks.conflict(indices)
        if conflict is not None:
            return self._refused(action, f"busy: {conflict.action} uses one of these joints")
        work = prepare[action](self._chosen(indices))
        if isinstance(work, str):
            return self._refused(action, work)
        return self._tasks.start(Task(action, indices, work))

    def tune(self, name: str, change: Tuning) -> Task:
        """Change a setting of one joint."""
        try:
            (index,) = self._machine.indices((name,))
        except DescriptionError as error:
            return self._refused("tune", str(error))
        conflict = self._tasks.conflict((index,))
        if conflict is not None:
            return self._refused("tune", f"busy: {conflict.action} uses this joint")
        axis = self._machine.axes[index]
        description = self._machine.description
        work: Prepared = _unavailable([axis])
        if not work:
            owner = motor_board_type(owner_of(description, axis.joint).type)
            work = tune(axis, change, description.joints[index], owner.max_current_ma)
        if isinstance(work, str):
            return self._refused("tune", work)
        return self._tasks.start(Task("tune", (index,), work))

    def _chosen(self, indices: Sequence[int]) -> Axes:
        return [self._machine.axes[index] for index in indices]

    def _refused(self, action: str, reason: str) -> Task:
        self._machine.faults.refuse(f"request {action}")
        return Task.refused(action, reason)

    def _calibrate(self, axes: Axes, value: str) -> Prepared:
        if value not in ("", AGAIN):
            return f"unknown value {value!r}; known: {AGAIN}"
        return _unavailable(axes) or calibrate(axes, again=value == AGAIN)

    def _move(self, axes: Axes, q_rad: Sequence[float], duration_s: float) -> Prepared:
        reason = _unavailable(axes) or wrong_posture(axes, q_rad)
        if not reason and not 0.0 <= duration_s < 3600.0:
            reason = f"duration_s {duration_s} is not within 0 and 3600"
        for axis in axes:
            if not reason and not axis.is_calibrated:
                reason = f"{axis.name} is not calibrated"
            if not reason and not axis.is_powered:
                reason = f"{axis.name} is {_mode_name(axis)}: request mode position first"
        return reason or move(axes, list(q_rad), duration_s)

    def _mode(self, axes: Axes, value: str) -> Prepared:
        mode = MODES.get(value)
        if mode is None:
            return f"unknown mode {value!r}; known: {', '.join(MODES)}"
        if mode == ControlMode.IDLE:
            return idle(axes)
        reason = _unavailable(axes)
        for axis in axes:
            if not reason and not axis.is_calibrated:
                reason = f"{axis.name} is not calibrated"
            if not reason and mode == ControlMode.TORQUE:
                reason = self._no_torques(axis)
            if not reason and mode == ControlMode.OPENLOOP:
                reason = _outside_limits(axis)
            if not reason and mode == ControlMode.TORQUE:
                reason = _too_near(axis, TORQUE_ROOM_DEG)
        return reason or together([switch_mode(axis, mode) for axis in axes])

    def _interaction(self, axes: Axes, value: str) -> Prepared:
        interaction = INTERACTIONS.get(value)
        if interaction is None:
            return f"unknown interaction {value!r}; known: {', '.join(INTERACTIONS)}"
        reason = _unavailable(axes)
        if interaction == InteractionMode.COMPLIANT:
            for axis in axes:
                reason = reason or self._no_torques(axis) or _too_near(axis, SPRING_ROOM_DEG)
        return reason or together([switch_interaction(axis, interaction) for axis in axes])

    def _no_torques(self, axis: Axis) -> str:
        """Why an axis cannot be force controlled now, empty when it can."""
        sensor = self._machine.torques_of(axis)
        if sensor is None or not axis.can_be_compliant:
            return f"{axis.name} has no torque source, torque gains or impedance in the robot file"
        if not sensor.is_fresh(self._machine.now_ns):
            return f"{axis.name}: no fresh joint torques"
        return ""

    def _stop(self, axes: Axes, q_rad: Sequence[float]) -> Prepared:
        reason = wrong_posture(axes, q_rad) if q_rad else ""
        if reason:  # stop all the same, where the limb is
            self._machine.faults.report(self._machine.now_ns, f"stop without moving: {reason}")
        return stop(axes, [] if reason else list(q_rad))

    def _park(self, axes: Axes, q_rad: Sequence[float], duration_s: float) -> Prepared:
        """A stop that takes its time; a posture that does not fit is refused, nothing is urgent."""
        limit_s = PARK_S if duration_s == 0.0 else duration_s
        reason = _unavailable(axes) or wrong_posture(axes, q_rad)
        if not reason and not 0.0 < limit_s <= PARK_S:
            reason = f"duration_s {duration_s} is not within 0 and {PARK_S:g}"
        return reason or stop(axes, list(q_rad), round(limit_s * 1e9))

    def _idle(self, axes: Axes) -> Prepared:
        for axis in axes:
            axis.wanted_mode = ControlMode.IDLE
            axis.send(motor.SET_CONTROL_MODE, ControlMode.FORCE_IDLE)
        return idle(axes)


def _unavailable(axes: Axes) -> str:
    for axis in axes:
        if not axis.is_available:
            return f"{axis.name}: {axis.fault_text or 'its board is silent'}"
    return ""


def _outside_limits(axis: Axis) -> str:
    q_rad = axis.units.q_rad(axis.ticks)
    if _within(axis.units, q_rad):
        return ""
    return f"{axis.name} is outside its limits at {q_rad:.4f} rad"


def _too_near(axis: Axis, room_deg: float) -> str:
    """Why force control may not begin where an axis stands, empty when it may."""
    reason = _outside_limits(axis)
    if reason:
        return reason
    units = axis.units
    q_rad = units.q_rad(axis.ticks)
    left_deg = math.degrees(min(q_rad - units.min_rad, units.max_rad - q_rad))
    if left_deg >= room_deg:
        return ""
    return (
        f"{axis.name} is {left_deg:.2f} deg from its limit, nearer than {room_deg:g}: move it first"
    )


def _mode_name(axis: Axis) -> str:
    try:
        return ControlMode(axis.mode).name.lower().replace("_", " ")
    except ValueError:
        return f"in unknown mode 0x{axis.mode:02X}"


def wrong_posture(axes: Axes, q_rad: Sequence[float]) -> str:
    """Why a posture cannot be taken, empty when it can."""
    if len(q_rad) != len(axes):
        return f"{len(q_rad)} angles for {len(axes)} joints"
    for axis, value in zip(axes, q_rad, strict=True):
        if not _within(axis.units, value):
            low, high = axis.units.min_rad, axis.units.max_rad
            return f"{axis.name}: {value:.4f} rad is outside {low:.4f} to {high:.4f}"
    return ""


def _within(units: AxisUnits, q_rad: float) -> bool:
    slack_rad = abs(units.rad_per_tick)  # a posture that was read back may be one tick outside
    return units.min_rad - slack_rad <= q_rad <= units.max_rad + slack_rad
