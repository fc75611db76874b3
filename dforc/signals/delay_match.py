"""Joint motion and wrenches through one and the same filter, so that they stay comparable.

A force minus mass times acceleration is a contact only if both went through equal filters: where
the force lags the acceleration by 50 ms, a swinging arm seems to be pushed. Here every signal x is
replaced by

    y(t) = integral of g(s) x(t - s) ds,   g(s) = 35/(32 D) (1 - u^2)^3,  u = (s - D) / D,

a bell over the last 2 D seconds: finite, symmetric, hence a delay of exactly D at every frequency,
and smooth enough to be differentiated twice. Velocity and acceleration are the derivatives of that
very y, so position, velocity, acceleration and wrench all bear the same factor.

Between samples x is a straight line. Then the integral is exact for any instants, even and uneven,
and needs no model of the sampling: the weight of a sample is a second divided difference of g's
double antiderivative (position, wrench), of its antiderivative (velocity), of g (acceleration).
Before its first sample x is taken to have stood still.

D = 80 ms: of 12-bit encoders at 100 Hz it leaves 0.15 rad/s2 in the acceleration, and it passes
2 Hz at 95 %. Noise of the acceleration falls with D to the power 2.5.
"""

import math

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, finite_vector
from dforc.errors import DforcError, NotFiniteError
from dforc.signals.differentiation import (
    DENSEST_S,
    FASTEST_RAD_S,
    JUMP_RAD,
    JUMP_RAD_S,
    PATIENCE,
    JointMotion,
)
from dforc.signals.history import History

DELAY_S = 0.08
GAP_S = 0.1  # a longer silence starts anew
MOST_SAMPLES = 1024  # of 0.16 s: 6 kHz
PACE_S = 0.01  # over less, late arrivals tell a joint's speed wrong: two may be 50 us apart

# Coefficients of g = (1 - u^2)^3 * 35/32 in u, lowest power first, and of its antiderivatives.
BELL = np.array([1.0, 0.0, -3.0, 0.0, 3.0, 0.0, -1.0]) * 35.0 / 32.0
ONCE = np.array([0.5, *(BELL / np.arange(1.0, 8.0))])  # 0 at u = -1, 1 at u = 1
TWICE = np.array([35.0 / 256.0, *(ONCE / np.arange(1.0, 9.0))])  # 0 at u = -1, 1 at u = 1
POWERS = len(TWICE)
# Of value, slope, curve: the polynomial, and how steeply it goes on beyond u = 1.
POLYNOMIALS = np.array([np.pad(p, (0, POWERS - len(p))) for p in (TWICE, ONCE, BELL)])
STEEPNESS = np.array([1.0, 0.0, 0.0])
VALUE, SLOPE, ALL = slice(0, 1), slice(1, 2), slice(0, 3)


class NoSampleError(DforcError):
    """A filter was read before its first sample."""


