"""One axis, one millisecond: its mode's law gives a PWM, `drive` brings it to the bridge.

The coupling of motors stands between the two.
"""

from collections.abc import Callable

from firmware_sim.boards.axis_state import STICTION_WINDOW_MS, Axis
from firmware_sim.boards.calibration import creep_to_hard_stop
from firmware_sim.boards.law import I16_MAX, clamp, saturate_i16
from firmware_sim.boards.modes import (
    CALIB_HARD_STOP,
    DIRECT,
    IMPEDANCE_POSITION,
    IMPEDANCE_VELOCITY,
    MIXED,
    OPENLOOP,
    POSITION,
    TORQUE,
    VELOCITY,
)
from hal.wire.analog import ZERO_WORD
from hal.wire.motor_periodic import AxisFault

_OVERCURRENT = int(AxisFault.OVERCURRENT)


def drive(axis: Axis, pwm: int) -> None:
    """Compensate, limit and apply a PWM behind the decoupling."""
    if axis.force_controlled:
        pwm = _compensate(axis, pwm)
    limit = axis.duty_limit
    if not -limit <= pwm <= limit:
        pwm = clamp(pwm, limit)
    axis.pwm = pwm
    port = axis.port
    if port.external_fault:
        port.enabled = False
        port.pwm = axis.duty = 0
        axis.was_enabled = True  # the next millisecond finds the bridge off
        return
    change = pwm - axis.duty
    step = axis.hardware.duty_step
    if -step <= change <= step:
        axis.duty = pwm
    else:
        axis.duty += step if change > 0 else -step
    port.pwm = axis.duty
    port.enabled = axis.was_enabled = True


def watch_current(axis: Axis) -> None:
    """I2T and hard over-current trip."""
    hardware = axis.hardware
    current_ma = abs(axis.port.current_ma)
    excess_ma = current_ma - axis.current_limit_ma
    heat = excess_ma * excess_ma >> hardware.i2t_shift
    axis.i2t = max(0, axis.i2t + (heat if excess_ma > 0 else -heat))
    tripped = hardware.trip_ma is not None and current_ma >= hardware.trip_ma
    if (tripped or axis.i2t > hardware.i2t_trip) and axis.enabled:
        axis.faults_once |= _OVERCURRENT
        axis.fault()


def _servo(axis: Axis) -> int:
    """Every mode with a position reference: position PID when stiff, impedance when compliant."""
    reference = axis.reference
    if reference.active:
        reference.advance()
    error = reference.ticks - axis.position
    if not -0x8000 <= error <= I16_MAX:
        error = saturate_i16(error)
    if axis.force_controlled:
        axis.position_pid.error = error  # for the PID_ERROR frame; the loop itself rests
        return _torque_pwm(axis, axis.impedance.torque(-error))
    if error and axis.hardware.pulses_stiction:
        # DELIBERATE: the sheet calls this term a pulse without giving its shape; here it lasts as
        # long as there is an error.
        stiction = axis.stiction_up if error > 0 else -axis.stiction_down
        return axis.position_pid.step_limited(error, stiction)
    return axis.position_pid.step_limited(error)


def _torque(axis: Axis) -> int:
    return _torque_pwm(axis, axis.desired_torque)


def _torque_pwm(axis: Axis, desired: int) -> int:
    """PWM of the torque loop; without a living torque source the axis faults."""
    sensor = axis.torque_sensor
    if sensor is None or not sensor.watchdog_ms:
        axis.fault()
        return 0
    frame, word = axis.torque_place
    return axis.torque_loop.step(desired, sensor.words[frame][word] - ZERO_WORD)


def _open_loop(axis: Axis) -> int:
    inside = axis.reference.low <= axis.position <= axis.reference.high
    return axis.openloop_pwm if inside else 0


def undefined(axis: Axis) -> int:
    """A mode that the board does not have faults one millisecond after it was entered."""
    if axis.undefined_mode:
        axis.fault()
    axis.undefined_mode = True
    return 0


Law = Callable[[Axis], int]
"""PWM before coupling for this millisecond. May put the axis into HW_FAULT."""

LAWS: dict[int, Law] = {
    POSITION: _servo,
    VELOCITY: _servo,
    IMPEDANCE_POSITION: _servo,
    IMPEDANCE_VELOCITY: _servo,
    MIXED: _servo,
    DIRECT: _servo,
    TORQUE: _torque,
    OPENLOOP: _open_loop,
    CALIB_HARD_STOP: creep_to_hard_stop,
}


def _compensate(axis: Axis, pwm: int) -> int:
    """Back-EMF, friction, end of range and torque limit of a force-controlled axis, in order."""
    loop = axis.torque_loop
    if loop.bemf and axis.moved:
        pwm += loop.back_emf(axis.speed(), axis.speed_shift)
    if loop.stiction_up or loop.stiction_down:
        pwm += _coulomb(axis)
    # DELIBERATE: the sheet names an end-of-range protection without its law; here an axis outside
    # its limits is not driven further out.
    reference = axis.reference
    outward = pwm if axis.position_pid.kp >= 0 else -pwm
    if (outward > 0 and axis.position > reference.high) or (
        outward < 0 and axis.position < reference.low
    ):
        pwm = 0
    limit = loop.pid.output_limit
    return pwm if -limit <= pwm <= limit else clamp(pwm, limit)


def _coulomb(axis: Axis) -> int:
    """Friction term by the sign of the commanded velocity, which is 0 at standstill."""
    ticks = axis.reference.ticks
    slot = axis.node.ms % STICTION_WINDOW_MS
    moved = ticks - axis.reference_history[slot]
    axis.reference_history[slot] = ticks
    if moved == 0:
        return 0
    return axis.torque_loop.stiction_up if moved > 0 else -axis.torque_loop.stiction_down
