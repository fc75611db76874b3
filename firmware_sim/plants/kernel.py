"""The arithmetic of one step over all axes, compiled where it can be (see compiled.py).

`state` has a row for each quantity and a column for each axis; `constants` likewise. `links` are
the places (motor, axis) where S is not zero, `shares` what it is there. `columns` says where an
axis stands in a model's joint vector, -1 for one that is not in the model.
"""

import numpy as np
from numpy.typing import NDArray

from dforc.compiled import compiled

Array = NDArray[np.float64]
Places = NDArray[np.int64]

# Rows of `state`. What pulls is taken off the torque, and its slope opposes the motion.
X, DX, DDX, PWM, TORQUE, OPPOSING, INERTIA, AT_MOTOR, PULL, PULL_SLOPE, PUSH, STATE_ROWS = range(12)

# Rows of `constants`. Those of the drives follow the bridges; INERTIA_OWN is beside the drives'.
(
    NM_PER_COUNT,
    BRAKING_NMS_RAD,
    A_PER_COUNT,
    BRAKING_AS_RAD,
    INERTIA_DRIVE,
    INERTIA_OWN,
    COULOMB_NM,
    VISCOUS_NMS_RAD,
    LOW_STOP,
    HIGH_STOP,
    CONSTANT_ROWS,
) = range(11)

# Rows of a model's motion.
Q, DQ, TAU, ARMATURE = range(4)
ACCELERATION = 2  # in the place of TAU

SLIP_RAD_S = 1e-5  # below this speed dry friction falls to zero: 0.03 deg a minute at most
STOP_NM_RAD = 2.0e4  # assumed: 20 Nm press a joint 0.06 deg into its stop
STOP_NMS_RAD = 100.0  # assumed: no bounce at the arm's inertias
MA_PER_A = 1000.0


@compiled
def load(
    state: Array,
    constants: Array,
    links: Places,
    shares: Array,
    columns: Places,
    motion: Array,
    dt: float,
) -> None:
    """Torques, what opposes and inertias of this step; accelerations of axes outside the model."""
    axes = state.shape[1]
    motor_speeds(state, links, shares)
    for i in range(axes):
        driving = constants[NM_PER_COUNT, i] * state[PWM, i]
        state[AT_MOTOR, i] = driving - constants[BRAKING_NMS_RAD, i] * state[AT_MOTOR, i]
        state[TORQUE, i] = state[PUSH, i] - state[PULL, i]
    for k in range(shares.shape[0]):
        state[TORQUE, links[1, k]] += shares[k] * state[AT_MOTOR, links[0, k]]
    for i in range(axes):
        x, dx = state[X, i], state[DX, i]
        opposing = constants[COULOMB_NM, i] / max(abs(dx), SLIP_RAD_S)
        opposing += constants[VISCOUS_NMS_RAD, i] + dt * state[PULL_SLOPE, i]
        low, high = constants[LOW_STOP, i], constants[HIGH_STOP, i]
        if x < low or x > high:
            inside = x - low if x < low else x - high
            state[TORQUE, i] -= STOP_NM_RAD * inside
            opposing += STOP_NM_RAD * dt
            if inside * dx > 0.0:  # a stop does not hold back what leaves it
                opposing += STOP_NMS_RAD
        state[OPPOSING, i] = opposing
        state[TORQUE, i] -= opposing * dx
        state[INERTIA, i] = constants[INERTIA_DRIVE, i] + dt * opposing
        place = columns[i]
        if place < 0:
            state[DDX, i] = state[TORQUE, i] / (state[INERTIA, i] + constants[INERTIA_OWN, i])
        else:
            motion[Q, place] = x
            motion[DQ, place] = dx
            motion[TAU, place] = state[TORQUE, i]
            motion[ARMATURE, place] = state[INERTIA, i]


@compiled
def motor_speeds(state: Array, links: Places, shares: Array) -> None:
    """Speeds of the motors, in the sense of their PWM, into the row AT_MOTOR."""
    for i in range(state.shape[1]):
        state[AT_MOTOR, i] = 0.0
    for k in range(shares.shape[0]):
        state[AT_MOTOR, links[0, k]] += shares[k] * state[DX, links[1, k]]


@compiled
def spread(state: Array, ddq: Array, columns: Places, cut_columns: Places, cut: Array) -> None:
    """Take a model's accelerations over, and hand the motion on to the model with the sensors."""
    for i in range(state.shape[1]):
        if columns[i] >= 0:
            state[DDX, i] = ddq[columns[i]]
            cut[Q, cut_columns[i]] = state[X, i]
            cut[DQ, cut_columns[i]] = state[DX, i]
            cut[ACCELERATION, cut_columns[i]] = state[DDX, i]


@compiled
def advance(state: Array, dt: float) -> None:
    """Speeds first, then coordinates with the new speeds."""
    for i in range(state.shape[1]):
        state[DX, i] += dt * state[DDX, i]
        state[X, i] += dt * state[DX, i]


@compiled
def pull(
    state: Array, at: Places, wound: Array, table: Array, q_rad: Array, dq_rad_s: Array
) -> None:
    """Tension of every tendon and its slope, and angle and speed of the fingers it moves.

    `at` are the axes with a tendon; `wound` and `table` are as in tendons.py.
    """
    for i in range(state.shape[1]):
        q_rad[i] = state[X, i]
        dq_rad_s[i] = state[DX, i]
    for k in range(at.shape[0]):
        i = at[k]
        x = state[X, i]
        corner = 0
        while corner + 1 < wound.shape[1] and wound[k, corner + 1] <= x:
            corner += 1
        beyond = x - wound[k, corner] if corner > 0 else 0.0  # slack before the first
        state[PULL, i] = table[k, corner, 0] + table[k, corner, 1] * beyond
        state[PULL_SLOPE, i] = table[k, corner, 1]
        q_rad[i] = table[k, corner, 2] + table[k, corner, 3] * beyond
        dq_rad_s[i] = state[DX, i] * table[k, corner, 3]


@compiled
def show(
    state: Array,
    constants: Array,
    links: Places,
    shares: Array,
    sights: Places,
    per_rad: Array,
    level: Array,
    width: Places,
    shown: Places,
) -> None:
    """What encoders (ticks) and current sensors (mA) read, into the two rows of `shown`.

    `sights` are the places (encoder, axis) where `per_rad` is not zero; `width` is what is added to
    an encoder's ticks, and the mask of its width.
    """
    axes = state.shape[1]
    ticks = level.copy()
    for k in range(per_rad.shape[0]):
        ticks[sights[0, k]] += per_rad[k] * state[X, sights[1, k]]
    motor_speeds(state, links, shares)
    for i in range(axes):
        shown[0, i] = (int(np.floor(ticks[i])) + width[0, i]) & width[1, i]
        current = constants[A_PER_COUNT, i] * state[PWM, i]
        current -= constants[BRAKING_AS_RAD, i] * state[AT_MOTOR, i]
        shown[1, i] = int(current * MA_PER_A)