class MatchedFilter:
    """Some channels, sampled together at any instants, delayed by `delay_s` and smoothed."""

    __slots__ = ("_history", "channels", "delay_s", "late_samples", "resets")

    def __init__(self, channels: int, *, delay_s: float = DELAY_S) -> None:
        """Empty.

        Args:
            channels: values per sample.
            delay_s: the same for all that is to be compared.
        """
        self.channels = channels
        self.delay_s = delay_s
        self._history = History(channels, MOST_SAMPLES)
        self.resets = 0  # gaps
        self.late_samples = 0  # not newer than the one before: dropped

    @property
    def settled(self) -> bool:
        """The window is full of samples."""
        at_s = self._history.at_s
        # As `_append` forgets: the difference of the two instants may round the other way.
        return len(at_s) > 1 and bool(at_s[0] <= at_s[-1] - 2.0 * self.delay_s)

    def push(self, values: ArrayLike, at_s: float) -> None:
        """Take in one sample (channels,).

        Raises:
            NotFiniteError: NaN or infinity; nothing has changed.
        """
        sample = finite_vector("sample", values, self.channels)
        if not math.isfinite(at_s):
            raise NotFiniteError(f"instant of the sample is {at_s}")
        self._append(sample, at_s)

    def value(self, at_s: float) -> Vector:
        """Filtered values (channels,) at `at_s` - delay_s, from the samples up to `at_s`.

        Raises:
            NoSampleError: nothing was pushed yet.
            NotFiniteError: the instant is NaN or infinity.
        """
        value: Vector = self._weights(at_s, VALUE)[0] @ self._history.values
        return value

    def slope(self, at_s: float) -> Vector:
        """Derivative (channels,) of `value`, per second.

        Raises:
            NoSampleError: nothing was pushed yet.
            NotFiniteError: the instant is NaN or infinity.
        """
        slope: Vector = self._weights(at_s, SLOPE)[0] @ self._history.values / self.delay_s
        return slope

    def add(self, values: ArrayLike, at_s: float) -> Vector:
        """`push` and `value` at the same instant."""
        self.push(values, at_s)
        return self.value(at_s)

    def reset(self) -> None:
        """Forget everything."""
        self._history.clear()

    def _append(self, sample: Vector, at_s: float) -> None:
        history = self._history
        if len(history):
            step_s = at_s - float(history.at_s[-1])
            if step_s <= 0.0:
                self.late_samples += 1
                return
            if step_s > GAP_S:
                self.resets += 1
                history.clear()
        history.append(sample, at_s)
        history.forget_before(at_s - 2.0 * self.delay_s)

    def _weights(self, at_s: float, which: slice) -> Matrix:
        """Of each sample (rows, k): second divided difference of a function of the age over D.

        A divided difference less for slope and curve. The function is a polynomial inside the bell,
        and goes on straight beyond its old end.
        """
        instants = self._history.at_s
        if len(instants) == 0:
            raise NoSampleError("no sample yet")
        if not math.isfinite(at_s):
            raise NotFiniteError(f"instant of the reading is {at_s}")
        u = (at_s - instants) / self.delay_s - 1.0  # falls
        inside = np.minimum(u, 1.0)
        powers = np.empty((POWERS, len(u)))
        powers[0] = 1.0
        powers[1:] = np.maximum(inside, -1.0)
        np.multiply.accumulate(powers, axis=0, out=powers)
        steepness = STEEPNESS[which, None]
        f = POLYNOMIALS[which] @ powers + steepness * (u - inside)
        slopes = np.zeros((len(f), len(u) + 1))  # the newest value lasts until at_s: 0
        slopes[:, :1] = steepness  # the oldest goes back for ever
        np.divide(f[:, :-1] - f[:, 1:], u[:-1] - u[1:], out=slopes[:, 1:-1])
        weights: Matrix = slopes[:, :-1] - slopes[:, 1:]
        return weights


class MatchedMotion(MatchedFilter):
    """Angles of n joints through the matched filter, with velocity and acceleration of the result.

    A joint that leaves its path by more than motion can is flagged in `jumped` (n,) for that one
    sample, and its history is moved along, so the jump enters neither velocity nor acceleration.
    One that jumps again and again is taken to stand still.

    Samples may come out of pace: one late and the next on its heels, or two parts of the robot one
    after the other, the first with the other's old angles. So the path is told over `PACE_S` and
    more, and a sample that comes early may be off it by what the joint does in the missing time.
    """

    __slots__ = ("_restless", "jumped", "n")

    def __init__(self, n: int, *, delay_s: float = DELAY_S) -> None:
        super().__init__(n, delay_s=delay_s)
        self.n = n
        self.jumped = np.zeros(n, dtype=np.bool_)
        self._restless = np.zeros(n, dtype=np.int64)

    def motion(self, at_s: float) -> JointMotion:
        """Motion at `at_s` - delay_s.

        Raises:
            NoSampleError: nothing was pushed yet.
            NotFiniteError: the instant is NaN or infinity.
        """
        q, dq, ddq = self._weights(at_s, ALL) @ self._history.values
        return JointMotion(q, dq / self.delay_s, ddq / self.delay_s**2)

    def _append(self, sample: Vector, at_s: float) -> None:
        values, instants = self._history.values, self._history.at_s
        self.jumped = np.zeros(self.n, dtype=np.bool_)
        if len(values) and at_s > instants[-1]:
            step_s = float(at_s - instants[-1])
            moved: Vector = np.zeros(self.n)
            bound_rad: Vector = np.full(self.n, JUMP_RAD + FASTEST_RAD_S * step_s)
            start = max(int(np.searchsorted(instants, instants[-1] - PACE_S, side="right")) - 1, 0)
            span_s = float(instants[-1] - instants[start])
            if span_s >= DENSEST_S:
                speed_rad_s = (values[-1] - values[start]) / span_s
                moved = speed_rad_s * step_s
                early_s = max(float(instants[-1] - instants[-2]) - step_s, 0.0)
                bound_rad = JUMP_RAD + JUMP_RAD_S * step_s + np.abs(speed_rad_s) * early_s
            moved[self._restless >= PATIENCE] = 0.0
            excess = sample - values[-1] - moved
            self.jumped = np.abs(excess) > bound_rad
            self._restless = np.where(self.jumped, self._restless + 1, 0)
            if self.jumped.any():
                values[:, self.jumped] += excess[self.jumped]
        super()._append(sample, at_s)
