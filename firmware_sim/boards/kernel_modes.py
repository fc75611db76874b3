"""Compiled: what takes an axis down by itself, and what it measures (can-protocol 9.2, 10.3)."""

import numpy as np
from numpy.typing import NDArray

from dforc.compiled import compiled
from firmware_sim.boards.fields import (
    BOARD_FIRST,
    DUTY,
    ENABLED,
    ENCODER,
    ENCODER_FAULT,
    ENCODER_MASK,
    ENCODER_OFFSET,
    EXTERNAL_FAULT,
    FAULT_ENTRIES,
    FAULTS_ONCE,
    FORCE_CONTROLLED,
    FROM_HALL,
    HALL_FAULT,
    HALL_TICKS,
    HISTORY,
    MODE,
    MOST_AXES,
    MOVED,
    PEERS,
    PORT_ENABLED,
    PORT_PWM,
    POSITION,
    PWM,
    RAW_ENCODER,
    SCALES_SPEED,
    SPEED,
    SPEED_SHIFT,
    SPEED_WINDOW,
    STEP,
    WAS_ENABLED,
    WINDOW_MS,
)
from firmware_sim.boards.kernel_law import Row, divide, saturate_i16, saturate_i32
from firmware_sim.boards.modes import HW_FAULT, IDLE
from hal.wire.motor_periodic import AxisFault

Rows = NDArray[np.int64]

_HALL_A = int(AxisFault.HALL_A)
_HALL_B = int(AxisFault.HALL_B)
_HALL_C = int(AxisFault.HALL_C)
_MOST_SPEED_BITS = 31  # beyond them one tick in the window already saturates 16 bits


@compiled
def switch_off(row: Row) -> None:
    """Take the bridge down at once."""
    row[ENABLED] = 0
    row[WAS_ENABLED] = 0
    row[FORCE_CONTROLLED] = 0
    row[PWM] = 0
    row[DUTY] = 0
    row[PORT_PWM] = 0
    row[PORT_ENABLED] = 0


@compiled
def _idle_peers(rows: Rows, index: int) -> None:
    peers: int = rows[index, PEERS]
    if peers == 0:
        return
    first: int = rows[index, BOARD_FIRST]
    for number in range(MOST_AXES):
        if (peers >> number) & 1 != 0 and first + number != index:
            peer = rows[first + number]
            if peer[ENABLED] != 0:
                peer[MODE] = IDLE
                switch_off(peer)


@compiled
def idle(rows: Rows, index: int) -> None:
    """Bridge off, IDLE; axes that are powered together with this one too."""
    row = rows[index]
    row[MODE] = IDLE
    switch_off(row)
    _idle_peers(rows, index)


@compiled
def fault(rows: Rows, index: int) -> None:
    """Bridge off, HW_FAULT; axes that are powered together with this one drop to IDLE."""
    row = rows[index]
    if row[MODE] != HW_FAULT:
        row[FAULT_ENTRIES] += 1
    row[MODE] = HW_FAULT
    switch_off(row)
    _idle_peers(rows, index)


@compiled
def read_encoder(row: Row) -> None:
    """Ticks of the axis's own encoder or Hall sensors."""
    source: int = row[HALL_TICKS] if row[FROM_HALL] != 0 else row[RAW_ENCODER]
    row[ENCODER] = saturate_i32((source - row[ENCODER_OFFSET]) & row[ENCODER_MASK])


@compiled
def sense(rows: Rows, index: int) -> None:
    """Read encoder and drive faults."""
    row = rows[index]
    if row[EXTERNAL_FAULT] != 0 and row[WAS_ENABLED] != 0 and row[ENABLED] != 0:
        idle(rows, index)  # the hardware has opened the bridge
    if row[ENCODER_FAULT] != 0:
        fault(rows, index)
    else:
        read_encoder(row)
    code: int = row[HALL_FAULT]
    if code != 0 and row[MODE] != HW_FAULT:
        row[FAULTS_ONCE] |= (
            (code & 1) * _HALL_A | (code >> 1 & 1) * _HALL_B | (code >> 2 & 1) * _HALL_C
        )
        fault(rows, index)


@compiled
def restart_speed(row: Row, position: int) -> None:
    """Stand at a position: speed counts from here."""
    row[POSITION] = position
    row[STEP] = 0
    row[MOVED] = 0
    row[SPEED] = 0
    for slot in range(WINDOW_MS):
        row[HISTORY + slot] = position


@compiled
def estimate_speed(row: Row, position: int, slot: int) -> None:
    """Take in a position; `slot` counts milliseconds modulo the speed window."""
    row[STEP] = position - row[POSITION]
    row[POSITION] = position
    moved: int = position - row[HISTORY + slot]
    row[HISTORY + slot] = position
    row[MOVED] = moved
    if row[SCALES_SPEED] != 0:
        shift = min(row[SPEED_SHIFT], _MOST_SPEED_BITS)  # 33 bits and 31 more are 64
        moved = divide(moved << shift, row[SPEED_WINDOW])
    row[SPEED] = saturate_i16(moved)
