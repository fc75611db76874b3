"""Compiled: what one axis does in a millisecond: the law of its mode, the bridge, the current."""

import numpy as np
from numpy.typing import NDArray

from dforc.compiled import compiled
from firmware_sim.boards.fields import (
    ACTIVE,
    BEMF,
    CURRENT_LIMIT_MA,
    CURRENT_MA,
    DAMPS_SPEED,
    DESIRED_TORQUE,
    DUTY,
    DUTY_LIMIT,
    DUTY_STEP,
    ENABLED,
    ERROR,
    EXTERNAL_FAULT,
    FAULTS_ONCE,
    FORCE_CONTROLLED,
    HIGH,
    I2T,
    I2T_SHIFT,
    I2T_TRIP,
    KP,
    LOW,
    MODE,
    MOTOR_HIGH,
    MOTOR_LOW,
    MOVED,
    OPENLOOP_PWM,
    OUTPUT_LIMIT,
    PORT_ENABLED,
    PORT_PWM,
    POSITION,
    POSITION_PID,
    PULSES_STICTION,
    PWM,
    RAW_ENCODER,
    REFERENCE,
    REFERENCE_HISTORY,
    SPEED,
    STEP,
    STICTION_DOWN,
    STICTION_UP,
    STICTION_WINDOW_MS,
    TORQUE_CHANNEL,
    TORQUE_PID,
    TORQUE_SOURCE,
    TORQUE_STICTION_DOWN,
    TORQUE_STICTION_UP,
    TRIP_MA,
    WAS_ENABLED,
)
from firmware_sim.boards.kernel_law import (
    Row,
    back_emf,
    clamp,
    impedance_torque,
    saturate_i16,
    step_limited,
    torque_pwm,
)
from firmware_sim.boards.kernel_modes import Rows, fault
from firmware_sim.boards.kernel_reference import advance
from firmware_sim.boards.modes import OPENLOOP, TORQUE
from hal.wire.analog import ZERO_WORD
from hal.wire.motor_periodic import AxisFault

Torques = NDArray[np.int64]

_OVERCURRENT = int(AxisFault.OVERCURRENT)
_MOST_MA = 1 << 30
_MOST_HEAT = 1 << 61  # a bridge that never cools down; the boards trip long before


@compiled
def _torque_loop(rows: Rows, index: int, desired: int, alive: Torques, words: Torques) -> int:
    """PWM of the torque loop; without a living torque source the axis faults."""
    row = rows[index]
    source: int = row[TORQUE_SOURCE]
    if source < 0 or alive[source] == 0:
        fault(rows, index)
        return 0
    return torque_pwm(row, desired, words[source, row[TORQUE_CHANNEL]] - ZERO_WORD)


@compiled
def _servo(rows: Rows, index: int, alive: Torques, words: Torques) -> int:
    """Every mode with a position reference: position PID when stiff, impedance when compliant."""
    row = rows[index]
    if row[ACTIVE] != 0:
        advance(row)
    error = saturate_i16(row[REFERENCE] - row[POSITION])
    before: int = row[POSITION_PID + ERROR]
    if row[FORCE_CONTROLLED] != 0:
        row[POSITION_PID + ERROR] = error  # for the PID_ERROR frame; the loop itself rests
        return _torque_loop(rows, index, impedance_torque(row, -error), alive, words)
    extra = 0
    if error != 0 and row[PULSES_STICTION] != 0:
        # DELIBERATE: the sheet calls this term a pulse without giving its shape; here it lasts as
        # long as there is an error.
        extra = row[STICTION_UP] if error > 0 else -row[STICTION_DOWN]
    change = -saturate_i16(row[STEP]) if row[DAMPS_SPEED] != 0 else error - before
    return step_limited(row, POSITION_PID, error, change, extra)


