"""Torque loop and joint impedance of a motor board (can-protocol 6), integers throughout.

A torque unit is TorqueMax / 0x8000 Nm, in the joint's sense; positions are ticks; outputs are PWM
counts.
"""

from firmware_sim.boards.law import I16_MAX, MovingMean, Pid, saturate_i16, shift_right

FILTER_3_HZ = 3
# A first-order low-pass of 3 Hz at 1 kHz: 1 - exp(-2 pi 3 / 1000) = 0.018673, in 1/65536.
# The order of the boards' own filter is not known.
_FILTER_GAIN = 1224
_FRACTION_BITS = 16


class LowPass:
    """First-order low-pass of the torque loop's PWM, state in 1/65536 counts."""

    __slots__ = ("_state",)

    def __init__(self) -> None:
        self._state = 0

    def start(self, value: int) -> None:
        """Begin from a steady output.

        The sheet does not say where the boards begin; here the limb does not drop at the switch.
        """
        self._state = value << _FRACTION_BITS

    def step(self, value: int) -> int:
        """Filtered PWM, rounded, one millisecond after the last."""
        change = ((value << _FRACTION_BITS) - self._state) * _FILTER_GAIN
        self._state += change >> 16 if change >= 0 else -(-change >> 16)
        return (self._state + 0x8000) >> _FRACTION_BITS


class TorqueLoop:
    """Torque PID with feed-forward and filter, and the terms added behind the coupling."""

    __slots__ = (
        "bemf",
        "bemf_shift",
        "filter",
        "kff",
        "kff_shift",
        "ktau",
        "ktau_shift",
        "low_pass",
        "pid",
        "stiction_down",
        "stiction_up",
    )

    def __init__(self, samples: int) -> None:
        """`samples` is the length of the derivative's mean."""
        self.pid = Pid(samples, kp=0, kd=0, ki=0, shift=10, integral_limit=0x7FFF)
        self.filter = 0
        self.low_pass = LowPass()
        self.kff = 0
        self.kff_shift = 0  # stored only: kff shares the PID's shift
        self.ktau = 0  # stored only
        self.ktau_shift = 0
        self.bemf = 0
        self.bemf_shift = 0
        self.stiction_up = 0
        self.stiction_down = 0

    def step(self, desired: int, measured: int) -> int:
        """PWM before coupling for two torques, one millisecond after the last."""
        pid = self.pid
        if not -0x8000 <= desired <= I16_MAX:
            desired = saturate_i16(desired)  # the boards multiply 16-bit words
        error = desired - measured
        if not -0x8000 <= error <= I16_MAX:
            error = saturate_i16(error)
        pwm = pid.step(error)
        product = self.kff * desired
        pwm += product >> pid.shift if product >= 0 else -(-product >> pid.shift)
        if self.filter == FILTER_3_HZ:
            return self.low_pass.step(pwm)
        return pwm

    def back_emf(self, speed: int, speed_shift: int) -> int:
        """PWM that makes up for back-EMF; `speed` and `speed_shift` as the board estimates them."""
        return shift_right(speed * self.bemf, self.bemf_shift + speed_shift)


class Impedance:
    """Spring, damper and offset: what a compliant axis asks of its torque loop."""

    __slots__ = ("_damper", "_deviation", "damping", "offset", "stiffness")

    def __init__(self, samples: int) -> None:
        """`samples` is the length of the damper's mean."""
        self.stiffness = 0  # torque units per tick
        self.damping = 0  # torque units per (tick/ms)
        self.offset = 0  # torque units
        self._deviation = 0
        self._damper = MovingMean(samples)

    def clear(self) -> None:
        """Forget offset and motion; the gains stay."""
        self.offset = 0
        self._deviation = 0
        self._damper.clear()

    def torque(self, deviation: int) -> int:
        """Desired torque for position - reference in ticks, one millisecond after the last."""
        torque = self.offset - self.stiffness * deviation
        damping = self.damping * (deviation - self._deviation)
        if damping or self._damper.live:
            torque -= self._damper.step(damping)
        self._deviation = deviation
        return torque
