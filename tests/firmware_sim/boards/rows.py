"""Rows of a bank without a board."""

from firmware_sim.boards.bank import AxisBank
from firmware_sim.boards.fields import DROPS_INTEGRAL, SAMPLES, SPEED_SHIFT
from firmware_sim.boards.view import Row


def row_of_words(samples: int = 10) -> Row:
    """The row of one axis, zero but for what a boot makes of means, speed shift and integral."""
    row: Row = AxisBank(1).rows[0]
    row[SAMPLES] = samples
    row[SPEED_SHIFT] = 5
    row[DROPS_INTEGRAL] = 1
    return row
