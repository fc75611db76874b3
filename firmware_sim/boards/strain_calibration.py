"""From a STRAIN's six raw words to calibrated ones, and its EEPROM (can-protocol 5.2)."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from firmware_sim.boards.law import saturate_i16
from hal.wire.analog import CHANNELS, ZERO_WORD, Saturation

ONE = 0x7FFF  # the largest Q15 number: a diagonal of ONE is the factory matrix
SATURATED_BELOW = 1000
SATURATED_ABOVE = 64000
_HALF = 1 << 14
_QUARTER = 0x4000
_THREE_QUARTERS = 0xC000


def _identity() -> list[list[int]]:
    return [[ONE if row == column else 0 for column in range(CHANNELS)] for row in range(CHANNELS)]


def _zeros() -> list[int]:
    return [0] * CHANNELS


@dataclass(kw_only=True, slots=True)
class Eeprom:
    """Everything that SAVE2EE keeps, and the present tare, which is volatile."""

    full_scale: list[int]  # N, N, N, Nm, Nm, Nm
    matrix: list[list[int]] = field(default_factory=_identity)  # Q15, row = output channel
    gain: int = 1
    calibration_tare: list[int] = field(default_factory=_zeros)  # added to raw - 0x8000
    dac: list[int] = field(default_factory=_zeros)
    period_ms: int = 1
    serial: bytes = b"SN000\0\0"
    present_tare: list[int] = field(default_factory=_zeros)  # added to the calibrated values

    def copy(self) -> "Eeprom":
        """An independent copy without the volatile tare."""
        return replace(
            self,
            full_scale=list(self.full_scale),
            matrix=[list(row) for row in self.matrix],
            calibration_tare=list(self.calibration_tare),
            dac=list(self.dac),
            present_tare=_zeros(),
        )


def calibrated_values(memory: Eeprom, raw: Sequence[int]) -> list[int]:
    """Signed Q15 values of the six channels, without the present tare."""
    values = [
        saturate_i16(word - ZERO_WORD + tare)
        for word, tare in zip(raw, memory.calibration_tare, strict=True)
    ]
    return [
        saturate_i16(sum(m * v for m, v in zip(row, values, strict=True)) + _HALF >> 15)
        for row in memory.matrix
    ]


def is_factory(memory: Eeprom) -> bool:
    """True when neither matrix nor tares change a sample (see `passes_through`)."""
    return memory.matrix == _IDENTITY and not any((*memory.calibration_tare, *memory.present_tare))


def passes_through(raw: Sequence[int]) -> bool:
    """True when the factory matrix leaves all six words as they are.

    value * 0x7FFF / 0x8000, rounded, is the value itself while it is within a quarter of the
    words' range from zero.
    """
    return min(raw) > _QUARTER and max(raw) <= _THREE_QUARTERS


def calibrated_words(memory: Eeprom, raw: Sequence[int]) -> list[int]:
    """Unsigned words as they stand in the frames."""
    return [
        saturate_i16(value + tare) + ZERO_WORD
        for value, tare in zip(calibrated_values(memory, raw), memory.present_tare, strict=True)
    ]


def channel_states(raw: Sequence[int]) -> list[Saturation]:
    """Which channels are outside the range of the converter."""
    return [
        Saturation.LOW
        if word < SATURATED_BELOW
        else Saturation.HIGH
        if word > SATURATED_ABOVE
        else Saturation.OK
        for word in raw
    ]


_IDENTITY = _identity()
