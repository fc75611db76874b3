"""Compiled: the millisecond of all axes of a bank, in the order of can-protocol 10.4.

`control` stands between the parsing of commands and the broadcasts, `supervise` behind these.
Axes whose mode has a law in Python are left out; when there are any, `control` stops before the
coupling of motors and `finish` does the rest, after those laws have run.
"""

import numpy as np
from numpy.typing import NDArray

from dforc.compiled import compiled
from firmware_sim.boards.fields import (
    AXES,
    BOARD,
    COMPLIANT,
    ENABLED,
    ENCODER,
    ENCODER_FAULT,
    ENCODERS_COUPLED,
    EXTERNAL_FAULT,
    FAULTS_ONCE,
    FIRST,
    FOR_ENCODER,
    FOR_MOTOR,
    MODE,
    MOST_AXES,
    MOTORS_COUPLED,
    MS,
    OVERHEATED,
    PARTNER_DUTY_0,
    PARTNER_POSITION_0,
    PARTNER_SILENT,
    POSITION,
    PWM_WANTED,
    RUNNING,
    SOURCES,
    SPEED_WINDOW,
    STATUS_KEY,
    WATCHES_PARTNER,
)
from firmware_sim.boards.kernel_axis import Torques, drive, is_warm, law_pwm, watch_current
from firmware_sim.boards.kernel_law import Row
from firmware_sim.boards.kernel_modes import (
    Rows,
    estimate_speed,
    fault,
    read_encoder,
    restart_speed,
    sense,
)
from firmware_sim.boards.modes import (
    CALIB_INCREMENTAL,
    DIRECT,
    IMPEDANCE_POSITION,
    IMPEDANCE_VELOCITY,
    MIXED,
    OPENLOOP,
    TORQUE,
    VELOCITY,
)
from firmware_sim.boards.modes import (
    POSITION as POSITION_MODE,
)

Boards = NDArray[np.int64]
Mixing = NDArray[np.float64]

# What is left to do for whoever called.
PYTHON_LAWS = 1
WARM = 2  # `supervise`
HOT = 4  # a drive reports over-temperature

_I32_MAX = 0x7FFF_FFFF


@compiled
def has_law(mode: int) -> bool:
    """True for modes whose law is compiled."""
    return (
        mode in (POSITION_MODE, DIRECT, TORQUE, VELOCITY)
        or mode in (IMPEDANCE_POSITION, IMPEDANCE_VELOCITY)
        or mode in (MIXED, OPENLOOP, CALIB_INCREMENTAL)
    )


@compiled
def mix(rows: Rows, board: Row, weights: Mixing, field: int, partner: int) -> int:
    """Weighted sum of a field over a board's axes and its partner's two words, towards zero."""
    first: int = board[FIRST]
    total = 0.0
    for number in range(board[AXES]):
        total += weights[number] * rows[first + number, field]
    total += weights[MOST_AXES] * board[partner]
    total += weights[MOST_AXES + 1] * board[partner + 1]
    return int(max(-_I32_MAX - 1.0, min(total, float(_I32_MAX))))


@compiled
def _joint_ticks(rows: Rows, board: Row, mixing: Mixing, index: int) -> int:
    """Position of an axis behind the decoupling of encoders."""
    ticks: int = rows[index, ENCODER]
    if board[ENCODERS_COUPLED] == 0:
        return ticks
    return mix(rows, board, mixing[index, FOR_ENCODER], ENCODER, PARTNER_POSITION_0)


@compiled
def rebase(rows: Rows, boards: Boards, mixing: Mixing, index: int) -> None:
    """Begin afresh after a jump of an encoder's zero, on every axis whose position follows it."""
    read_encoder(rows[index])
    board = boards[rows[index, BOARD]]
    first: int = board[FIRST]
    for other in range(first, first + board[AXES]):
        position = _joint_ticks(rows, board, mixing, other)
        if other == index or position != rows[other, POSITION]:
            restart_speed(rows[other], position)


@compiled
def _measure(rows: Rows, board: Row, mixing: Mixing) -> None:
    """Positions and speeds of a board's axes."""
    first: int = board[FIRST]
    last = first + board[AXES]
    for index in range(first, last):
        sense(rows, index)
    for index in range(first, last):
        row = rows[index]
        position: int = row[POSITION]
        if row[ENCODER_FAULT] == 0:
            position = _joint_ticks(rows, board, mixing, index)
        estimate_speed(row, position, board[MS] % row[SPEED_WINDOW])


@compiled
def _decide(rows: Rows, board: Row, alive: Torques, words: Torques) -> bool:
    """PWM that each axis wants; True when some law is not compiled."""
    first: int = board[FIRST]
    pending = False
    for index in range(first, first + board[AXES]):
        row = rows[index]
        if row[ENABLED] != 0 and row[WATCHES_PARTNER] != 0 and board[PARTNER_SILENT] != 0:
            fault(rows, index)
        if row[ENABLED] != 0:
            if has_law(row[MODE]):
                row[PWM_WANTED] = law_pwm(rows, index, alive, words)
            else:
                pending = True
    return pending


@compiled
def _drive_board(rows: Rows, board: Row, mixing: Mixing) -> int:
    """Motors under the PWM that the axes want; what is left to do."""
    first: int = board[FIRST]
    last = first + board[AXES]
    if board[MOTORS_COUPLED] != 0:
        for index in range(first, last):
            if rows[index, ENABLED] == 0:
                rows[index, PWM_WANTED] = 0
    left = 0
    for index in range(first, last):
        row = rows[index]
        if row[ENABLED] != 0:
            pwm: int = row[PWM_WANTED]
            if board[MOTORS_COUPLED] != 0:
                pwm = mix(rows, board, mixing[index, FOR_MOTOR], PWM_WANTED, PARTNER_DUTY_0)
            drive(row, pwm, board[MS])
        faults = row[FAULTS_ONCE] | row[EXTERNAL_FAULT] << 8 | row[ENCODER_FAULT] << 9
        row[STATUS_KEY] = row[MODE] | row[COMPLIANT] << 8 | faults << 9
        if is_warm(row):
            left |= WARM
        if row[OVERHEATED] != 0:
            left |= HOT
    return left


@compiled
def finish(rows: Rows, boards: Boards, mixing: Mixing, begin: int, end: int) -> int:
    """Drive the motors of the boards `begin` to `end`; what is left to do."""
    left = 0
    for number in range(begin, end):
        if boards[number, RUNNING] != 0:
            left |= _drive_board(rows, boards[number], mixing)
    return left


@compiled
def control(
    rows: Rows,
    boards: Boards,
    alive: Torques,
    words: Torques,
    mixing: Mixing,
    begin: int,
    end: int,
) -> int:
    """One millisecond of the boards `begin` to `end`, up to the bridges; what is left to do."""
    pending = False
    for number in range(begin, end):
        board = boards[number]
        if board[RUNNING] != 0:
            _measure(rows, board, mixing)
            for source in range(number * SOURCES, (number + 1) * SOURCES):
                if alive[source] != 0:
                    alive[source] -= 1
            if _decide(rows, board, alive, words):
                pending = True
    if pending:
        return PYTHON_LAWS
    return finish(rows, boards, mixing, begin, end)


@compiled
def supervise(rows: Rows, boards: Boards, begin: int, end: int) -> None:
    """Current and I2T, behind the broadcasts of the same millisecond."""
    for number in range(begin, end):
        board = boards[number]
        if board[RUNNING] != 0:
            first: int = board[FIRST]
            for index in range(first, first + board[AXES]):
                if is_warm(rows[index]):
                    watch_current(rows, index)
