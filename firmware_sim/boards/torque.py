"""Torque loop and joint impedance of an axis (can-protocol 6): gains, and where they are kept.

A torque unit is TorqueMax / 0x8000 Nm, in the joint's sense; positions are ticks; outputs are PWM
counts. The laws are compiled (kernel_law.py).
"""

from firmware_sim.boards.fields import (
    BEMF,
    BEMF_SHIFT,
    DAMPER,
    DAMPING,
    DEVIATION,
    FILTER,
    IMPEDANCE_OFFSET,
    KFF,
    KFF_SHIFT,
    KTAU,
    KTAU_SHIFT,
    LOW_PASS,
    MEAN_WORDS,
    STIFFNESS,
    TORQUE_PID,
    TORQUE_STICTION_DOWN,
    TORQUE_STICTION_UP,
)
from firmware_sim.boards.kernel_law import FRACTION_BITS
from firmware_sim.boards.pid import Pid
from firmware_sim.boards.view import Row, View, Word


class TorqueLoop(View):
    """Torque PID with feed-forward and filter, and the terms added behind the coupling."""

    __slots__ = ("pid",)

    filter = Word(FILTER)
    kff = Word(KFF)
    kff_shift = Word(KFF_SHIFT)  # stored only: kff shares the PID's shift
    ktau = Word(KTAU)  # stored only
    ktau_shift = Word(KTAU_SHIFT)
    bemf = Word(BEMF)
    bemf_shift = Word(BEMF_SHIFT)
    stiction_up = Word(TORQUE_STICTION_UP)
    stiction_down = Word(TORQUE_STICTION_DOWN)

    def __init__(self) -> None:
        self.pid = Pid(TORQUE_PID)

    def attach(self, row: Row) -> None:
        """Speak of `row` from now on."""
        super().attach(row)
        self.pid.attach(row)

    def boot(self) -> None:
        """Gains before configuration."""
        self.pid.boot(kp=0, kd=0, ki=0, shift=10)
        self.filter = self.kff = self.kff_shift = self.ktau = self.ktau_shift = 0
        self.bemf = self.bemf_shift = self.stiction_up = self.stiction_down = 0
        self.start_filter(0)

    def start_filter(self, pwm: int) -> None:
        """Begin from a steady output.

        The sheet does not say where the boards begin; here the limb does not drop at the switch.
        """
        self.words[LOW_PASS] = pwm << FRACTION_BITS


class Impedance(View):
    """Spring, damper and offset: what a compliant axis asks of its torque loop."""

    __slots__ = ()

    stiffness = Word(STIFFNESS)  # torque units per tick
    damping = Word(DAMPING)  # torque units per (tick/ms)
    offset = Word(IMPEDANCE_OFFSET)  # torque units

    def boot(self) -> None:
        """Gains before configuration."""
        self.stiffness = self.damping = 0
        self.clear()

    def clear(self) -> None:
        """Forget offset and motion; the gains stay."""
        self.offset = 0
        self.words[DEVIATION] = 0
        for place in range(DAMPER, DAMPER + MEAN_WORDS):
            self.words[place] = 0
