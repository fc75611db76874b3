"""Rounding and saturation of host values on their way to the wire (can-protocol 9.1)."""

I16_MIN, I16_MAX = -0x8000, 0x7FFF
I32_MIN, I32_MAX = -0x8000_0000, 0x7FFF_FFFF


def round_half_away(value: float) -> int:
    """Nearest integer, halves away from zero. NaN and infinity raise: refuse them before."""
    whole = int(value)
    rest = value - whole  # exact, so 0.49999999999999994 stays 0
    if rest >= 0.5:
        return whole + 1
    if rest <= -0.5:
        return whole - 1
    return whole


def saturate_i16(value: float) -> int:
    """Rounded half away from zero and limited to a signed 16-bit word. NaN raises ValueError."""
    if value >= I16_MAX:
        return I16_MAX
    if value <= I16_MIN:
        return I16_MIN
    return round_half_away(value)


def saturate_i32(value: float) -> int:
    """Rounded half away from zero and limited to a signed 32-bit word. NaN raises ValueError."""
    if value >= I32_MAX:
        return I32_MAX
    if value <= I32_MIN:
        return I32_MIN
    return round_half_away(value)
