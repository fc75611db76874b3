"""What others take for joint velocity and acceleration, written anew from their description.

AdaptiveWindow: iCub's (ctrlLib's adaptive window polynomial estimator): a least-squares line over
at most 16 samples for the velocity, a parabola over at most 25 for the acceleration, evaluated at
the newest sample. A window in which a sample is more than D = 1 deg away from the fit becomes one
sample shorter, else one longer.

NullJerkKalman: state angle, velocity, constant acceleration; white noise on each, in steady state.
The whole-body-estimators device leaves the covariances to the user; REPRODUCED gives within 6 % the
errors that were measured for a shipped configuration (velocity 0.02, 0.11, 0.40, 0.92 and
acceleration 0.20, 0.47, 0.94, 1.30 of a sine of 0.2, 0.5, 1, 2 Hz). STRENGTHS are the choices of a
user who knows the answer: the best of them is picked for each row anew.
"""

import math
from typing import Protocol

import numpy as np

from dforc.arrays import Matrix, Vector

PERIOD_S = 0.01
BOUND_RAD = math.radians(1.0)
# Variances added per sample to (rad, rad/s, rad/s2), in units of the encoder noise's.
REPRODUCED = (0.26, 6.36, 3455.0)
STRENGTHS = tuple((0.0, 0.0, 10.0**power) for power in np.arange(0.0, 10.0, 0.5).tolist())


class Peer(Protocol):
    """One way to differentiate."""

    def add(self, q_rad: Vector) -> tuple[Vector, Vector]:
        """Velocity and acceleration (n,) at this sample."""
        ...


class PolynomialWindow:
    """A polynomial over a window that adapts, for n joints."""

    def __init__(self, n: int, degree: int, longest: int) -> None:
        self._degree = degree
        self._longest = longest
        self._samples: list[Vector] = []
        self._length = np.full(n, degree + 1)
        self._fits = {length: _fit(length, degree) for length in range(degree + 1, longest + 1)}

    def add(self, q_rad: Vector) -> Vector:
        """The derivative of the polynomial's degree at the newest sample (n,)."""
        self._samples = [*self._samples[-self._longest + 1 :], q_rad]
        have = len(self._samples)
        result = np.zeros(len(q_rad))
        if have <= self._degree:
            return result
        samples = np.array(self._samples)
        for length in np.unique(np.minimum(self._length, have)).tolist():
            which = np.minimum(self._length, have) == length
            powers, inverse = self._fits[length]
            window = samples[-length:, which]
            coefficients = inverse @ window
            result[which] = coefficients[self._degree] * math.factorial(self._degree)
            fits = np.abs(powers @ coefficients - window).max(axis=0) <= BOUND_RAD
            self._length[which] = length + np.where(fits, 1, -1)
        self._length = np.clip(self._length, self._degree + 1, self._longest)
        return result


def _fit(length: int, degree: int) -> tuple[Matrix, Matrix]:
    instants = np.linspace(PERIOD_S * (1 - length), 0.0, length)
    powers = np.vander(instants, degree + 1, increasing=True)
    return powers, np.asarray(np.linalg.pinv(powers), dtype=np.float64)


class AdaptiveWindow:
    """The window of 16 for the velocity, that of 25 for the acceleration."""

    def __init__(self, n: int) -> None:
        self._velocity = PolynomialWindow(n, 1, 16)
        self._acceleration = PolynomialWindow(n, 2, 25)

    def add(self, q_rad: Vector) -> tuple[Vector, Vector]:
        """Velocity and acceleration (n,) at this sample."""
        return self._velocity.add(q_rad), self._acceleration.add(q_rad)


class NullJerkKalman:
    """Steady-state filter for n joints."""

    def __init__(self, n: int, variances: tuple[float, float, float]) -> None:
        self._F: Matrix = np.array(
            [[1.0, PERIOD_S, PERIOD_S**2 / 2.0], [0.0, 1.0, PERIOD_S], [0.0, 0.0, 1.0]]
        )
        P = np.eye(3)
        for _ in range(2000):
            P = self._F @ P @ self._F.T + np.diag(variances)
            self._gain: Vector = P[:, 0] / (P[0, 0] + 1.0)
            P = P - np.outer(self._gain, P[0])
        self._state: Matrix | None = None
        self._n = n

    def add(self, q_rad: Vector) -> tuple[Vector, Vector]:
        """Velocity and acceleration (n,) at this sample."""
        if self._state is None:
            self._state = np.zeros((3, self._n))
            self._state[0] = q_rad
        ahead = self._F @ self._state
        state: Matrix = ahead + self._gain[:, None] * (q_rad - ahead[0])
        self._state = state
        return state[1], state[2]
