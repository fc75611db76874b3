"""A force/torque sensor's offset from readings of a limb that nothing touches, also while it moves.

Each sample is what the sensor shows less what the model predicts for that very instant, so the limb
may move while they are taken; what fails is a fast motion, whose acceleration the encoders only
tell roughly. The offset is the mean over the samples.

Wrenches are (6,): force [N], then moment [Nm], sensor frame.
"""

from collections.abc import Sequence

import numpy as np

from dforc.arrays import ArrayLike, Vector, finite_vector
from dforc.errors import DforcError


class IncompleteError(DforcError):
    """The offset was asked for before enough samples were in."""


class UnknownSensorError(DforcError, ValueError):
    """A sensor was named that is not there; nothing was started."""


class OffsetCalibration:
    """Mean and spread of (measured - predicted) of one sensor."""

    __slots__ = ("_mean", "_squares", "count", "refused", "wanted")

    def __init__(self, wanted: int) -> None:
        """No sample yet; `wanted` make it complete."""
        self.wanted = wanted
        self.count = 0
        self.refused = 0  # in contact
        self._mean = np.zeros(6)
        self._squares = np.zeros(6)

    @property
    def complete(self) -> bool:
        """Enough samples are in."""
        return self.count >= self.wanted

    @property
    def offset(self) -> Vector:
        """Mean (6,) of the samples.

        Raises:
            IncompleteError: fewer samples than wanted.
        """
        if not self.complete or self.count == 0:
            raise IncompleteError(f"{self.count} samples of {self.wanted} wanted")
        return self._mean.copy()

    @property
    def spread(self) -> Vector:
        """Standard deviation (6,): far above the sensor's noise means it was touched, or fast."""
        return np.sqrt(self._squares / max(self.count, 1))

    def add(self, measured: ArrayLike, predicted: ArrayLike, *, in_contact: bool = False) -> bool:
        """Take a sample, unless the limb is touched; True when it was taken.

        Args:
            measured: reading (6,) after the matrix and the temperature, before the offset.
            predicted: what the model says for the same instant (6,).
            in_contact: the caller's gate: skin, contact detector, or the old offset's residual.

        Raises:
            NotFiniteError: NaN or infinity; nothing was taken.
        """
        if in_contact:
            self.refused += 1
            return False
        excess = finite_vector("reading", measured, 6) - finite_vector("prediction", predicted, 6)
        self.count += 1
        before = excess - self._mean
        self._mean += before / self.count
        self._squares += before * (excess - self._mean)
        return True


class Calibrations:
    """Those that run, by sensor; a request touches the sensors that it names and no other."""

    __slots__ = ("_running", "sensors")

    def __init__(self, sensors: Sequence[str]) -> None:
        self.sensors = tuple(sensors)
        self._running: dict[str, OffsetCalibration] = {}

    @property
    def running(self) -> tuple[str, ...]:
        """Sensors under calibration."""
        return tuple(self._running)

    def start(self, names: Sequence[str], samples: int) -> None:
        """Begin with those sensors, anew where one is under calibration already.

        Raises:
            UnknownSensorError: none was started.
        """
        for name in names:
            if name not in self.sensors:
                raise UnknownSensorError(f"no sensor {name!r}; known: {', '.join(self.sensors)}")
        for name in names:
            self._running[name] = OffsetCalibration(samples)

    def add(
        self, name: str, measured: ArrayLike, predicted: ArrayLike, *, in_contact: bool = False
    ) -> OffsetCalibration | None:
        """Give a sensor's sample to its calibration, if it has one; the calibration when complete.

        Raises:
            NotFiniteError: NaN or infinity; nothing was taken.
        """
        calibration = self._running.get(name)
        if calibration is None:
            return None
        calibration.add(measured, predicted, in_contact=in_contact)
        return self._running.pop(name) if calibration.complete else None

    def progress(self, name: str) -> OffsetCalibration | None:
        """The running calibration of a sensor, to report on it."""
        return self._running.get(name)

    def cancel(self, name: str) -> None:
        """Stop without a result."""
        self._running.pop(name, None)
