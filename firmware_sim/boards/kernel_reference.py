"""Compiled: one millisecond of a position reference (can-protocol 2.2, commands 27 and 28)."""

from dforc.compiled import compiled
from firmware_sim.boards.fields import (
    ACCELERATION,
    ACTIVE,
    DELTA,
    DURATION,
    ELAPSED,
    FRACTION,
    HIGH,
    LOW,
    PROGRESS,
    REFERENCE,
    VELOCITY,
    VELOCITY_AGE,
    VELOCITY_SHIFT,
    VELOCITY_TARGET,
    VELOCITY_TIMEOUT,
)
from firmware_sim.boards.kernel_law import Row, shift_right


@compiled
def _advance_move(row: Row) -> None:
    elapsed: int = row[ELAPSED] + 1
    total: int = row[DURATION]
    delta: int = row[DELTA]
    progress = delta
    if elapsed < total:
        # Floating point, cut towards zero: exact integers would need some 250 bits.
        s = elapsed / total
        progress = int(delta * (s * s * s * (10.0 - 15.0 * s + 6.0 * (s * s))))
    row[REFERENCE] += progress - row[PROGRESS]
    row[PROGRESS] = progress
    row[ELAPSED] = elapsed
    if elapsed >= total:
        row[DELTA] = 0
        row[PROGRESS] = 0
        row[ELAPSED] = 0
        row[DURATION] = 0


@compiled
def _advance_velocity(row: Row) -> None:
    row[VELOCITY_AGE] += 1
    if row[VELOCITY_AGE] > row[VELOCITY_TIMEOUT]:
        row[VELOCITY_TARGET] = 0
    ramp = max(row[ACCELERATION], 1)
    change: int = row[VELOCITY_TARGET] - row[VELOCITY]
    row[VELOCITY] += max(-ramp, min(ramp, change))
    fraction: int = row[FRACTION] + row[VELOCITY]
    shift: int = row[VELOCITY_SHIFT]
    step = shift_right(fraction, shift)
    row[FRACTION] = fraction - (step << shift)
    before: int = row[REFERENCE]
    if step > 0:  # a reference that starts outside the limits may come back, not go further out
        row[REFERENCE] = min(before + step, max(before, row[HIGH]))
    elif step < 0:
        row[REFERENCE] = max(before + step, min(before, row[LOW]))


@compiled
def advance(row: Row) -> None:
    """One millisecond of whatever moves."""
    if row[DELTA] != 0:
        _advance_move(row)
    if row[VELOCITY] != 0 or row[VELOCITY_TARGET] != 0:
        _advance_velocity(row)
    moves = row[DELTA] != 0 or row[VELOCITY] != 0 or row[VELOCITY_TARGET] != 0
    row[ACTIVE] = 1 if moves else 0
