"""A force/torque sensor's 6x6 gain and its offset, from readings in many postures of the robot.

Wanted are C and o with  C m - o = p  for readings m and the model's predictions p of a limb that
nothing touches. Least squares, every channel divided by its noise. The readings' own noise, which
would draw the gain towards zero, is taken out of their covariance. And because a limb's own weight
excites six directions very unequally, the gain is drawn towards the identity:

    minimise  sum |C m_k - o - p_k|^2 + K ridge^2 |C - 1|^2     (channels in units of their noise)

In a direction of the readings whose spread over the sweep is s noises, the data count s^2 and the
identity ridge^2: below s = ridge the sensor's maker is believed, far above it the sweep. Each
direction is reported with that share, so what the sweep could not see is not silently invented; a
spread that noise alone could show counts as none.

The model's error goes into the result as it is: a link that is 3 % too heavy in the model makes the
gain 3 % too large. `residual` shows how much of the sweep model and gain together do not explain.

Wrenches are (6,): force [N], then moment [Nm], sensor frame.
"""

import math
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector, constant, finite_vector
from dforc.errors import DforcError, ShapeError

NOISE = (0.05, 0.05, 0.05, 0.002, 0.002, 0.002)  # of a strain board's sample
RIDGE = 0.5  # iCub's arm, swept alone, spreads 6 noises in its weakest direction, its leg 50
FEWEST_SAMPLES = 50
CHANCE = 3.0  # half again of what noise alone shows
UNSEEN_SHARE = 0.9  # less than this from the data: the direction was not observed


class TooFewPosesError(DforcError, ValueError):
    """Not enough samples for 42 numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class GainFit:
    """What a pose sweep says of a sensor. Use it as FtChannel.set_matrix and set_offset."""

    matrix: Matrix  # C (6, 6)
    offset: Vector  # o (6,)
    residual: Vector  # (6,) root mean square of C m - o - p
    residual_before: Vector  # the same with the identity and the best offset for it
    spread: Vector  # (6,) of the readings along `directions`, in noises, falling
    directions: Matrix  # (6, 6): rows are unit vectors of readings in units of their noise
    share: Vector  # (6,) how much of the gain along each direction the data decided, 0 to 1

    @property
    def rank(self) -> int:
        """Directions that the data decided."""
        return int(np.count_nonzero(self.share >= UNSEEN_SHARE))

    @property
    def condition(self) -> float:
        """Largest over smallest spread; infinite where a direction was not excited at all."""
        weakest = float(self.spread[-1])
        return float(self.spread[0]) / weakest if weakest > 0.0 else math.inf

    @property
    def unobserved(self) -> Matrix:
        """(6 - rank, 6): directions in which the gain is the identity's for want of data."""
        unseen: Matrix = self.directions[self.share < UNSEEN_SHARE]
        return unseen


def identify_gain(
    measured: Matrix,
    predicted: Matrix,
    *,
    noise: tuple[float, ...] = NOISE,
    ridge: float = RIDGE,
) -> GainFit:
    """Gain and offset from a sweep.

    Args:
        measured: readings (k, 6) before matrix and offset, no contact.
        predicted: the model's wrenches for the same instants (k, 6).
        noise: standard deviation of a reading per channel.
        ridge: weight of the identity, as a spread in noises, positive.

    Raises:
        NotFiniteError: NaN or infinity among them.
        ShapeError: not (k, 6) twice.
        TooFewPosesError: fewer than 50 samples.
    """
    if measured.shape != predicted.shape or measured.ndim != 2 or measured.shape[1] != 6:
        raise ShapeError(f"{measured.shape} readings and {predicted.shape} predictions")
    count = len(measured)
    if count < FEWEST_SAMPLES:
        raise TooFewPosesError(f"{count} samples; at least {FEWEST_SAMPLES} are needed")
    m = finite_vector("readings", measured.ravel(), 6 * count).reshape(count, 6)
    p = finite_vector("predictions", predicted.ravel(), 6 * count).reshape(count, 6)
    scale = np.array(noise)
    m_mean, p_mean = m.mean(axis=0), p.mean(axis=0)
    M, P = (m - m_mean) / scale, (p - p_mean) / scale
    variance, V = np.linalg.eigh(M.T @ M / count)
    variance, V = variance[::-1], V[:, ::-1]
    # Noise alone has variance 1, and its largest of six about 1 + 2 sqrt(6 / K).
    by_chance = variance <= 1.0 + CHANCE * np.sqrt(6.0 / count)
    variance = np.where(by_chance, 0.0, variance - 1.0)
    weight = variance + ridge * ridge
    # Along each direction: least squares where it was seen, the identity where it was not.
    wanted = ((P - M).T @ M / count + np.eye(6)) @ V
    correction = np.where(variance > 0.0, wanted / weight, 0.0) @ V.T
    matrix = np.eye(6) + scale[:, None] * correction / scale[None, :]
    offset = matrix @ m_mean - p_mean
    return GainFit(
        matrix=constant(matrix),
        offset=constant(offset),
        residual=_root_mean_square(m @ matrix.T - offset - p),
        residual_before=_root_mean_square((M - P) * scale),
        spread=constant(np.sqrt(variance)),
        directions=constant(V.T),
        share=constant(variance / weight),
    )


def _root_mean_square(errors: Matrix) -> Vector:
    root: Vector = np.sqrt(np.mean(errors * errors, axis=0))
    return root
