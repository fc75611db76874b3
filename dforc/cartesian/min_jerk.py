"""Minimum-jerk feedback: the velocity that brings a quantity to its target along a smooth profile.

Three laws.

Time to go: from the error e, its velocity and its acceleration (all against the target) run the
quintic that ends at rest on the target after `time_to_go`; recomputed every period with the time
that is left, it is minimum jerk exactly and absorbs whatever disturbs it. With the time to go held
at a floor it is a third-order feedback law that follows a moving target: constant velocity without
lag, constant acceleration a with 0.15 time_to_go^2 a.

Change of speed: the cubic that ends at a given velocity without acceleration after `time_to_go`,
minimum jerk where the way does not matter. With velocity zero it is a stop.

Third-order lag, the law of the iCub's own controller (F(s) below): fixed gains, critically damped
once the loop is closed over an integrator. It reaches 90 % at T and 98 % at 1.41 T, and trails a
target that moves with v by 0.564 T v; the project's controller uses the time to go, and this law
is the reference it is compared with.
"""

from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.compiled import compiled

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
    error, velocity, acceleration = (
        np.array(part) for part in (motion.error, motion.velocity, motion.acceleration)
    )
    run_quintic(error, velocity, acceleration, time_to_go_s, period_s)
    return Motion(error, velocity, acceleration)


@compiled
def run_quintic(
    error: Vector, velocity: Vector, acceleration: Vector, time_to_go_s: float, period_s: float
) -> None:
    """`advance` in place.

    The quintic is e + v t + a t^2/2 + c3 s^3 + c4 s^4 + c5 s^5 with s = t / T and
    c3 = -10 e - 6 vT - 1.5 aT^2, c4 = 15 e + 8 vT + 1.5 aT^2, c5 = -6 e - 3 vT - 0.5 aT^2.
    """
    T, t = time_to_go_s, period_s
    s = t / T
    for i in range(len(error)):
        if t >= T:
            error[i] = velocity[i] = acceleration[i] = 0.0
            continue
        e, v, a = error[i], T * velocity[i], T * T * acceleration[i]
        c3 = -10.0 * e - 6.0 * v - 1.5 * a
        c4 = 15.0 * e + 8.0 * v + 1.5 * a
        c5 = -6.0 * e - 3.0 * v - 0.5 * a
        error[i] = e + s * (v + s * (0.5 * a + s * (c3 + s * (c4 + s * c5))))
        velocity[i] = (v + s * (a + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / T
        acceleration[i] = (a + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / (T * T)


@compiled
def run_cubic(
    way: Vector,
    velocity: Vector,
    acceleration: Vector,
    wanted: Vector,
    time_to_go_s: float,
    period_s: float,
) -> None:
    """One period of the change of speed to `wanted`, in place; `way` becomes what it covers."""
    T = time_to_go_s
    for i in range(len(way)):
        t = min(T, period_s)
        s = t / T
        v, a, w = velocity[i], T * acceleration[i], wanted[i]
        c2 = 3.0 * (w - v) - 2.0 * a
        c3 = 2.0 * (v - w) + a
        covered = t * (v + s * (0.5 * a + s * (c2 / 3.0 + s * 0.25 * c3)))
        way[i] = covered + (period_s - t) * w
        if period_s >= T:
            velocity[i], acceleration[i] = w, 0.0
        else:
            velocity[i] = v + s * (a + s * (c2 + s * c3))
            acceleration[i] = (a + s * (2.0 * c2 + s * 3.0 * c3)) / T


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
    velocity, acceleration, before = state.velocity.copy(), state.acceleration.copy(), state.error
    run_lag(velocity, acceleration, before, error, trajectory_time_s, period_s)
    return LagState(velocity, acceleration, error), velocity


@compiled
def run_lag(
    velocity: Vector,
    acceleration: Vector,
    error_before: Vector,
    error: Vector,
    trajectory_time_s: float,
    period_s: float,
) -> None:
    """`lag_step` in place."""
    T, h = trajectory_time_s, period_s
    gain, damping, square = LAG_GAIN / T**3, LAG_DAMPING / T, LAG_SQUARE / T**2
    scale = 1.0 / (1.0 + 0.5 * h * damping + 0.25 * h * h * square)
    # v' = a, a' = gain e - damping a - square v; both integrated by the trapezoidal rule
    for i in range(len(velocity)):
        v, a = velocity[i], acceleration[i]
        drive = gain * (error_before[i] + error[i]) - damping * a - 2.0 * square * v
        drive -= 0.5 * h * square * a
        acceleration[i] = (a + 0.5 * h * drive) * scale
        velocity[i] = v + 0.5 * h * (a + acceleration[i])
