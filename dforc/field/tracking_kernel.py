"""Kalman filter of one moving object that finds out by itself how restless it is, for numba.

Constant velocity with white acceleration of density q [m^2/s^3]. Innovations that keep a direction
mean that q is too small, white ones that it is too large: q follows them between two bounds, so a
steady object is averaged over a second and one that is pushed is followed at once. An object that
has been steady and slow for a while is at rest: its velocity is measured as zero until it moves.
"""

import math
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled

# Places in `numbers`.
TIME, SAMPLES, REJECTED, RESTLESSNESS, STILL, DRIFT_TIME, LOWEST = 0, 1, 2, 3, 4, 5, 6
SEEN_TIME, SEEN = 7, 8  # the newest sample, be it taken or skipped, and its place
NUMBERS = 11

TAKEN, SKIPPED, RESTARTED, IGNORED = 0, 1, 2, 3  # what became of a sample

FIRST_SPEED_M_S = 0.3  # sigma of an unknown velocity, each axis
ODD_SPEED_M_S = 1.5  # the same of an object that has just gone where nobody expected it
LOWEST_Q, HIGHEST_Q = 1e-5, 0.1  # m^2/s^3
FIRST_Q = 3e-4
RISE_PER_S, FALL_PER_S = 6.0, 4.0  # of log q, per unit of evidence
DRIFT_S = 0.15  # over which innovations are averaged
EXPECTED = 1.3  # evidence above which q rises; 1 is white
MOST_EVIDENCE = 5.0
GATE = 25.0  # squared Mahalanobis distance: one white innovation in 60 000 is farther
PATIENCE = 3  # samples beyond the gate that are one jump
LONGEST_GAP_S = 1.0  # after which an object is a new one
REST_SPEED_M_S = 0.012
REST_AFTER_S = 0.3
REST_DENSITY = 2e-6  # (m/s)^2 s of the velocity that is measured as zero
MOVES_EVIDENCE = 5.0  # that an object at rest has begun to move


class Track(NamedTuple):
    """What is known of one object."""

    numbers: Vector  # (NUMBERS,)
    state: Vector  # (6,) position [m], velocity [m/s]
    P: Matrix  # (6, 6)
    drift: Vector  # (3,) mean innovation [m]


@compiled
def restart(track: Track, time: float, z: Vector, R: Matrix, speed: float) -> None:
    """Know no more than one sample, and that the object is about as fast as that, or at rest."""
    numbers = track.numbers
    numbers[TIME], numbers[SAMPLES], numbers[REJECTED] = time, 1.0, 0.0
    numbers[RESTLESSNESS] = max(FIRST_Q, numbers[LOWEST])
    numbers[STILL], numbers[DRIFT_TIME] = 0.0, 0.0
    track.P[:] = 0.0
    track.drift[:] = 0.0
    for i in range(3):
        track.state[i], track.state[3 + i] = z[i], 0.0
        for j in range(3):
            track.P[i, j] = R[i, j]
        track.P[3 + i, 3 + i] = speed**2


@compiled
def predict(state: Vector, P: Matrix, q: float, dt: float) -> None:
    """Let time pass."""
    for i in range(3):
        state[i] += dt * state[3 + i]
    for i in range(3):
        for j in range(3):
            P[i, j] += dt * (P[i, 3 + j] + P[3 + i, j]) + dt * dt * P[3 + i, 3 + j]
    for i in range(3):
        for j in range(3):
            P[i, 3 + j] += dt * P[3 + i, 3 + j]
            P[3 + j, i] = P[i, 3 + j]
        P[i, i] += q * dt**3 / 3.0
        P[i, 3 + i] += 0.5 * q * dt * dt
        P[3 + i, i] = P[i, 3 + i]
        P[3 + i, 3 + i] += q * dt


@compiled
def inverse(S: Matrix, out: Matrix) -> None:
    """Inverse of a symmetric positive definite (3, 3)."""
    a, b, c, d, e, f = S[0, 0], S[0, 1], S[0, 2], S[1, 1], S[1, 2], S[2, 2]
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * A + b * B + c * C
    out[0, 0], out[0, 1], out[0, 2] = A / determinant, B / determinant, C / determinant
    out[1, 0], out[1, 1] = out[0, 1], (a * f - c * c) / determinant
    out[1, 2] = (b * c - a * e) / determinant
    out[2, 0], out[2, 1] = out[0, 2], out[1, 2]
    out[2, 2] = (a * d - b * b) / determinant


