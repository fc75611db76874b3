"""From the raw numbers of a force/torque sensor to the wrench, and to the delay-matched wrench.

    w = C2 raw - offset + k_T (T - T0)

C2 is the secondary matrix (6x6) that corrects the maker's, k_T the drift with temperature. The
filter runs on the raw numbers and the temperature: the sum is linear, so the order changes
nothing, and a new offset or matrix holds at once instead of creeping through the filter's memory.

Wrenches are (6,): force [N], then moment [Nm], sensor frame.
"""

import math

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import NotFiniteError
from dforc.signals.delay_match import DELAY_S, MatchedFilter


class FtChannel:
    """Of one sensor. What is not finite raises and enters nothing."""

    __slots__ = ("_drift", "_filter", "_matrix", "_offset", "_reference_degc", "_sample")

    def __init__(
        self,
        *,
        drift_per_degc: ArrayLike = (0.0,) * 6,
        reference_degc: float = 25.0,
        delay_s: float = DELAY_S,
    ) -> None:
        """Matrix one, offset zero.

        Args:
            drift_per_degc: k_T (6,) in N, Nm per degree.
            reference_degc: T0, at which the offset was taken.
            delay_s: of `filtered`; the joints' filter must have the same.
        """
        self._drift = constant(finite_vector("drift", drift_per_degc, 6))
        self._reference_degc = reference_degc
        self._matrix = constant(np.eye(6))
        self._offset = constant(np.zeros(6))
        self._filter = MatchedFilter(7, delay_s=delay_s)
        self._sample: Vector = np.zeros(7)

    @property
    def delay_s(self) -> float:
        """Delay of `filtered`."""
        return self._filter.delay_s

    @property
    def settled(self) -> bool:
        """The filter's memory is full."""
        return self._filter.settled

    @property
    def offset(self) -> Vector:
        """What is subtracted (6,); read-only."""
        return self._offset

    @property
    def matrix(self) -> Matrix:
        """C2 (6, 6); read-only."""
        return self._matrix

    def set_offset(self, offset: ArrayLike) -> None:
        """Subtract (6,) from now on.

        Raises:
            NotFiniteError: the old one stays.
        """
        self._offset = constant(finite_vector("offset", offset, 6))

    def set_matrix(self, matrix: Matrix) -> None:
        """Use C2 (6, 6) from now on; an offset taken under the old one no longer fits.

        Raises:
            NotFiniteError: the old one stays.
        """
        self._matrix = constant(finite_vector("matrix", np.ravel(matrix), 36).reshape(6, 6))

    def wrench(self, raw: ArrayLike, temperature_degc: float | None = None) -> Vector:
        """Compensated wrench (6,) without filter, for the torques; no temperature: no drift.

        Raises:
            NotFiniteError: NaN or infinity in the reading.
        """
        return self._compensated(finite_vector("reading", raw, 6), self._warming(temperature_degc))

    def without_offset(self, raw: ArrayLike, temperature_degc: float | None = None) -> Vector:
        """`wrench` before the offset is subtracted (6,): what an offset calibration averages.

        Raises:
            NotFiniteError: NaN or infinity in the reading.
        """
        return self.wrench(raw, temperature_degc) + self._offset

    def push(self, raw: ArrayLike, at_s: float, temperature_degc: float | None = None) -> None:
        """Take a reading into the filter.

        Raises:
            NotFiniteError: NaN or infinity; the filter is as before.
        """
        self._sample[:6] = finite_vector("reading", raw, 6)
        self._sample[6] = self._warming(temperature_degc)
        self._filter.push(self._sample, at_s)

    def filtered(self, at_s: float) -> Vector:
        """Compensated wrench (6,) at `at_s` - delay_s.

        Raises:
            NoSampleError: nothing was pushed yet.
        """
        smooth = self._filter.value(at_s)
        return self._compensated(smooth[:6], float(smooth[6]))

    def reset(self) -> None:
        """Empty the filter; matrix and offset stay."""
        self._filter.reset()

    def _warming(self, temperature_degc: float | None) -> float:
        if temperature_degc is None:
            return 0.0
        if not math.isfinite(temperature_degc):
            raise NotFiniteError(f"temperature is {temperature_degc}")
        return temperature_degc - self._reference_degc

    def _compensated(self, raw: Vector, warming_degc: float) -> Vector:
        wrench: Vector = self._matrix @ raw - self._offset + self._drift * warming_degc
        return wrench
