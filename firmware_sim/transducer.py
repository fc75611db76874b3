"""The strain gauges in front of a STRAIN board: a wrench becomes six words of its converter.

word = wrench x 0x8000 / full scale + 0x8000, with a constant error and noise, both drawn from the
seed; rounded, and held at the rails 0 and 0xFFFF (can-protocol fact sheet, 5.2).
"""

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import SensorSpec
from firmware_sim.draws import Draw, generator

Vector = NDArray[np.float64]

ZERO_WORD = 0x8000
TOP_WORD = 0xFFFF
SAMPLES_PER_DRAW = 1000  # noise is drawn a second at a time: one draw costs as much as a sample


class Transducer:
    """One six-axis sensor; `index` numbers the sensors of a robot, each with draws of its own."""

    def __init__(self, spec: SensorSpec, seed: int, index: int) -> None:
        per_unit = ZERO_WORD / np.array(spec.full_scale)
        bound = np.repeat(spec.offset, 3)  # N for the forces, Nm for the moments
        self.offset: Vector = generator(seed, Draw.SENSOR_OFFSET, index).uniform(-bound, bound)
        self._words_per_unit: Vector = per_unit
        self._deviation = np.repeat(spec.noise, 3) * per_unit
        self._level = self.offset * per_unit + ZERO_WORD + 0.5  # truncation then rounds
        self._noise_rng = generator(seed, Draw.SENSOR_NOISE, index)
        self._sample = SAMPLES_PER_DRAW
        self._levels: list[Vector] = []
        self._word: Vector = np.zeros(6)

    def words(self, wrench: Vector) -> list[int]:
        """Converter words (6) for a wrench (6: N then Nm, sensor frame)."""
        if self._sample == SAMPLES_PER_DRAW:
            draws = self._noise_rng.standard_normal((SAMPLES_PER_DRAW, 6))
            self._levels = list(draws * self._deviation + self._level)
            self._sample = 0
        word = self._word
        np.multiply(wrench, self._words_per_unit, out=word)
        word += self._levels[self._sample]
        self._sample += 1
        values = list(map(int, word.tolist()))
        if min(values) < 0 or max(values) > TOP_WORD:
            values = [min(max(value, 0), TOP_WORD) for value in values]
        return values
