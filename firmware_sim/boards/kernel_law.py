"""Compiled: loops, means, impedance and torque of one axis, in integers (can-protocol 6 and 9.3).

Errors are 16-bit words, gains too, shifts 0 to 31: no product here leaves 64 bits.
"""

import numpy as np
from numpy.typing import NDArray

from dforc.compiled import compiled
from firmware_sim.boards import law
from firmware_sim.boards.fields import (
    BEMF,
    BEMF_SHIFT,
    DAMPER,
    DAMPING,
    DERIVATIVE,
    DEVIATION,
    DROPS_INTEGRAL,
    ERROR,
    EXTRA_DAMPING,
    FILTER,
    IMPEDANCE_OFFSET,
    INTEGRAL,
    INTEGRAL_BEFORE,
    INTEGRAL_LIMIT,
    KD,
    KFF,
    KI,
    KP,
    LOW_PASS,
    MEAN_LIVE,
    MEAN_NEXT,
    MEAN_SUM,
    MEAN_VALUES,
    OFFSET,
    OUTPUT_LIMIT,
    SAMPLES,
    SHIFT,
    SPEED,
    SPEED_SHIFT,
    STIFFNESS,
    TORQUE_PID,
)

Row = NDArray[np.int64]

FILTER_3_HZ = 3
# A first-order low-pass of 3 Hz at 1 kHz: 1 - exp(-2 pi 3 / 1000) = 0.018673, in 1/65536.
# The order of the boards' own filter is not known.
_FILTER_GAIN = 1224
FRACTION_BITS = 16
_MOST_BITS = 62  # a longer shift leaves nothing of 64 bits either

clamp = compiled(law.clamp)
divide = compiled(law.divide)
saturate_i16 = compiled(law.saturate_i16)
saturate_i32 = compiled(law.saturate_i32)
shift_right = compiled(law.shift_right)


@compiled
def step_mean(row: Row, mean: int, value: int) -> int:
    """Take a value into the mean at `mean`; the mean of the last samples, towards zero.

    While MEAN_LIVE is 0 every kept value is 0, so a step with 0 may be left out.
    """
    samples: int = row[SAMPLES]
    row[mean + MEAN_LIVE] = samples if value != 0 else row[mean + MEAN_LIVE] - 1
    index: int = row[mean + MEAN_NEXT]
    total: int = row[mean + MEAN_SUM] + value - row[mean + MEAN_VALUES + index]
    row[mean + MEAN_SUM] = total
    row[mean + MEAN_VALUES + index] = value
    index += 1
    row[mean + MEAN_NEXT] = index if index < samples else 0
    return divide(total, samples)


@compiled
def step_pid(row: Row, pid: int, error: int, change: int) -> int:
    """Output of the loop at `pid`, not limited, one millisecond after the last.

    `change` is what the D term acts on.
    """
    shift: int = row[pid + SHIFT]
    output: int = row[pid + OFFSET] + shift_right(row[pid + KP] * error, shift)
    term = shift_right(row[pid + KD] * change, shift)
    if term != 0 or row[pid + DERIVATIVE + MEAN_LIVE] != 0:
        output += step_mean(row, pid + DERIVATIVE, term)
    row[pid + ERROR] = error
    total: int = row[pid + INTEGRAL]
    row[pid + INTEGRAL_BEFORE] = total
    ki: int = row[pid + KI]
    if ki == 0:
        return output
    total += ki * error
    term = shift_right(total, shift)
    limit: int = row[pid + INTEGRAL_LIMIT]
    if term > limit or term < -limit:
        # The boards write the limit, unshifted, into the accumulator: it drops by 2^shift and
        # charges again.
        term = clamp(term, limit)
        total = term if row[DROPS_INTEGRAL] != 0 else term << shift
    row[pid + INTEGRAL] = total
    return output + term


@compiled
def step_limited(row: Row, pid: int, error: int, change: int, extra: int) -> int:
    """The same with an extra term, limited to +-OUTPUT_LIMIT.

    Anti-windup: at the limit, an integral that pushes further out is not charged.
    """
    output = step_pid(row, pid, error, change) + extra
    limit: int = row[pid + OUTPUT_LIMIT]
    if -limit < output < limit:
        return output
    if (output > 0) == (row[pid + KI] * error > 0):
        row[pid + INTEGRAL] = row[pid + INTEGRAL_BEFORE]
    return clamp(output, limit)


@compiled
def low_pass(row: Row, value: int) -> int:
    """Filtered PWM, rounded, one millisecond after the last."""
    state: int = row[LOW_PASS]
    state += shift_right(((value << FRACTION_BITS) - state) * _FILTER_GAIN, FRACTION_BITS)
    row[LOW_PASS] = state
    return (state + 0x8000) >> FRACTION_BITS


@compiled
def torque_pwm(row: Row, desired: int, measured: int) -> int:
    """PWM of the torque loop before coupling for two torques, one millisecond after the last."""
    desired = saturate_i16(desired)  # the boards multiply 16-bit words
    error = saturate_i16(desired - measured)
    pwm = step_pid(row, TORQUE_PID, error, error - row[TORQUE_PID + ERROR])
    shift: int = row[TORQUE_PID + SHIFT]
    pwm += shift_right(row[KFF] * desired, shift) - shift_right(
        row[EXTRA_DAMPING] * row[SPEED], shift
    )
    if row[FILTER] == FILTER_3_HZ:
        return low_pass(row, pwm)
    return pwm


@compiled
def back_emf(row: Row, speed: int) -> int:
    """PWM that makes up for back-EMF; `speed` as the board estimates it."""
    return shift_right(speed * row[BEMF], min(row[BEMF_SHIFT] + row[SPEED_SHIFT], _MOST_BITS))


@compiled
def impedance_torque(row: Row, deviation: int) -> int:
    """Desired torque for position - reference in ticks, one millisecond after the last."""
    torque: int = row[IMPEDANCE_OFFSET] - row[STIFFNESS] * deviation
    damping: int = row[DAMPING] * (deviation - row[DEVIATION])
    if damping != 0 or row[DAMPER + MEAN_LIVE] != 0:
        torque -= step_mean(row, DAMPER, damping)
    row[DEVIATION] = deviation
    return torque
