"""The virtual point of DForC in time: one step, or a path looked at in advance.

Semi-implicit Euler, at the paper's 10 ms by default. All that acts may change before every step.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix
from dforc.errors import NotFiniteError
from dforc.field.force import FieldError, PointState
from dforc.field.kernel_force import Scene, advance, advance_many

PERIOD_S = 0.01  # the paper's sample time
MOST_STEPS = 1_000_000  # of a roll-out: 2.8 hours at 10 ms


class Path(NamedTuple):
    """Positions (k, 3) [m] and velocities (k, 3) [m/s], the start first, one period apart."""

    positions_m: Matrix
    velocities_m_s: Matrix


def step(state: PointState, scene: Scene, dt_s: float = PERIOD_S) -> PointState:
    """Move the point by one period.

    Raises:
        NotFiniteError: state or dt_s is not finite, or the result would not be; keep the old state.
        FieldError: a dt_s that is not positive.
    """
    _refuse_bad_input(state, dt_s)
    x, v = np.array(state.position_m), np.array(state.velocity_m_s)
    advance(x, v, scene, dt_s, np.zeros(3))
    (px, py, pz), (vx, vy, vz) = x.tolist(), v.tolist()
    if not math.isfinite(px + py + pz + vx + vy + vz):
        raise NotFiniteError(f"the field drives the point from {state} beyond all numbers")
    return PointState(position_m=(px, py, pz), velocity_m_s=(vx, vy, vz))


def roll_out(
    state: PointState, scene: Scene, steps: int, dt_s: float = PERIOD_S, within_m: float = 0.0
) -> Path:
    """Where the point would go in `steps` periods if nothing changed; nothing is moved.

    With `within_m` it ends early: that near the first target and slower than that per second.

    Raises:
        NotFiniteError: state or dt_s is not finite, or some place on the path would not be.
        FieldError: a dt_s that is not positive, or a number of steps outside 0..MOST_STEPS.
    """
    _refuse_bad_input(state, dt_s)
    if not 0 <= steps <= MOST_STEPS:
        raise FieldError(f"a roll-out of {steps} steps is outside 0..{MOST_STEPS}")
    positions, velocities = np.empty((steps + 1, 3)), np.empty((steps + 1, 3))
    positions[0], velocities[0] = state.position_m, state.velocity_m_s
    used = advance_many(positions, velocities, scene, dt_s, within_m)
    path = Path(positions[:used], velocities[:used])
    if not np.isfinite(path.positions_m[-1]).all():
        raise NotFiniteError(f"the field drives the point from {state} beyond all numbers")
    return path


def _refuse_bad_input(state: PointState, dt_s: float) -> None:
    # A sum is finite only if every term is: one test for all.
    if not math.isfinite(sum(state.position_m) + sum(state.velocity_m_s) + dt_s):
        raise NotFiniteError(f"the field was given {state}, period {dt_s} s")
    if dt_s <= 0.0:
        raise FieldError(f"period must be positive, not {dt_s} s")
