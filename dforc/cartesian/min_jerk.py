"""Minimum-jerk feedback: the velocity that brings a quantity to its target along a smooth profile.

Two laws.

Time to go: from the error e, its velocity and its acceleration (all against the target) run the
quintic that ends at rest on the target after `time_to_go`; recomputed every period with the time
that is left, it is minimum jerk exactly and absorbs whatever disturbs it. With the time to go held
at a floor it is a third-order feedback law that follows a moving target: constant velocity without
lag, constant acceleration a with 0.15 time_to_go^2 a.

Third-order lag, the law of the iCub's own controller (F(s) below): fixed gains, critically damped
once the loop is closed over an integrator. It reaches 90 % at T and 98 % at 1.41 T, and trails a
target that moves with v by 0.564 T v; the project's controller uses the time to go, and this law
is the reference it is compared with.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector

# iKin, minJerkCtrl: F(s) = GAIN/T^3 / (s^2 + DAMPING/T s + SQUARE/T^2), a triple pole at -5.3223/T
LAG_GAIN = 150.765868956161
LAG_DAMPING = 15.9669610709384
LAG_SQUARE = 84.9812819469538


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Error of a quantity against its target (k,), with its first and second time derivatives."""

    error: Vector
    velocity: Vector
    acceleration: Vector


def advance(motion: Motion, time_to_go_s: float, period_s: float) -> Motion:
    """The motion one period later on the quintic that ends at zero, at rest, after time_to_go_s."""
    if time_to_go_s <= period_s:
        zero = np.zeros_like(motion.error)
        return Motion(zero, zero, zero)
    step = quintic_step(time_to_go_s, period_s)
    error, velocity, acceleration = step @ np.array(
        [motion.error, motion.velocity, motion.acceleration]
    )
    return Motion(error, velocity, acceleration)


def quintic_step(time_to_go_s: float, period_s: float) -> Matrix:
    """Matrix (3, 3) from (error, velocity, acceleration) now to those one period later.

    The quintic is e + v t + a t^2/2 + c3 s^3 + c4 s^4 + c5 s^5 with s = t / T and
    c3 = -10 e - 6 vT - 1.5 aT^2, c4 = 15 e + 8 vT + 1.5 aT^2, c5 = -6 e - 3 vT - 0.5 aT^2.
    """
    T, t = time_to_go_s, period_s
    s = t / T
    s2 = s * s
    s3, s4 = s2 * s, s2 * s2
    s5 = s4 * s
    p_e, p_v, p_a = _weighted(s3, s4, s5)
    v_e, v_v, v_a = _weighted(3.0 * s2, 4.0 * s3, 5.0 * s4)
    a_e, a_v, a_a = _weighted(6.0 * s, 12.0 * s2, 20.0 * s3)
    return np.array(
        [
            [1.0 + p_e, t + T * p_v, 0.5 * t * t + T * T * p_a],
            [v_e / T, 1.0 + v_v, t + T * v_a],
            [a_e / (T * T), a_v / T, 1.0 + a_a],
        ]
    )


def _weighted(w3: float, w4: float, w5: float) -> tuple[float, float, float]:
    """Shares of e, vT and aT^2 in w3 c3 + w4 c4 + w5 c5."""
    return (
        -10.0 * w3 + 15.0 * w4 - 6.0 * w5,
        -6.0 * w3 + 8.0 * w4 - 3.0 * w5,
        -1.5 * w3 + 1.5 * w4 - 0.5 * w5,
    )


@dataclass(frozen=True, slots=True, eq=False)
class LagState:
    """Filter states of the third-order lag law: its output velocity and the integral behind it."""

    velocity: Vector
    acceleration: Vector
    error: Vector  # of the period before

    @classmethod
    def at_rest(cls, size: int) -> "LagState":
        """A filter that has seen nothing."""
        return cls(np.zeros(size), np.zeros(size), np.zeros(size))


def lag_step(
    state: LagState, error: Vector, trajectory_time_s: float, period_s: float
) -> tuple[LagState, Vector]:
    """Velocity F(s) (target - value) of the third-order lag law, by Tustin's rule.

    Args:
        state: filter states.
        error: target minus value (k,).
        trajectory_time_s: T.
        period_s: sampling time.
    """
    T, h = trajectory_time_s, period_s
    gain, damping, square = LAG_GAIN / T**3, LAG_DAMPING / T, LAG_SQUARE / T**2
    # v' = a, a' = gain e - damping a - square v; both integrated by the trapezoidal rule
    v, a = state.velocity, state.acceleration
    drive = gain * (state.error + error) - damping * a - 2.0 * square * v - 0.5 * h * square * a
    a_new = (a + 0.5 * h * drive) / (1.0 + 0.5 * h * damping + 0.25 * h * h * square)
    v_new = v + 0.5 * h * (a + a_new)
    return LagState(v_new, a_new, error), v_new
