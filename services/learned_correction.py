"""The learner's word on every sensor, for as long as it is fresh; then the model stands alone."""

import math

import numpy as np

from dforc.arrays import Matrix
from services.body import BodySensor
from services.core.service import Inputs
from services.messages import Floats
from services.streams import LEARNED

AGE_S = 0.1


class Correction:
    """What is to be taken off the filtered readings (m, 6), beside the model's prediction."""

    def __init__(self, sensors: tuple[BodySensor, ...]) -> None:
        self.wrenches: Matrix = np.zeros((len(sensors), 6))
        self.refused = 0
        self._in_force = False
        self._row = {sensor.name: i for i, sensor in enumerate(sensors)}

    def take(self, inputs: Inputs) -> None:
        """Look at what has arrived. A correction that is not finite is refused, not the others."""
        message = inputs.new(LEARNED)
        if message is not None:
            self.wrenches = np.zeros_like(self.wrenches)
            for correction in message.corrections:
                row = self._row.get(correction.name)
                if row is not None and _is_wrench(correction.wrench):
                    self.wrenches[row] = correction.wrench
                else:
                    self.refused += 1
            self._in_force = True
        elif self._in_force and inputs.age_s(LEARNED) > AGE_S:
            self.wrenches = np.zeros_like(self.wrenches)
            self._in_force = False


def _is_wrench(values: Floats) -> bool:
    return len(values) == 6 and math.isfinite(math.hypot(*values))
