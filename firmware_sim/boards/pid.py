"""Gains and memory of one loop of an axis; the loop itself is compiled (kernel_law.py)."""

from firmware_sim.boards.fields import (
    DERIVATIVE,
    ERROR,
    INTEGRAL,
    INTEGRAL_BEFORE,
    INTEGRAL_LIMIT,
    KD,
    KI,
    KP,
    MEAN_WORDS,
    OFFSET,
    OUTPUT_LIMIT,
    SHIFT,
)
from firmware_sim.boards.kernel_law import step_limited
from firmware_sim.boards.view import Block, Word


class Pid(Block):
    """A loop at its place in the axis's row."""

    __slots__ = ()

    kp = Word(KP)
    kd = Word(KD)
    ki = Word(KI)
    shift = Word(SHIFT)  # 0..31
    offset = Word(OFFSET)
    integral_limit = Word(INTEGRAL_LIMIT)
    output_limit = Word(OUTPUT_LIMIT)
    error = Word(ERROR)
    integral = Word(INTEGRAL)  # not shifted

    def boot(self, *, kp: int, kd: int, ki: int, shift: int) -> None:
        """Gains before configuration."""
        self.kp, self.kd, self.ki, self.shift = kp, kd, ki, shift
        self.offset = 0
        self.integral_limit = 0x7FFF
        self.output_limit = 0
        self.clear()

    def clear(self) -> None:
        """Forget error, integral and derivative."""
        words = self.words
        for place in (ERROR, INTEGRAL, INTEGRAL_BEFORE):
            words[place] = 0
        for place in range(DERIVATIVE, DERIVATIVE + MEAN_WORDS):
            words[place] = 0

    def step_limited(self, error: int, extra: int = 0) -> int:
        """Output within +-output_limit for an error within 16 bits, a millisecond after the last.

        For laws that are not compiled.
        """
        return step_limited(self.row, self.start, error, error - self.error, extra)
