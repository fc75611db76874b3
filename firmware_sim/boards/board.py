"""What an emulated board is to the rig: it takes frames and is ticked once per millisecond.

A board knows no clock; it counts its own ticks. Frames given to `on_frame` act in the next tick.
"""

from collections import Counter
from typing import Protocol

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.axis_state import Axis
from hal.wire.can import Frame

RECEIVE_FIFO_FRAMES = 30  # can-protocol 1


class BoardError(ValueError):
    """A board was asked for that nobody can build; the text lists what there is."""


class Board(Protocol):
    """One emulated board. Motor boards have ports and axes, sensor boards have `raw_adc`."""

    addresses: tuple[int, ...]
    ports: tuple[AxisPort, ...]  # index = axis on the board
    axes: tuple[Axis, ...]  # their state, for tests and counters; same order
    raw_adc: list[int]  # unsigned 16-bit words of the sensor's six channels, set before each tick
    bus_off: bool  # input: the CAN controller has left the bus
    powered: bool  # input: a board without power is silent and drives nothing
    dropped: Counter[str]  # frames not acted upon, by cause

    def accepts(self, can_id: int) -> bool:
        """True when the board's hardware filter lets frames with this identifier in."""
        ...

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Put a frame into the receive FIFO; it acts in the next tick."""
        ...

    def tick(self) -> list[Frame]:
        """Run one millisecond and return the frames sent in it, in order."""
        ...

    def power_cycle(self) -> None:
        """Boot again: everything but the EEPROM is forgotten."""
        ...
