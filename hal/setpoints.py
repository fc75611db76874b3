"""Set-points of one axis on their way to its board: limits, speed limit, one frame per 10 ms.

Position-direct references are clamped to the joint's limits and approached from the last one sent
at the joint's maximal velocity, so that no caller can make an axis jump. Every change of mode
forgets what was wanted before.
"""

import math

from hal.axis import Axis
from hal.boards.settings import impedance_setting
from hal.faults import FaultLog
from hal.torques import make_stiff
from hal.wire import motor
from hal.wire.modes import ControlMode
from hal.wire.numbers import round_half_away

CYCLE_NS = 10_000_000
REPEAT_NS = 100_000_000  # an unchanged reference, in case a frame was lost
BRAKING_S = 0.6  # towards a limit: the slowest of the boards' position loops settle in this
CREEP_TICKS = 0.2  # so that the limit itself is reached
_DIRECT = int(ControlMode.DIRECT)  # compared each millisecond
TORQUE_AGE_NS = 100_000_000  # the boards have no time-out of their own in torque mode
ACCELERATION = 1  # least value of VELOCITY_MOVE; with shift 8 any real acceleration is below 1


class Setpoints:
    """What one axis is asked to do. Setters take SI units and finite numbers only."""

    __slots__ = (
        "_axis",
        "_cycle_ns",
        "_faults",
        "_limit_ticks",
        "_look_ahead_s",
        "_max_step_ticks",
        "_offset_cycle_ns",
        "_offset_due",
        "_reached_ticks",
        "_repeat_ns",
        "_room_per_cycle",
        "_target_ticks",
        "_torque_counts",
        "_torque_ns",
        "_velocity_rad_s",
    )

    def __init__(self, axis: Axis, faults: FaultLog, velocity_timeout_s: float) -> None:
        """`velocity_timeout_s`: how long the board keeps a velocity, so how far ahead to look."""
        self._look_ahead_s = max(velocity_timeout_s, BRAKING_S)
        self._axis = axis
        self._faults = faults
        units = axis.units
        speed_ticks_s = abs(units.ticks_per_rad) * units.max_velocity_rad_s
        self._max_step_ticks = speed_ticks_s * CYCLE_NS / 1e9  # not whole: 30 deg/s is 3.4 ticks
        self._limit_ticks = (units.low_ticks, units.high_ticks)
        self._room_per_cycle = CYCLE_NS / 1e9 / BRAKING_S
        self._cycle_ns = 0
        self._repeat_ns = 0
        self._offset_cycle_ns = 0
        self._offset_due = False
        self._torque_ns = 0
        self.forget()
        axis.on_change = self.on_change

    def forget(self) -> None:
        """The board has set its reference to the present position and everything else to zero."""
        self._reached_ticks = float(self._axis.ticks)  # where the reference has got to
        self._target_ticks: int | None = None
        self._velocity_rad_s: float | None = None
        self._torque_counts: int | None = None
        self._torque_ns = self._axis.line.now_ns

    def on_change(self) -> None:
        """The mode has changed: the offset is gone on the board, send it and the spring again."""
        self.forget()
        axis = self._axis
        if axis.is_compliant and axis.can_be_compliant:
            row, values = impedance_setting(axis)
            axis.command(row, *values)
            self._offset_due = True
            self._offset_cycle_ns = 0

    def write_again(self) -> None:
        """Somebody else may have moved the reference."""
        self._repeat_ns = 0

    def set_position(self, q_rad: float) -> None:
        """Position-direct reference."""
        units = self._axis.units
        if not units.min_rad <= q_rad <= units.max_rad:
            self._faults.clamp("position")
        self._target_ticks = units.limited_ticks(q_rad)

    def set_velocity(self, dq_rad_s: float) -> None:
        """Velocity reference, good for one VELOCITY_MOVE."""
        self._velocity_rad_s = dq_rad_s

    def set_torque(self, tau_nm: float, now_ns: int) -> None:
        """Torque reference."""
        self._torque_counts = self._limited_torque(tau_nm, "torque")
        self._torque_ns = now_ns

    def set_offset(self, tau_nm: float) -> None:
        """Torque that the board adds to the spring of a compliant axis."""
        self._axis.offset_counts = self._limited_torque(tau_nm, "impedance offset")
        self._offset_due = True

    def _limited_torque(self, tau_nm: float, cause: str) -> int:
        units = self._axis.units
        if abs(tau_nm) > units.torque_limit_nm:
            self._faults.clamp(cause)
        return units.torque_counts(tau_nm)

    def step(self, now_ns: int) -> None:
        """Send what is due."""
        axis = self._axis
        if axis.switching:
            return
        if self._offset_due and axis.is_compliant and now_ns >= self._offset_cycle_ns:
            self._offset_due = False
            self._offset_cycle_ns = _next_cycle_ns(self._offset_cycle_ns, now_ns)
            axis.send(motor.SET_IMPEDANCE_OFFSET, axis.offset_counts)
        if now_ns < self._cycle_ns:
            return
        if axis.mode == _DIRECT:
            self._send_position(now_ns)
        elif axis.mode == ControlMode.VELOCITY:
            self._send_velocity(now_ns)
        elif axis.mode == ControlMode.TORQUE:
            self._send_torque(now_ns)

    def _send_position(self, now_ns: int) -> None:
        target = self._target_ticks
        if target is None or (target == self._reached_ticks and now_ns < self._repeat_ns):
            return
        step = target - self._reached_ticks
        allowed = self._allowed_step(step)
        if abs(step) > allowed:
            self._faults.clamp("speed of position")
            self._reached_ticks += math.copysign(allowed, step)
        else:
            self._reached_ticks = target
        self._sent(now_ns)
        self._axis.send(motor.SET_COMMAND_POSITION, round_half_away(self._reached_ticks))

    def _allowed_step(self, step: float) -> float:
        """Largest change of one cycle in the direction of `step`, ticks.

        The board's loop trails a moving reference and then runs past where it stops. So towards a
        limit the reference slows down with the room that is left.
        """
        low, high = self._limit_ticks
        room = high - self._reached_ticks if step > 0 else self._reached_ticks - low
        braked = max(room, 0.0) * self._room_per_cycle + CREEP_TICKS
        return min(self._max_step_ticks, braked)

    def _send_velocity(self, now_ns: int) -> None:
        wanted, self._velocity_rad_s = self._velocity_rad_s, None
        if wanted is None:
            return
        axis, units = self._axis, self._axis.units
        q_rad = units.q_rad(axis.ticks)
        room_up = max(units.max_rad - q_rad, 0.0) / self._look_ahead_s
        room_down = max(q_rad - units.min_rad, 0.0) / self._look_ahead_s
        highest = min(room_up, units.max_velocity_rad_s)
        lowest = -min(room_down, units.max_velocity_rad_s)
        allowed = min(max(wanted, lowest), highest)
        if allowed != wanted:
            self._faults.clamp("velocity")
        self._sent(now_ns)
        axis.send(motor.VELOCITY_MOVE, units.velocity_counts(allowed), ACCELERATION)

    def _send_torque(self, now_ns: int) -> None:
        axis = self._axis
        if now_ns - self._torque_ns > TORQUE_AGE_NS:
            text = (
                f"no torque set-point for {TORQUE_AGE_NS / 1e9:.1f} s: {axis.name} to position mode"
            )
            self._faults.report(now_ns, text, text)
            self._cycle_ns = now_ns + CYCLE_NS
            make_stiff(axis)
            return
        if self._torque_counts is not None:
            axis.send(motor.SET_DESIRED_TORQUE, self._torque_counts)
            self._torque_counts = None
            self._sent(now_ns)

    def _sent(self, now_ns: int) -> None:
        self._cycle_ns = _next_cycle_ns(self._cycle_ns, now_ns)
        self._repeat_ns = now_ns + REPEAT_NS


def _next_cycle_ns(cycle_ns: int, now_ns: int) -> int:
    """Earliest next frame: on a 10 ms grid, restarted after a pause."""
    following_ns = cycle_ns + CYCLE_NS
    return following_ns if following_ns > now_ns else now_ns + CYCLE_NS
