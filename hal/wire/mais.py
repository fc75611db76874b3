"""MAIS frames, class 3: the 15 Hall sensors of a hand (can-protocol 5.4).

In 8-bit resolution two frames, in 16-bit resolution four; the identifiers of the first two are the
same, so only the resolution that the board was set to tells 0xD of 8 bytes from 0xD of four words.
Words are the converter's 12 bits; the 8-bit values are their upper eight.
"""

from enum import IntEnum

from hal.wire.can import CLASS_ANALOG_PERIODIC
from hal.wire.layout import Layout, pad, u8, u16
from hal.wire.message import PeriodicMessage

SENSORS = 15
FIRST = 7  # sensors in the first of the two frames
DEFAULT_PERIOD_MS = 1


class Resolution(IntEnum):
    """Argument of SET_RESOLUTION."""

    SIXTEEN_BITS = 0
    TWELVE_BITS = 1  # a test: square and triangular waves instead of readings
    EIGHT_BITS = 2


def _bytes(kind: int, name: str, first: int, last: int) -> PeriodicMessage:
    layout = Layout([u8(f"hes{index}") for index in range(first, last + 1)])
    return PeriodicMessage(CLASS_ANALOG_PERIODIC, kind, name, layout)


def _words(kind: int, name: str, first: int, last: int) -> PeriodicMessage:
    words = [u16(f"hes{index}") for index in range(first, last + 1)]
    layout = Layout([*words, pad(8 - 2 * len(words))] if len(words) < 4 else words)
    return PeriodicMessage(CLASS_ANALOG_PERIODIC, kind, name, layout)


HALL_0_6 = _bytes(0xC, "HALL_0_6", 0, 6)
HALL_7_14 = _bytes(0xD, "HALL_7_14", 7, 14)

HALL_WORDS_0_3 = _words(0xC, "HALL_WORDS_0_3", 0, 3)
HALL_WORDS_4_7 = _words(0xD, "HALL_WORDS_4_7", 4, 7)
HALL_WORDS_8_11 = _words(0xE, "HALL_WORDS_8_11", 8, 11)
HALL_WORDS_12_14 = _words(0xF, "HALL_WORDS_12_14", 12, 14)  # the firmware sends two bytes more

MESSAGES: dict[int, PeriodicMessage] = {message.type: message for message in (HALL_0_6, HALL_7_14)}
"""Rows of the default resolution by type."""

WORD_MESSAGES: dict[int, PeriodicMessage] = {
    message.type: message
    for message in (HALL_WORDS_0_3, HALL_WORDS_4_7, HALL_WORDS_8_11, HALL_WORDS_12_14)
}
"""Rows of the 16-bit resolution by type."""
