"""The strain gauges in front of the STRAIN boards: a wrench becomes six words of its converter.

word = wrench x 0x8000 / full scale + 0x8000, with a constant error and noise, both drawn from the
seed; rounded, and held at the rails 0 and 0xFFFF (can-protocol fact sheet, 5.2).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_sim.description import SensorSpec
from firmware_sim.draws import Draw, generator

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

ZERO_WORD = 0x8000
TOP_WORD = 0xFFFF
SAMPLES_PER_DRAW = 1000  # noise is drawn a second at a time: one draw costs as much as a sample


class Transducers:
    """All six-axis sensors of a robot, each with draws of its own."""

    def __init__(self, specs: Sequence[SensorSpec], seed: int) -> None:
        n = len(specs)
        scale = np.array([spec.full_scale for spec in specs]).reshape(n, 6)
        bounds = [np.repeat(spec.offset, 3) for spec in specs]  # N for the forces, Nm for moments
        drawn = [
            generator(seed, Draw.SENSOR_OFFSET, index).uniform(-bound, bound)
            for index, bound in enumerate(bounds)
        ]
        self.offset: Matrix = np.array(drawn).reshape(n, 6)
        self._words_per_unit: Matrix = ZERO_WORD / scale
        deviation = np.array([np.repeat(spec.noise, 3) for spec in specs]).reshape(n, 6)
        self._deviation: Matrix = deviation * self._words_per_unit
        # Truncation then rounds.
        self._level: Matrix = self.offset * self._words_per_unit + ZERO_WORD + 0.5
        self._noise_rngs = [generator(seed, Draw.SENSOR_NOISE, index) for index in range(n)]
        self._sample = SAMPLES_PER_DRAW
        self._levels: list[Matrix] = []
        self._word: Matrix = np.zeros((n, 6))

    def words(self, wrenches: Matrix) -> list[list[int]]:
        """Converter words (6 each) for one wrench per sensor (6: N then Nm, sensor frame)."""
        if not self._noise_rngs:
            return []
        if self._sample == SAMPLES_PER_DRAW:
            draws = [rng.standard_normal((SAMPLES_PER_DRAW, 6)) for rng in self._noise_rngs]
            self._levels = list(np.stack(draws, axis=1) * self._deviation + self._level)
            self._sample = 0
        word = self._word
        np.multiply(wrenches, self._words_per_unit, out=word)
        word += self._levels[self._sample]
        self._sample += 1
        np.minimum(word, TOP_WORD, out=word)
        np.maximum(word, 0.0, out=word)
        values: list[list[int]] = word.astype(np.int64).tolist()
        return values
