"""Where an object is, how fast it moves and how sure that is, from positions with noise.

One tracker per object. Samples may come irregularly or be missing, an outlier is skipped, a jump
starts anew. An object that comes to rest is averaged until it moves again.

There are two filters. The steady one finds out how restless its object is: smooth enough to be
followed, but late by some centimetres when a hand begins or ends a motion. The nimble one always
takes it for restless: what must not be touched is taken to be there, unless it is at rest.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from dforc.arrays import ArrayLike, Matrix, Vector, constant, finite_vector
from dforc.errors import DforcError, NotFiniteError
from dforc.field import tracking_kernel as kernel

SIGMA_M = 0.005  # of a position whose covariance is not given, each axis
VELOCITY_SIGMA_M_S = 0.005  # of a velocity that is given, each axis
# Of the nimble filter [m^2/s^3]. Of strokes by hand (minimum jerk to 0.35 m/s, 5 mm of noise) its
# error is 16 mm at most, that of the steady one 51 mm; from 0.01 to 0.1 it is nearly the same.
NIMBLE_Q, NIMBLE_SIGMA_M = 0.02, 0.005
HIGHEST_NIMBLE_Q = 0.5  # of what is seen more sharply: it may be followed more quickly
STILL_THERE = 14.0  # squared Mahalanobis distance of nimble place and speed from those at rest
LONGEST_PREDICTION_S = 0.5  # nothing is extrapolated farther; only the doubt grows on


class TrackingError(DforcError, ValueError):
    """A covariance that is none, or a question about an object that was never seen."""


class Sample(IntEnum):
    """What became of a sample."""

    TAKEN = kernel.TAKEN
    SKIPPED = kernel.SKIPPED  # an outlier, until more follow
    RESTARTED = kernel.RESTARTED  # the first, or after a jump or a long gap
    IGNORED = kernel.IGNORED  # not newer than the last


class ObjectState(NamedTuple):
    """An object at some time."""

    position_m: Vector  # (3,)
    velocity_m_s: Vector  # (3,)
    sigma_m: float  # standard deviation of the position along its least certain axis


def new_track(lowest_q: float = kernel.LOWEST_Q) -> kernel.Track:
    """Nothing known yet, but how restless the object is at least [m^2/s^3]."""
    numbers = np.zeros(kernel.NUMBERS)
    numbers[kernel.LOWEST] = lowest_q
    return kernel.Track(
        numbers=numbers,
        state=np.zeros(6),
        P=np.zeros((6, 6)),
        drift=np.zeros(3),
    )


class ObjectTracker:
    """Two Kalman filters of one object; times in s on any one clock."""

    def __init__(self, sigma_m: float = SIGMA_M) -> None:
        """Take the standard deviation of positions that come without a covariance.

        Raises:
            TrackingError: it is not positive.
        """
        if not 0.0 < sigma_m < math.inf:
            raise TrackingError(f"sigma_m must be positive, not {sigma_m}")
        self._track = new_track()
        self._nimble = new_track(NIMBLE_Q)
        self._covariance = constant(sigma_m**2 * np.eye(3)).copy()

    def update(
        self,
        t_s: float,
        position_m: ArrayLike,
        covariance_m2: Matrix | None = None,
        velocity_m_s: ArrayLike | None = None,
    ) -> Sample:
        """Take in a position, and the velocity where the sender knows it.

        Raises:
            NotFiniteError, ShapeError: of what is given; the track stays as it is.
            TrackingError: a covariance (3, 3) that is not symmetric and positive definite.
        """
        if not math.isfinite(t_s):
            raise NotFiniteError(f"a position at {t_s} s")
        position = finite_vector("position_m", position_m, 3)
        R = self._covariance if covariance_m2 is None else _checked(covariance_m2)
        velocity = None if velocity_m_s is None else finite_vector("velocity_m_s", velocity_m_s, 3)
        sharpness = 3.0 * NIMBLE_SIGMA_M**2 / float(np.trace(R))
        nimble_q = min(max(NIMBLE_Q * sharpness, NIMBLE_Q), HIGHEST_NIMBLE_Q)
        self._nimble.numbers[kernel.LOWEST] = nimble_q
        found = [Sample.IGNORED, Sample.IGNORED]
        for i, track in enumerate((self._track, self._nimble)):
            found[i] = Sample(kernel.take(track, float(t_s), position, R))
            if velocity is not None and found[i] in (Sample.TAKEN, Sample.RESTARTED):
                kernel.take_velocity(track, velocity, VELOCITY_SIGMA_M_S**2)
        return found[0]

    @property
    def is_seen(self) -> bool:
        """Whether there has been a sample."""
        return bool(self._track.numbers[kernel.SAMPLES] > 0.0)

    @property
    def at_rest(self) -> bool:
        """Whether the object has been still for a while."""
        return bool(self._track.numbers[kernel.STILL] >= kernel.REST_AFTER_S)

    @property
    def last_s(self) -> float:
        """Time of the newest sample that was not ignored."""
        return float(self._track.numbers[kernel.TIME])

    def at(self, t_s: float) -> ObjectState:
        """The object at a time, not before the last sample, as it is best followed.

        Raises:
            TrackingError: there has been no sample.
        """
        return self._predicted(self._track, t_s)

    def avoided_at(self, t_s: float) -> ObjectState:
        """The object at a time, not before the last sample, as it is best kept clear of.

        Raises:
            TrackingError: there has been no sample.
        """
        return self._predicted(self._track if self._is_still_there() else self._nimble, t_s)

    def _is_still_there(self) -> bool:
        """Whether the nimble filter does not gainsay that the object is at rest."""
        if not self.at_rest:
            return False
        off = self._nimble.state - self._track.state
        return float(off @ np.linalg.solve(self._nimble.P, off)) < STILL_THERE

    def _predicted(self, track: kernel.Track, t_s: float) -> ObjectState:
        if not self.is_seen:
            raise TrackingError("the object has never been seen")
        dt = max(0.0, t_s - self.last_s)
        state, P = track.state.copy(), track.P.copy()
        velocity = state[3:].copy()
        near = min(dt, LONGEST_PREDICTION_S)
        kernel.predict(state, P, track.numbers[kernel.RESTLESSNESS], dt)
        return ObjectState(
            position_m=state[:3] - (dt - near) * velocity,
            velocity_m_s=velocity if dt <= LONGEST_PREDICTION_S else np.zeros(3),
            sigma_m=math.sqrt(np.linalg.eigvalsh(P[:3, :3])[-1]),
        )


def _checked(covariance_m2: Matrix) -> Matrix:
    R: Matrix = np.ascontiguousarray(covariance_m2, dtype=np.float64).copy()
    if R.shape != (3, 3) or not np.isfinite(R).all() or not np.allclose(R, R.T, atol=1e-12):
        raise TrackingError(f"no covariance of a position: {R.tolist()}")
    if np.linalg.eigvalsh(R)[0] <= 0.0:
        raise TrackingError(f"a covariance that is not positive definite: {R.tolist()}")
    return R
