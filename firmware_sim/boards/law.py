"""Integer arithmetic of the boards' 1 ms control laws (can-protocol 6 and 9.3).

Shifts are sign-symmetric: they divide towards zero. Errors saturate at 16 bits. A derivative is the
mean of the last N terms, each already shifted: N = 10 on brushless boards, 1 on the 4DC.
"""

I16_MAX = 0x7FFF
I32_MAX = 0x7FFF_FFFF


def shift_right(value: int, bits: int) -> int:
    """Divide by 2^bits towards zero."""
    return value >> bits if value >= 0 else -(-value >> bits)


def divide(value: int, divisor: int) -> int:
    """Divide by a positive number towards zero."""
    return value // divisor if value >= 0 else -(-value // divisor)


def clamp(value: int, limit: int) -> int:
    """Limit to +-limit; a negative limit counts as 0."""
    limit = max(limit, 0)
    if value > limit:
        return limit
    return max(value, -limit)


def saturate_i16(value: int) -> int:
    """Limit to a signed 16-bit word."""
    return I16_MAX if value > I16_MAX else max(value, -0x8000)


def saturate_i32(value: int) -> int:
    """Limit to a signed 32-bit word."""
    return I32_MAX if value > I32_MAX else max(value, -0x8000_0000)


class MovingMean:
    """Mean of the last N values, towards zero.

    While `live` is 0 every kept value is 0, so a step with 0 may be left out.
    """

    __slots__ = ("_next", "_samples", "_sum", "_values", "live")

    def __init__(self, samples: int) -> None:
        self._samples = samples
        self.clear()

    def clear(self) -> None:
        """Forget every value."""
        self._values = [0] * self._samples
        self._sum = 0
        self._next = 0
        self.live = 0

    def step(self, value: int) -> int:
        """Take a value in and return the mean."""
        samples = self._samples
        self.live = samples if value else self.live - 1
        index = self._next
        values = self._values
        total = self._sum = self._sum + value - values[index]
        values[index] = value
        index += 1
        self._next = index if index < samples else 0
        return total // samples if total >= 0 else -(-total // samples)


class Pid:
    """Gains and memory of one loop."""

    __slots__ = (
        "_integral_before",
        "error",
        "integral",
        "integral_limit",
        "kd",
        "ki",
        "kp",
        "mean",
        "offset",
        "output_limit",
        "shift",
    )

    def __init__(
        self, samples: int, *, kp: int, kd: int, ki: int, shift: int, integral_limit: int
    ) -> None:
        """Gains before configuration; `samples` is the length of the derivative's mean."""
        self.kp = kp
        self.kd = kd
        self.ki = ki
        self.shift = shift  # 0..31
        self.offset = 0
        self.integral_limit = integral_limit
        self.output_limit = 0
        self.mean = MovingMean(samples)  # of the derivative
        self.clear()

    def clear(self) -> None:
        """Forget error, integral and derivative."""
        self.error = 0
        self.integral = 0  # not shifted
        self._integral_before = 0
        self.mean.clear()

    def step(self, error: int) -> int:
        """Output, not limited, for an error within 16 bits, one millisecond after the last."""
        shift = self.shift
        product = self.kp * error
        output = self.offset + (product >> shift if product >= 0 else -(-product >> shift))
        product = self.kd * (error - self.error)
        term = product >> shift if product >= 0 else -(-product >> shift)
        if term or self.mean.live:
            output += self.mean.step(term)
        self.error = error
        if not self.ki:
            return output
        self._integral_before = total = self.integral
        total += self.ki * error
        term = total >> shift if total >= 0 else -(-total >> shift)
        limit = self.integral_limit
        if not -limit <= term <= limit:
            # The boards write the limit, unshifted, into the accumulator: it drops by 2^shift and
            # charges again.
            total = term = clamp(term, limit)
        self.integral = total
        return output + term

    def step_limited(self, error: int, extra: int = 0) -> int:
        """The same with an extra term, limited to +-output_limit.

        Anti-windup: at the limit, an integral that pushes further out is not charged.
        """
        output = self.step(error) + extra
        limit = self.output_limit
        if -limit < output < limit:
            return output
        if (output > 0) == (self.ki * error > 0):
            self.integral = self._integral_before
        return clamp(output, limit)
