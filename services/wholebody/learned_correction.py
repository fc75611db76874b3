"""The learner's word on every sensor, for as long as it is fresh; then the model stands alone."""

import math

import numpy as np

from dforc.arrays import Matrix
from services.core.service import Inputs
from services.messages import Floats
from services.streams import LEARNED
from services.wholebody.body import BodySensor

AGE_S = 0.1


class Correction:
    """What is to be taken off the filtered readings (m, 6), beside the model's prediction."""

    def __init__(self, sensors: tuple[BodySensor, ...]) -> None:
        self.wrenches: Matrix = np.zeros((len(sensors), 6))
        self.spread_n = [math.inf] * len(sensors)  # of the force that is left; inf = not known
        self.refused = 0
        self._in_force = False
        self._row = {sensor.name: i for i, sensor in enumerate(sensors)}

    def take(self, inputs: Inputs) -> None:
        """Look at what has arrived. A correction that is not finite is refused, not the others."""
        message = inputs.new(LEARNED)
        if message is not None:
            self._forget()
            for correction in message.corrections:
                row = self._row.get(correction.name)
                if row is not None and _is_wrench(correction.wrench):
                    self.wrenches[row] = correction.wrench
                    self.spread_n[row] = _spread_n(correction.std)
                else:
                    self.refused += 1
            self._in_force = True
        elif self._in_force and inputs.age_s(LEARNED) > AGE_S:
            self._forget()
            self._in_force = False

    def _forget(self) -> None:
        self.wrenches = np.zeros_like(self.wrenches)
        self.spread_n = [math.inf] * len(self.spread_n)


def _spread_n(std: Floats) -> float:
    """Standard deviation of the force; infinite where the learner does not know it yet."""
    size_n = math.hypot(*std[:3]) if _is_wrench(std) else 0.0
    return size_n if size_n > 0.0 else math.inf


def _is_wrench(values: Floats) -> bool:
    return len(values) == 6 and math.isfinite(math.hypot(*values))
