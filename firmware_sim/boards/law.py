"""Integer arithmetic of the boards (can-protocol 6 and 9.3); also compiled, in kernel_law.py.

Shifts are sign-symmetric: they divide towards zero.
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