@compiled
def law_pwm(rows: Rows, index: int, alive: Torques, words: Torques) -> int:
    """PWM before coupling that the law of the axis's mode asks for. May fault the axis."""
    row = rows[index]
    mode: int = row[MODE]
    if mode == TORQUE:
        return _torque_loop(rows, index, row[DESIRED_TORQUE], alive, words)
    if mode == OPENLOOP:
        inside = row[LOW] <= row[POSITION] <= row[HIGH]
        return row[OPENLOOP_PWM] if inside else 0
    return _servo(rows, index, alive, words)


@compiled
def _coulomb(row: Row, now_ms: int) -> int:
    """Friction term by the sign of the commanded velocity, which is 0 at standstill."""
    slot = REFERENCE_HISTORY + now_ms % STICTION_WINDOW_MS
    ticks: int = row[REFERENCE]
    moved: int = ticks - row[slot]
    row[slot] = ticks
    if moved == 0:
        return 0
    friction: int = row[TORQUE_STICTION_UP] if moved > 0 else -row[TORQUE_STICTION_DOWN]
    return friction


@compiled
def _compensate(row: Row, pwm: int, now_ms: int) -> int:
    """Back-EMF, friction, end of range and torque limit of a force-controlled axis, in order."""
    if row[BEMF] != 0 and row[MOVED] != 0:
        pwm += back_emf(row, row[SPEED])
    if row[TORQUE_STICTION_UP] != 0 or row[TORQUE_STICTION_DOWN] != 0:
        pwm += _coulomb(row, now_ms)
    # DELIBERATE: the sheet names an end-of-range protection without its law; here an axis outside
    # its limits is not driven further out.
    outward = pwm if row[POSITION_PID + KP] >= 0 else -pwm
    beyond_high = outward > 0 and row[POSITION] > row[HIGH]
    if beyond_high or (outward < 0 and row[POSITION] < row[LOW]):
        pwm = 0
    return clamp(pwm, row[TORQUE_PID + OUTPUT_LIMIT])


@compiled
def drive(row: Row, pwm: int, now_ms: int) -> None:
    """Compensate, limit and apply a PWM behind the decoupling."""
    if row[FORCE_CONTROLLED] != 0:
        pwm = _compensate(row, pwm, now_ms)
    pwm = clamp(pwm, row[DUTY_LIMIT])
    row[PWM] = pwm
    row[WAS_ENABLED] = 1
    if row[EXTERNAL_FAULT] != 0:  # the next millisecond finds the bridge off
        row[PORT_ENABLED] = 0
        row[PORT_PWM] = 0
        row[DUTY] = 0
        return
    duty: int = row[DUTY] + clamp(pwm - row[DUTY], row[DUTY_STEP])
    row[DUTY] = duty
    counts: int = row[RAW_ENCODER]
    # DELIBERATE: the sheet names these limits without saying what they do; here positive PWM is
    # taken to raise the counts, and is cut at the upper limit.
    outside = counts >= row[MOTOR_HIGH] if duty > 0 else counts <= row[MOTOR_LOW]
    row[PORT_PWM] = 0 if outside else duty
    row[PORT_ENABLED] = 1


@compiled
def is_warm(row: Row) -> bool:
    """There is something for `watch_current` to do."""
    return bool(row[I2T] != 0 or abs(row[CURRENT_MA]) > row[CURRENT_LIMIT_MA])


@compiled
def watch_current(rows: Rows, index: int) -> None:
    """I2T and hard over-current trip."""
    row = rows[index]
    current_ma = min(abs(row[CURRENT_MA]), _MOST_MA)
    excess_ma = current_ma - row[CURRENT_LIMIT_MA]
    heat = excess_ma * excess_ma >> row[I2T_SHIFT]
    row[I2T] = min(max(0, row[I2T] + (heat if excess_ma > 0 else -heat)), _MOST_HEAT)
    if (current_ma >= row[TRIP_MA] or row[I2T] > row[I2T_TRIP]) and row[ENABLED] != 0:
        row[FAULTS_ONCE] |= _OVERCURRENT
        fault(rows, index)