@compiled
def square_in(y: Vector, W: Matrix) -> float:
    """Compute y' W y."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += y[i] * W[i, j] * y[j]
    return total


@compiled
def correct(state: Vector, P: Matrix, first: int, y: Vector, W: Matrix) -> None:
    """Take in the innovation y of the three states from `first`; W inverts its covariance."""
    K = np.empty((6, 3))
    for i in range(6):
        for j in range(3):
            K[i, j] = 0.0
            for k in range(3):
                K[i, j] += P[i, first + k] * W[k, j]
        state[i] += K[i, 0] * y[0] + K[i, 1] * y[1] + K[i, 2] * y[2]
    rows = P[first : first + 3].copy()
    for i in range(6):
        for j in range(i + 1):
            gain = 0.0
            for k in range(3):
                gain += K[i, k] * rows[k, j]
            P[i, j] -= gain
            P[j, i] = P[i, j]


@compiled
def evidence(track: Track, y: Vector, W: Matrix, dt: float) -> float:
    """How far the innovations are from white: 1 on average if they are, more if they drift."""
    numbers = track.numbers
    share = 1.0 - math.exp(-dt / DRIFT_S)
    for k in range(3):
        track.drift[k] += share * (y[k] - track.drift[k])
    # Variance of the mean of white ones, as a share of one's: it begins at 0.
    keep = (1.0 - share) ** 2
    numbers[DRIFT_TIME] = keep * numbers[DRIFT_TIME] + share * share
    return float(square_in(track.drift, W) / (3.0 * numbers[DRIFT_TIME]))


@compiled
def adapt(track: Track, amount: float, dt: float) -> None:
    """Follow the evidence with q, and count how long the object has been still."""
    numbers = track.numbers
    above = min(amount, MOST_EVIDENCE) - EXPECTED
    rate = RISE_PER_S if above > 0.0 else FALL_PER_S
    q = numbers[RESTLESSNESS] * math.exp(rate * above * dt)
    numbers[RESTLESSNESS] = max(min(q, HIGHEST_Q), numbers[LOWEST])
    v = track.state[3:]
    speed = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    at_rest = numbers[STILL] >= REST_AFTER_S
    spread = math.sqrt(max(track.P[3, 3], max(track.P[4, 4], track.P[5, 5])))
    is_slow = speed < REST_SPEED_M_S and (at_rest or spread < REST_SPEED_M_S)
    if is_slow and amount < MOVES_EVIDENCE:
        numbers[STILL] += dt
    else:
        numbers[STILL] = 0.0


@compiled
def take_velocity(track: Track, v: Vector, variance: float) -> None:
    """Take in a velocity, be it that an object at rest has none."""
    S, W, y = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for i in range(3):
        y[i] = v[i] - track.state[3 + i]
        for j in range(3):
            S[i, j] = track.P[3 + i, 3 + j]
        S[i, i] += variance
    inverse(S, W)
    correct(track.state, track.P, 3, y, W)


@compiled
def begin_moving(track: Track, time: float, z: Vector, R: Matrix) -> None:
    """Restart with the last two samples, so that an object which is fast is not taken for still."""
    numbers = track.numbers
    place, dt = numbers[SEEN : SEEN + 3].copy(), time - numbers[SEEN_TIME]
    if not 0.0 < dt <= LONGEST_GAP_S:
        restart(track, time, z, R, FIRST_SPEED_M_S)
        return
    restart(track, time, place, R, ODD_SPEED_M_S)
    predict(track.state, track.P, numbers[RESTLESSNESS], dt)
    S, W, y = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    innovation(track, z, R, y, S, W)
    if square_in(y, W) > GATE:
        restart(track, time, z, R, FIRST_SPEED_M_S)
        return
    correct(track.state, track.P, 0, y, W)


@compiled
def innovation(track: Track, z: Vector, R: Matrix, y: Vector, S: Matrix, W: Matrix) -> None:
    """Fill y = z - x, its covariance S and that one's inverse W."""
    for i in range(3):
        y[i] = z[i] - track.state[i]
        for j in range(3):
            S[i, j] = track.P[i, j] + R[i, j]
    inverse(S, W)


@compiled
def take(track: Track, time: float, z: Vector, R: Matrix) -> int:
    """Take in a position measured at a time [s]; TAKEN, SKIPPED, RESTARTED or IGNORED."""
    numbers = track.numbers
    dt = time - numbers[TIME]
    if numbers[SAMPLES] > 0.0 and dt <= 0.0:
        return IGNORED
    taken = _taken(track, time, dt, z, R)
    numbers[SEEN_TIME] = time
    numbers[SEEN : SEEN + 3] = z
    return taken


@compiled
def _taken(track: Track, time: float, dt: float, z: Vector, R: Matrix) -> int:
    numbers = track.numbers
    if numbers[SAMPLES] == 0.0 or dt > LONGEST_GAP_S:
        restart(track, time, z, R, FIRST_SPEED_M_S)
        return RESTARTED
    predict(track.state, track.P, numbers[RESTLESSNESS], dt)
    numbers[TIME] = time
    S, W, y = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    innovation(track, z, R, y, S, W)
    if square_in(y, W) > GATE:
        numbers[REJECTED] += 1.0
        if numbers[REJECTED] < PATIENCE:
            return SKIPPED
        begin_moving(track, time, z, R)
        return RESTARTED
    numbers[REJECTED] = 0.0
    numbers[SAMPLES] += 1.0
    correct(track.state, track.P, 0, y, W)
    adapt(track, evidence(track, y, W, dt), dt)
    if numbers[STILL] >= REST_AFTER_S:
        take_velocity(track, np.zeros(3), REST_DENSITY / dt)
    return TAKEN
