"""Joint velocity and acceleration from coarse encoders, at the instant of the newest sample.

Method: a bank of Kalman filters, each for a position whose third derivative is a random walk of
another strength (a local quartic spline), weighted per joint by how well each predicted the last
half second of samples. Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and
Navigation", ch. 11 (static multiple models) and 6.2 (Wiener-process kinematic models).

Why: noise asks for a long memory, lag for a short one. At rest the filter of 3 rad/s wins and is
quieter than a window of 25 samples; in a swing the fastest ones win and the lag shrinks to a few
milliseconds. The filters look ahead by their own model, so nothing is delayed on purpose.

Quantisation: the noise is at least that of a uniform error of one quantum, R = quantum^2 / 12, so
an encoder that stands still does not make a filter overconfident; where a count flickers or a slow
joint climbs stairs it is more, so each filter's R is estimated from its own innovations (the
likelihood is concentrated over R).

Tuning: the bandwidths span all that an arm does between breathing and a collision (0.5 to 17 Hz) in
steps of 1.8, between which the weights interpolate; nothing else sets the lag. The memory of the
evidence, 0.5 s, trades noise at rest (of the acceleration: 3.7 times at 0.2 s) against the time
that the bank needs to calm down after a move. None of these was fitted to one kind of motion.

Covariances do not depend on the data, so all joints share them; instants may be irregular. Samples
that come sooner than 2.5 ms after the last one are answered by prediction.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import ArrayLike, Vector, finite_vector
from dforc.errors import NotFiniteError

QUANTUM_RAD = 2.0 * math.pi / 4096.0  # 12 bits per turn of the joint
BANDWIDTHS_RAD_S = (3.3, 5.9, 10.5, 18.7, 33.2, 59.0, 105.0)  # at 100 samples per second
REFERENCE_PERIOD_S = 0.01  # of the bandwidths
EVIDENCE_S = 0.5
GAP_S = 0.1  # a longer silence starts anew: ten joint states
DENSEST_S = 0.0025  # sooner, a slow joint's encoder shows stairs and no noise
JUMP_RAD = 0.01  # 7 quanta
JUMP_RAD_S = 2.0  # no joint changes its speed by so much in one sample
FASTEST_RAD_S = 10.0  # bound while a joint's speed is not known yet
PATIENCE = 3  # samples in a row that jump before the joint starts anew
GRACE = 8  # samples until the speed of a joint that starts is known
PRIOR = (1.0, 1.0, 10.0, 100.0)  # position in noise units; rad/s, rad/s2, rad/s3
ORDER = 4


class JointMotion(NamedTuple):
    """What the joints do; arrays of shape (n,), rad, s."""

    q_rad: Vector
    dq_rad_s: Vector
    ddq_rad_s2: Vector


class Differentiator:
    """Of n joints that are sampled together. Feed every joint state; nothing that comes out is NaN.

    `jumped` (n,) tells which joints left their path by more than motion can in the newest sample:
    the joint's history is moved along, so the jump enters neither velocity nor acceleration; a
    joint that jumps again and again starts anew, at rest. `resets` counts these new
    starts, and those of all joints together after a gap.
    """

    delay_s = 0.0  # of what comes out; its error includes the filters' lag

    __slots__ = (
        "_at_s",
        "_bank",
        "_count",
        "_covariance",
        "_floor",
        "_grace",
        "_innovation",
        "_log_gain",
        "_motion",
        "_restless",
        "_samples",
        "_state",
        "_weight",
        "jumped",
        "late_samples",
        "n",
        "resets",
    )

    def __init__(self, n: int, *, quantum_rad: float = QUANTUM_RAD) -> None:
        """All joints at rest, nothing known.

        Args:
            n: joints.
            quantum_rad: step of the encoders.
        """
        self.n = n
        self._floor = quantum_rad * quantum_rad / 12.0
        # In units of R: strength of the white noise that drives the random walk, per filter.
        self._bank = np.array(BANDWIDTHS_RAD_S) ** (2 * ORDER) * REFERENCE_PERIOD_S
        self._at_s = math.nan
        self.resets = 0
        self.late_samples = 0
        self._motion = JointMotion(np.zeros(n), np.zeros(n), np.zeros(n))
        self._start(np.zeros(n))

    @property
    def settled(self) -> bool:
        """The filters have seen enough samples since the start or the last gap."""
        return self._samples > GRACE

    def add(self, q_rad: ArrayLike, at_s: float) -> JointMotion:
        """Motion at `at_s`, from the encoders' angles (n,) at that instant.

        A sample that is not newer than the last one changes nothing; it is counted in
        `late_samples`.

        Raises:
            NotFiniteError: NaN or infinity in the angles or the instant; nothing has changed.
            ShapeError: not n angles.
        """
        q = finite_vector("joint angles", q_rad, self.n)
        if not math.isfinite(at_s):
            raise NotFiniteError(f"instant of the joint angles is {at_s}")
        step_s = at_s - self._at_s
        if step_s <= 0.0:
            self.late_samples += 1
            return self._motion
        if step_s < DENSEST_S:
            return self._ahead(step_s)
        self._at_s = at_s
        self._samples += 1
        if not step_s <= GAP_S:  # or the first sample
            self.resets += math.isfinite(step_s)
            self._start(q)
            return self._motion
        self._predict(step_s)
        expected = (self._weight * self._state[:, 0]).sum(axis=0)
        self._watch_jumps(q, expected, step_s)
        self._correct(q, step_s)
        mean = (self._weight[:, None, :] * self._state[:, :3]).sum(axis=0)
        self._motion = JointMotion(*mean)
        return self._motion

    def reset(self) -> None:
        """Forget everything: the next sample is the first one."""
        self._at_s = math.nan
        self._samples = 0

    def _start(self, q: Vector) -> None:
        filters = len(self._bank)
        self._state = np.zeros((filters, ORDER, self.n))
        self._state[:, 0] = q
        prior = np.array(PRIOR)
        prior[1:] /= math.sqrt(self._floor)
        self._covariance = np.tile(np.diag(prior * prior), (filters, 1, 1))
        self._innovation = np.full((filters, self.n), self._floor)
        self._log_gain = np.zeros(filters)
        self._weight = np.full((filters, self.n), 1.0 / filters)
        self._count = 0.0
        self._samples = 0
        self._grace = np.full(self.n, GRACE)
        self._restless = np.zeros(self.n, dtype=np.int64)
        self.jumped = np.zeros(self.n, dtype=np.bool_)
        self._motion = JointMotion(q, np.zeros(self.n), np.zeros(self.n))

    def _predict(self, step_s: float) -> None:
        F, Q = _transition(step_s)
        self._state = F @ self._state
        self._covariance = F @ self._covariance @ F.T + self._bank[:, None, None] * Q

    def _ahead(self, step_s: float) -> JointMotion:
        q, dq, ddq = self._motion
        return JointMotion(q + step_s * (dq + 0.5 * step_s * ddq), dq + step_s * ddq, ddq.copy())

    def _watch_jumps(self, q: Vector, expected: Vector, step_s: float) -> None:
        excess = q - expected
        speed = np.where(self._grace > 0, FASTEST_RAD_S, JUMP_RAD_S)
        self.jumped = np.abs(excess) > JUMP_RAD + speed * step_s
        self._grace = np.maximum(self._grace - 1, 0)
        self._restless = np.where(self.jumped, self._restless + 1, 0)
        if not self.jumped.any():
            return
        again = self._restless > PATIENCE
        self.resets += int(again.sum())
        self._state[:, 0] += np.where(self.jumped, excess, 0.0)
        self._state[:, 1:, again] = 0.0
        self._state[:, 0, again] = q[again]
        self._grace[again] = GRACE

    def _correct(self, q: Vector, step_s: float) -> None:
        spread = self._covariance[:, 0, 0] + 1.0  # of the innovation, in units of R
        gain = self._covariance[:, :, 0] / spread[:, None]
        self._covariance -= gain[:, :, None] * self._covariance[:, None, 0, :]
        innovation = q - self._state[:, 0]
        self._state += gain[:, :, None] * innovation[:, None, :]
        kept = math.exp(-step_s / EVIDENCE_S)
        self._count = kept * self._count + 1.0
        share = 1.0 / self._count
        self._innovation += share * (innovation * innovation / spread[:, None] - self._innovation)
        self._log_gain += share * (np.log(spread) - self._log_gain)
        self._weigh()

    def _weigh(self) -> None:
        """Posterior (filters, n) of each filter, its noise level taken at the best value."""
        noise = np.maximum(self._innovation, self._floor)
        misfit = np.log(noise) + self._innovation / noise + self._log_gain[:, None]
        weights = np.exp(-0.5 * self._count * (misfit - misfit.min(axis=0)))
        self._weight = weights / weights.sum(axis=0)


def _transition(step_s: float) -> tuple[Vector, Vector]:
    """Taylor's step (4, 4) and the covariance (4, 4) that a unit of white noise adds in it."""
    powers = [step_s**k for k in range(2 * ORDER)]
    F = np.zeros((ORDER, ORDER))
    Q = np.zeros((ORDER, ORDER))
    for i in range(ORDER):
        for j in range(ORDER):
            if j >= i:
                F[i, j] = powers[j - i] * TAYLOR[i][j]
            Q[i, j] = powers[2 * ORDER - 1 - i - j] * NOISE[i][j]
    return F, Q


TAYLOR = [[1.0 / math.factorial(abs(j - i)) for j in range(ORDER)] for i in range(ORDER)]
NOISE = [
    [
        1.0
        / (math.factorial(ORDER - 1 - i) * math.factorial(ORDER - 1 - j) * (2 * ORDER - 1 - i - j))
        for j in range(ORDER)
    ]
    for i in range(ORDER)
]
