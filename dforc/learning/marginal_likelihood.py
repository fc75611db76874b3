"""Hyperparameters of a Gaussian kernel by the marginal likelihood of a Gaussian process.

Several outputs may share one kernel: their log likelihoods are added up. The likelihood has local
optima, one of which calls everything noise; what is found depends on where the search begins, here
at unit signal, length scales of the inputs' spread times the square root of their number, and two
levels of noise. The better end counts.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, lapack
from scipy.optimize import minimize

from dforc.arrays import Matrix, Vector, constant
from dforc.errors import NotFiniteError, ShapeError
from dforc.learning.kernel_ridge import gaussian_kernel

NOISE_STARTS = (0.1, 0.5)  # of the signal
BOUND = 9.0  # of the logarithms: a factor of 8000 either way
SHORTEST = 0.02  # length scale, of the inputs' spread


@dataclass(frozen=True, slots=True, eq=False)
class Hyperparameters:
    """k(x, z) = signal^2 exp(-1/2 sum ((x_i - z_i) / l_i)^2), and noise^2 on top."""

    length_scales: Vector  # one per input, in the input's unit
    signal: float  # standard deviation, in the outputs' unit
    noise: float  # standard deviation, in the outputs' unit
    log_likelihood: float  # summed over the outputs

    @property
    def regularisation(self) -> float:
        """Ridge parameter for a kernel of unit signal."""
        return (self.noise / self.signal) ** 2


def fit_hyperparameters(
    x: Matrix, y: Matrix, length_scales: Vector | None = None, most_steps: int = 200
) -> Hyperparameters:
    """Maximise the likelihood of rows x (k, inputs), y (k, outputs) of zero mean, O(k^3) a step.

    Args:
        x: inputs, in any units; the scale of one that never varies is found in its unit.
        y: outputs, which share the kernel.
        length_scales: kept where given; then only signal and noise are sought.
        most_steps: of each search.

    Raises:
        NotFiniteError: NaN or infinity among them.
    """
    y = y[:, None] if y.ndim == 1 else y
    if x.ndim != 2 or len(x) != len(y) or len(x) < 2:
        raise ShapeError(f"data of shapes {x.shape} and {y.shape}")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise NotFiniteError("the data are not finite")
    spread = x.std(0)
    unit = np.where(spread > 0, spread, 1.0) if length_scales is None else length_scales
    scaled = (x - x.mean(0)) / unit  # far from zero, differences would drown in rounding
    level = max(float(np.sqrt((y * y).mean())), 1e-12)
    inputs = x.shape[1]
    bounds = [(np.log(SHORTEST), BOUND)] * inputs + [(-BOUND, BOUND)] * 2
    start = np.zeros(inputs + 2)
    if length_scales is None:
        start[:-2] = 0.5 * np.log(inputs)
    else:
        bounds[:-2] = [(0.0, 0.0)] * inputs
    ends = []
    for noise in NOISE_STARTS:
        start[-1] = np.log(noise)
        end = minimize(
            negative_log_likelihood,
            start,
            args=(scaled, y / level),
            jac=True,
            method="L-BFGS-B",
            bounds=bounds,
            options={"maxiter": most_steps},
        )
        ends.append((float(end.fun), np.exp(end.x)))
    cost, found = min(ends, key=lambda end: end[0])
    return Hyperparameters(
        constant(found[:-2] * unit),
        float(found[-2]) * level,
        float(found[-1]) * level,
        -cost - y.size * float(np.log(level)),
    )


def negative_log_likelihood(logs: Vector, x: Matrix, y: Matrix) -> tuple[float, Vector]:
    """Value and gradient with respect to the logarithms of length scales, signal and noise."""
    count, outputs = y.shape
    lengths = np.exp(logs[:-2])
    signal_squared, noise_squared = np.exp(2 * logs[-2]), np.exp(2 * logs[-1])
    K = signal_squared * gaussian_kernel(x, x, lengths)
    noisy = K + (noise_squared + 1e-10 * signal_squared) * np.eye(count)
    factor = cho_factor(noisy, lower=True)
    alpha = cho_solve(factor, y)
    value = 0.5 * float((y * alpha).sum()) + outputs * (
        float(np.log(np.diag(factor[0])).sum()) + 0.5 * count * np.log(2 * np.pi)
    )
    # dL/dtheta = 1/2 tr((outputs K^-1 - alpha alpha') dK/dtheta)
    lower, _ = lapack.dpotri(np.asfortranarray(factor[0]), lower=1)
    inverse = np.tril(lower) + np.tril(lower, -1).T
    M = outputs * inverse - alpha @ alpha.T
    MK = M * K
    gradient = np.empty_like(logs)
    # sum_ij MK_ij (x_i - x_j)^2 for every input at once
    totals = MK.sum(1)
    squares = 2.0 * (totals @ (x * x)) - 2.0 * ((MK @ x) * x).sum(0)
    gradient[:-2] = 0.5 * squares / (lengths * lengths)
    gradient[-2] = float(MK.sum()) + 1e-10 * signal_squared * float(np.trace(M))
    gradient[-1] = noise_squared * float(np.trace(M))
    return value, gradient
