"""Whether a limb is touched: two thresholds and a debounce on the size of the force residual."""

import math

import numpy as np

from dforc.arrays import ArrayLike, finite_vector
from dforc.errors import DforcError, NotFiniteError

MOST_SAMPLES = 3
TAIL = 0.1  # share of the levels that the tail is fitted to
LEAST_LEVELS = 100


class ThresholdError(DforcError, ValueError):
    """Thresholds or a debounce that no detector can work with."""


class ContactDetector:
    """Contact of one limb.

    Touching begins with the `on_samples`-th sample in a row at or above `on`, and ends with the
    `off_samples`-th in a row below `off`. Between the thresholds nothing changes.
    """

    __slots__ = ("_count", "_off", "_off_samples", "_on", "_on_samples", "touching")

    def __init__(self, on: float, off: float, *, on_samples: int = 2, off_samples: int = 3) -> None:
        """Start untouched.

        Args:
            on: level at which a contact begins, N (or the unit of the level that is handed in).
            off: level below which it ends, at most `on`.
            on_samples: how many samples in a row it takes to begin, 1 to 3.
            off_samples: how many it takes to end, 1 to 3.

        Raises:
            ThresholdError: not 0 < off <= on, or a debounce out of range.
        """
        if not 0.0 < off <= on < math.inf:
            raise ThresholdError(f"thresholds must be 0 < off <= on, not off {off}, on {on}")
        if not (1 <= on_samples <= MOST_SAMPLES and 1 <= off_samples <= MOST_SAMPLES):
            raise ThresholdError(f"debounce must be 1 to {MOST_SAMPLES} samples")
        self._on, self._off = on, off
        self._on_samples, self._off_samples = on_samples, off_samples
        self.touching = False
        self._count = 0  # samples in a row that ask for the other state

    def update(self, level: float) -> bool:
        """Take one sample; whether the limb is touched now.

        Raises:
            NotFiniteError: the level is NaN or infinity; the state stays as it was.
        """
        if not math.isfinite(level):
            raise NotFiniteError(f"contact level is not finite: {level}")
        if self.touching:
            wanted, needed = level < self._off, self._off_samples
        else:
            wanted, needed = level >= self._on, self._on_samples
        self._count = self._count + 1 if wanted else 0
        if self._count >= needed:
            self.touching = not self.touching
            self._count = 0
        return self.touching

    def reset(self) -> None:
        """Untouched, as at the start: after a calibration or a lost sensor."""
        self.touching = False
        self._count = 0


def threshold_for(levels: ArrayLike, period_s: float, per_hour: float = 1.0) -> float:
    """Level that a single sample without contact exceeds `per_hour` times an hour.

    The largest tenth of the levels is taken to fall off exponentially, and is carried on beyond
    what was seen. The debounce is the reserve for motion unlike the one that the levels are from.

    Args:
        levels: norms of the residual without contact, at least 100, in the unit of the detector.
        period_s: between two samples.
        per_hour: how often.

    Raises:
        ThresholdError: too few levels, or all of them the same.
        NotFiniteError: a level is NaN or infinity.
    """
    seen = finite_vector("levels", levels, len(levels))
    if len(seen) < LEAST_LEVELS:
        raise ThresholdError(f"{len(seen)} levels are too few; it takes {LEAST_LEVELS}")
    start = float(np.quantile(seen, 1.0 - TAIL))
    beyond = seen[seen > start] - start
    if not beyond.size:
        raise ThresholdError("the levels do not vary")
    samples_per_hour = 3600.0 / period_s
    return start + float(beyond.mean()) * math.log(TAIL * samples_per_hour / per_hour)
