"""Set-points of one axis on their way to its board: limits, rates, one frame per 10 ms.

Position-direct references are clamped to the joint's limits and approached from the last one sent
at the joint's maximal velocity, so that no caller can make an axis jump. Every change of mode
forgets what was wanted before. An axis that nears a limit where no position loop holds it is made
stiff, and one whose board has taken a place beyond the limits as its reference is brought back.
"""

import math

from hal.axis import Axis
from hal.boards.settings import impedance_setting
from hal.faults import FaultLog
from hal.limiting import (
    BRAKING_S,
    COASTING_S,
    CYCLE_S,
    STOPPING_S,
    is_near_limit,
    limited_step,
    limited_velocity,
    position_step,
    speed_ahead,
)
from hal.returning import bring_back
from hal.torques import make_stiff
from hal.wire import motor
from hal.wire.modes import ControlMode
from hal.wire.numbers import round_half_away

CYCLE_NS = round(CYCLE_S * 1e9)
REPEAT_NS = 100_000_000  # an unchanged reference, in case a frame was lost
AGE_NS = 100_000_000  # the boards have no time-out of their own in torque and open-loop mode
ACCELERATION = 1  # least value of VELOCITY_MOVE; with shift 8 any real acceleration is below 1
WATCH_NS = 4_000_000  # POSITION frames come as often
NEVER_NS = 1 << 62
_DIRECT = int(ControlMode.DIRECT)  # compared each cycle
_UNTIMED = {ControlMode.TORQUE: "torque", ControlMode.OPENLOOP: "pwm"}


