"""The state of many motor axes in arrays, so that one call runs the millisecond of them all.

`rows` has a row for each axis and a column for each word of fields.py; a board's axes stand in
consecutive rows. The columns that a rig needs each millisecond have names here.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firmware_sim.boards import kernel
from firmware_sim.boards.fields import (
    AXES,
    AXIS_WORDS,
    BOARD_WORDS,
    COEFFICIENTS,
    CURRENT_MA,
    ENCODERS_COUPLED,
    FIRST,
    FOR_ENCODER,
    FOR_MOTOR,
    MOST_AXES,
    MOTORS_COUPLED,
    PORT_ENABLED,
    PORT_PWM,
    RAW_ENCODER,
    SOURCES,
)
from firmware_sim.boards.hardware import Coupling
from hal.wire.analog import CHANNELS, ZERO_WORD

Words = NDArray[np.int64]


class Member(Protocol):
    """A board in a bank."""

    def run_laws(self) -> None:
        """Run the laws that are not compiled, of this millisecond."""
        ...

    def watch_temperature(self) -> None:
        """Fault axes whose drive is too hot, each fifth millisecond."""
        ...


class AxisBank:
    """Arrays of `axes` axes on `boards` boards; `members` are the boards, in their order."""

    def __init__(self, axes: int, boards: int = 1) -> None:
        self.rows: Words = np.zeros((axes, AXIS_WORDS), dtype=np.int64)
        self.boards: Words = np.zeros((boards, BOARD_WORDS), dtype=np.int64)
        self.alive_ms: Words = np.zeros(boards * SOURCES, dtype=np.int64)  # of virtual sensors
        silent = (boards * SOURCES, CHANNELS)
        self.torque_words: Words = np.full(silent, ZERO_WORD, dtype=np.int64)
        self.mixing: NDArray[np.float64] = np.zeros((axes, 2, COEFFICIENTS))
        self.members: list[Member] = []
        self._rows_taken = 0
        self._left = 0

    def take_in(self, member: Member, axes: int) -> tuple[int, int]:
        """Give a board its place: its row in `boards`, and the row in which its axes begin."""
        board, first = len(self.members), self._rows_taken
        self.members.append(member)
        self._rows_taken += axes
        self.boards[board, FIRST] = first
        self.boards[board, AXES] = axes
        return board, first

    def couple(self, board: int, coupling: Coupling) -> None:
        """Mix motors and encoders of a board from now on as its firmware does."""
        first, count = int(self.boards[board, FIRST]), int(self.boards[board, AXES])
        weights = self.mixing[first : first + count]
        weights[:, :, :] = 0.0
        weights[:, FOR_MOTOR, :count] = coupling.motors
        weights[:, FOR_MOTOR, MOST_AXES:] = coupling.partner_motors
        weights[:, FOR_ENCODER, :count] = coupling.encoders
        weights[:, FOR_ENCODER, MOST_AXES:] = coupling.partner_positions
        plain = np.eye(count, COEFFICIENTS)
        self.boards[board, MOTORS_COUPLED] = not np.array_equal(weights[:, FOR_MOTOR], plain)
        self.boards[board, ENCODERS_COUPLED] = not np.array_equal(weights[:, FOR_ENCODER], plain)

    @property
    def raw_encoder(self) -> Words:
        """What the encoders show, ticks (n, writable); absolute: 0..4095, incremental: a count."""
        return self.rows[:, RAW_ENCODER]

    @property
    def current_ma(self) -> Words:
        """Winding currents (n, writable)."""
        return self.rows[:, CURRENT_MA]

    @property
    def port_pwm(self) -> Words:
        """Signed counts applied to the motors (n)."""
        return self.rows[:, PORT_PWM]

    @property
    def port_enabled(self) -> Words:
        """1 where the bridge is on, 0 where the motor's terminals are open (n)."""
        return self.rows[:, PORT_ENABLED]

    def control(self, begin: int = 0, end: int | None = None) -> None:
        """Run the laws and the bridges of some boards, of all unless told."""
        rows, boards = self.rows, self.boards
        last = len(boards) if end is None else end
        left = kernel.control(
            rows, boards, self.alive_ms, self.torque_words, self.mixing, begin, last
        )
        if left & kernel.PYTHON_LAWS:
            for member in self.members[begin:last]:
                member.run_laws()
            left = kernel.finish(rows, boards, self.mixing, begin, last)
        self._left = left

    def supervise(self, begin: int = 0, end: int | None = None) -> None:
        """Watch temperatures and currents, behind the broadcasts of the same millisecond."""
        if self._left:
            last = len(self.boards) if end is None else end
            if self._left & kernel.HOT:
                for member in self.members[begin:last]:
                    member.watch_temperature()
            kernel.supervise(self.rows, self.boards, begin, last)