class Setpoints:
    """What one axis is asked to do. Setters take SI units and finite numbers only.

    `due_ns` is when step() has to be called next: an axis with nothing to do costs nothing.
    """

    __slots__ = (
        "_axis",
        "_cycle_ns",
        "_duty_counts",
        "_faults",
        "_given_ns",
        "_look_ahead_s",
        "_max_duty_step",
        "_max_step_ticks",
        "_max_torque_step",
        "_max_velocity_step",
        "_offset_cycle_ns",
        "_offset_due",
        "_reached",
        "_repeat_ns",
        "_rescue_ns",
        "_target_ticks",
        "_torque_counts",
        "_velocity_rad_s",
        "due_ns",
    )

    def __init__(self, axis: Axis, faults: FaultLog, velocity_timeout_s: float) -> None:
        """`velocity_timeout_s`: how long the board keeps a velocity, so how far ahead to look."""
        self._look_ahead_s = max(velocity_timeout_s, BRAKING_S)
        self._axis = axis
        self._faults = faults
        self._cycle_ns = 0
        self._repeat_ns = 0
        self._offset_cycle_ns = 0
        self._offset_due = False
        self._rescue_ns = 0
        self._given_ns = 0
        self.due_ns = 0
        self.limits_changed()
        self.forget()
        axis.on_change = self.on_change
        axis.on_limits = self.limits_changed

    def limits_changed(self) -> None:
        """The joint's rates were changed: steps of one cycle, in what the set-points count in."""
        axis, joint = self._axis, self._axis.joint
        units = axis.units
        # Not whole: 30 deg/s is 3.4 ticks.
        self._max_step_ticks = abs(units.ticks_per_rad) * units.max_velocity_rad_s * CYCLE_S
        self._max_velocity_step = units.max_acceleration_rad_s2 * CYCLE_S
        self._max_torque_step = joint.max_torque_rate_nm_s * units.torque_counts_per_nm * CYCLE_S
        self._max_duty_step = joint.max_duty_rate_percent_s / 100.0 * axis.full_pwm * CYCLE_S

    def forget(self) -> None:
        """The board has set its reference to the present position and everything else to zero."""
        # Where the last set-point has got to, in what the mode counts in: ticks in direct mode.
        self._reached = float(self._axis.ticks) if self._axis.mode == _DIRECT else 0.0
        self._target_ticks: int | None = None
        self._velocity_rad_s: float | None = None
        self._torque_counts: int | None = None
        self._duty_counts: int | None = None
        self._given_ns = self._axis.line.now_ns
        self.due_ns = 0

    def on_change(self) -> None:
        """The mode has changed: the offset is gone on the board, send it and the spring again."""
        self.forget()
        axis = self._axis
        if axis.is_compliant and axis.can_be_compliant:
            row, values = impedance_setting(axis)
            axis.command(row, *values)
            self._offset_due = True
            self._offset_cycle_ns = 0
        else:
            self._target_ticks = bring_back(axis)

    def write_again(self) -> None:
        """Somebody else may have moved the reference."""
        self._repeat_ns = 0
        self.due_ns = 0

    def set_position(self, q_rad: float) -> None:
        """Position-direct reference."""
        units = self._axis.units
        if not units.min_rad <= q_rad <= units.max_rad:
            self._faults.clamp("position")
        self._target_ticks = units.limited_ticks(q_rad)
        self.due_ns = 0

    def set_velocity(self, dq_rad_s: float) -> None:
        """Velocity reference, good for one VELOCITY_MOVE."""
        self._velocity_rad_s = dq_rad_s
        self.due_ns = 0

    def set_torque(self, tau_nm: float, now_ns: int) -> None:
        """Torque reference."""
        self._torque_counts = self._limited_torque(tau_nm, "torque")
        self._given_ns = now_ns
        self.due_ns = 0

    def set_duty(self, duty_percent: float, now_ns: int) -> None:
        """Open-loop PWM in percent of what the bridge can do, in the board's own sign."""
        axis = self._axis
        wanted = duty_percent / 100.0 * axis.full_pwm
        limit = axis.joint.pwm_limit
        if abs(wanted) > limit:
            self._faults.clamp("duty")
        self._duty_counts = round_half_away(min(max(wanted, -limit), limit))
        self._given_ns = now_ns
        self.due_ns = 0

    def set_offset(self, tau_nm: float) -> None:
        """Torque that the board adds to the spring of a compliant axis."""
        self._axis.offset_counts = self._limited_torque(tau_nm, "impedance offset")
        self._offset_due = True
        self.due_ns = 0

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
        self.due_ns = NEVER_NS
        if (axis.is_compliant or axis.mode in _UNTIMED) and axis.is_powered:
            if self._nears_limit(now_ns):
                return
            self._look_again(now_ns + WATCH_NS)
        if self._offset_due and axis.is_compliant:
            self._send_offset(now_ns)
        if now_ns < self._cycle_ns:
            self._look_again(self._cycle_ns)
        elif axis.mode == _DIRECT:
            self._send_position(now_ns)
        elif axis.mode == ControlMode.VELOCITY:
            self._send_velocity(now_ns)
        elif axis.mode in _UNTIMED:
            self._send_untimed(now_ns)

    def _nears_limit(self, now_ns: int) -> bool:
        """Whether the axis had to be made stiff: no reference keeps it from its limits."""
        axis, slack_rad = self._axis, abs(self._axis.units.rad_per_tick)
        motion, ahead_s = axis.motion, COASTING_S
        if axis.mode not in _UNTIMED:  # a spring may give way by half of what is left
            motion, ahead_s = (motion[0], speed_ahead(axis.units, axis.recent)), STOPPING_S
            slack_rad = max(slack_rad, math.radians(axis.joint.margin_deg / 2.0))
        if not is_near_limit(axis.units, motion, ahead_s, slack_rad):
            return False
        if now_ns < self._rescue_ns:  # under way
            self._look_again(self._rescue_ns)
            return True
        self._rescue_ns = now_ns + CYCLE_NS
        mode = _UNTIMED.get(ControlMode(axis.mode))
        how = "while compliant" if mode is None else f"in {mode} mode"
        self._give_up(now_ns, f"{axis.name} nears its limit {how}")
        return True

    def _look_again(self, at_ns: int) -> None:
        self.due_ns = min(self.due_ns, at_ns)

    def _send_offset(self, now_ns: int) -> None:
        if now_ns >= self._offset_cycle_ns:
            self._offset_due = False
            self._offset_cycle_ns = _next_cycle_ns(self._offset_cycle_ns, now_ns)
            self._axis.send(motor.SET_IMPEDANCE_OFFSET, self._axis.offset_counts)
        else:
            self._look_again(self._offset_cycle_ns)

    def _send_position(self, now_ns: int) -> None:
        target = self._target_ticks
        if target is None:
            return
        if target == self._reached and now_ns < self._repeat_ns:
            self._look_again(self._repeat_ns)
            return
        step = target - self._reached
        largest = position_step(self._axis.units, self._reached, step, self._max_step_ticks)
        self._reached = self._approach(target, largest, "speed of position")
        self._axis.send(motor.SET_COMMAND_POSITION, round_half_away(self._reached))
        self._sent(now_ns)
        self._look_again(self._repeat_ns if target == self._reached else self._cycle_ns)

    def _approach(self, wanted: float, largest_step: float, cause: str) -> float:
        reached = limited_step(wanted, self._reached, largest_step)
        if reached != wanted:
            self._faults.clamp(cause)
        return reached

    def _send_velocity(self, now_ns: int) -> None:
        wanted, self._velocity_rad_s = self._velocity_rad_s, None
        if wanted is None:
            return
        axis, units = self._axis, self._axis.units
        if now_ns >= self._repeat_ns:
            self._reached = 0.0  # the board has let the last one go
        allowed = limited_velocity(units, units.q_rad(axis.ticks), wanted, self._look_ahead_s)
        if allowed != wanted:
            self._faults.clamp("velocity")
        # Braking for a limit is never slowed down.
        if abs(allowed) > abs(self._reached):
            allowed = self._approach(allowed, self._max_velocity_step, "acceleration")
        self._reached = allowed
        self._sent(now_ns)
        axis.send(motor.VELOCITY_MOVE, units.velocity_counts(allowed), ACCELERATION)

    def _send_untimed(self, now_ns: int) -> None:
        """Torque and open loop: the host watches the age."""
        axis = self._axis
        name = _UNTIMED[ControlMode(axis.mode)]
        if now_ns - self._given_ns > AGE_NS:
            self._give_up(now_ns, f"no {name} set-point for {AGE_NS / 1e9:.1f} s")
            return
        if self._torque_counts is not None and axis.mode == ControlMode.TORQUE:
            largest = self._max_torque_step
            self._reached = self._approach(self._torque_counts, largest, "rate of torque")
            axis.send(motor.SET_DESIRED_TORQUE, round_half_away(self._reached))
            if self._reached == self._torque_counts:
                self._torque_counts = None
            self._sent(now_ns)
        elif self._duty_counts is not None and axis.mode == ControlMode.OPENLOOP:
            self._reached = self._approach(self._duty_counts, self._max_duty_step, "rate of duty")
            axis.send(motor.SET_OPENLOOP_PARAMS, round_half_away(self._reached))
            self._sent(now_ns)
        self._look_again(now_ns + CYCLE_NS)

    def _give_up(self, now_ns: int, cause: str) -> None:
        timed = self._axis.mode not in _UNTIMED
        text = f"{cause}: {self._axis.name} {'made stiff' if timed else 'to position mode'}"
        self._faults.report(now_ns, text, text)
        self._cycle_ns = now_ns + CYCLE_NS
        self._look_again(self._cycle_ns)
        make_stiff(self._axis)

    def _sent(self, now_ns: int) -> None:
        self._cycle_ns = _next_cycle_ns(self._cycle_ns, now_ns)
        self._repeat_ns = now_ns + REPEAT_NS


def _next_cycle_ns(cycle_ns: int, now_ns: int) -> int:
    """Earliest next frame: on a 10 ms grid, restarted after a pause."""
    following_ns = cycle_ns + CYCLE_NS
    return following_ns if following_ns > now_ns else now_ns + CYCLE_NS
