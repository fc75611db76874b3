"""Velocity and acceleration from 12-bit encoders at 100 Hz: errors, rest noise, cost.

Errors are those against the truth at the same instant, so lag counts in full; relative to the root
mean square of the truth. Every row pools 8 phases, each with its own place between two counts.
"""

from collections.abc import Callable, Sequence
from functools import partial
from statistics import median

import numpy as np

from benchmarks.derivative_peers import (
    PERIOD_S,
    REPRODUCED,
    STRENGTHS,
    AdaptiveWindow,
    NullJerkKalman,
    Peer,
)
from dforc.arrays import Matrix, Vector
from dforc.signals.delay_match import MatchedMotion
from dforc.signals.differentiation import QUANTUM_RAD, Differentiator
from services.core.clock import wall_ns
from services.experiments.rows import Row, at_most

PHASES = 8
AMPLITUDES_DEG = (5.0, 10.0, 20.0)
FREQUENCIES_HZ = (0.2, 0.5, 1.0, 2.0)
SETTLE_S = 2.5
BAR_VELOCITY, BAR_ACCELERATION = 0.15, 0.35  # at 1 Hz
REST_NOISE_COUNTS = (0.0, 0.1, 0.3, 0.5)
JOINTS = 32


class Ours:
    """The differentiator, called as the peers are."""

    def __init__(self, n: int) -> None:
        self._filter = Differentiator(n)
        self._ticks = 0

    def add(self, q_rad: Vector) -> tuple[Vector, Vector]:
        """Velocity and acceleration (n,) at this sample."""
        self._ticks += 1
        motion = self._filter.add(q_rad, self._ticks * PERIOD_S)
        return motion.dq_rad_s, motion.ddq_rad_s2


PEERS: dict[str, Callable[[int], Peer]] = {
    "ours": Ours,
    "adaptive window": AdaptiveWindow,
    "null-jerk Kalman": lambda n: NullJerkKalman(n, REPRODUCED),
}


def counted(q_rad: Matrix) -> Matrix:
    """What the encoder shows."""
    shown: Matrix = np.round(q_rad / QUANTUM_RAD) * QUANTUM_RAD
    return shown


def run(peer: Peer, q_rad: Matrix) -> Matrix:
    """Velocities and accelerations (ticks, 2, n)."""
    return np.array([peer.add(sample) for sample in counted(q_rad)])


def sine_errors(
    make: Callable[[int], Peer], frequency_hz: float, amplitude_deg: float
) -> tuple[float, float]:
    """Relative errors of velocity and acceleration."""
    t = np.arange(0.0, SETTLE_S + max(4.0, 2.0 / frequency_hz), PERIOD_S)
    w, amplitude = 2.0 * np.pi * frequency_hz, np.radians(amplitude_deg)
    phases = 2.0 * np.pi * np.arange(PHASES) / PHASES + 0.1
    angle = w * t[:, None] + phases
    places = QUANTUM_RAD * np.linspace(0.0, 7.3, PHASES)
    found = run(make(PHASES), amplitude * np.sin(angle) + places)
    true = amplitude * np.stack([w * np.cos(angle), -w * w * np.sin(angle)], axis=1)
    late = t > SETTLE_S
    errors = ((found - true)[late] ** 2).mean(axis=(0, 2)) / (true[late] ** 2).mean(axis=(0, 2))
    velocity, acceleration = np.sqrt(errors).tolist()
    return velocity, acceleration


def best_kalman(frequency_hz: float, amplitude_deg: float) -> tuple[float, float]:
    """Least errors over all strengths, velocity and acceleration apart: known only afterwards."""
    all_errors = [
        sine_errors(partial(NullJerkKalman, variances=strength), frequency_hz, amplitude_deg)
        for strength in STRENGTHS
    ]
    return min(v for v, _ in all_errors), min(a for _, a in all_errors)


def sine_rows(short: bool) -> list[Row]:
    """Ours, the peers, and the best Kalman filter that hindsight can find."""
    rows: list[Row] = []
    for frequency in (1.0,) if short else FREQUENCIES_HZ:
        for amplitude in AMPLITUDES_DEG:
            where = f"{frequency:g} Hz, {amplitude:g} deg"
            errors = {name: sine_errors(make, frequency, amplitude) for name, make in PEERS.items()}
            if not short:
                errors["null-jerk Kalman tuned by hindsight"] = best_kalman(frequency, amplitude)
            for index, what in enumerate(("velocity", "acceleration")):
                ours = errors["ours"][index]
                others = {name: pair[index] for name, pair in errors.items() if name != "ours"}
                bar = min(others.values())
                if frequency == 1.0:
                    bar = min(bar, (BAR_VELOCITY, BAR_ACCELERATION)[index])
                rows.append(at_most(f"{what} error, {where}", ours, "relative", bar))
                rows += [
                    Row(f"{what} error, {where}: {name}", error, "relative")
                    for name, error in others.items()
                ]
    return rows


def rest_noise(make: Callable[[int], Peer], noise_counts: float, seed: int) -> tuple[float, float]:
    """Root mean square of velocity and acceleration of joints at rest at any place of a count."""
    rng = np.random.default_rng(seed)
    joints, ticks = 24, 800
    shake = noise_counts * rng.normal(size=(ticks, joints))
    q = QUANTUM_RAD * (rng.uniform(0.0, 1.0, joints) + shake)
    found = run(make(joints), q)[int(SETTLE_S / PERIOD_S) :]
    velocity, acceleration = np.sqrt((found**2).mean(axis=(0, 2))).tolist()
    return velocity, acceleration


def rest_rows(short: bool) -> list[Row]:
    """Noise at rest, not above the window's."""
    rows: list[Row] = []
    for noise in (0.3,) if short else REST_NOISE_COUNTS:
        found = {name: rest_noise(make, noise, 5) for name, make in PEERS.items()}
        for index, (what, unit) in enumerate((("velocity", "rad/s"), ("acceleration", "rad/s2"))):
            name = f"{what} at rest, shaking by {noise:g} counts"
            rows.append(at_most(name, found["ours"][index], unit, found["adaptive window"][index]))
            rows += [
                Row(f"{name}: {peer}", pair[index], unit)
                for peer, pair in found.items()
                if peer != "ours"
            ]
    return rows


def move_rows() -> list[Row]:
    """A minimum-jerk move of 20 degrees in one second, from rest to rest: no sine at all."""
    t = np.arange(0.0, 5.0, PERIOD_S)
    s, amplitude = np.clip(t - SETTLE_S, 0.0, 1.0)[:, None], np.radians(20.0)
    q = amplitude * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    velocity = amplitude * 30.0 * s * s * (1.0 - s) ** 2
    acceleration = amplitude * 60.0 * s * (1.0 - 3.0 * s + 2.0 * s * s)
    true = np.stack([velocity, acceleration], axis=1)
    places = QUANTUM_RAD * np.linspace(0.0, 7.3, PHASES)
    moving = (t > SETTLE_S) & (t < SETTLE_S + 1.2)
    rows: list[Row] = []
    found = {name: run(make(PHASES), q + places) for name, make in PEERS.items()}
    errors = {
        name: np.sqrt(
            ((f - true)[moving] ** 2).mean(axis=(0, 2)) / (true[moving] ** 2).mean((0, 2))
        )
        for name, f in found.items()
    }
    for index, what in enumerate(("velocity", "acceleration")):
        name = f"{what} error, minimum-jerk move of 20 deg in 1 s"
        others = {peer: float(e[index]) for peer, e in errors.items() if peer != "ours"}
        rows.append(at_most(name, float(errors["ours"][index]), "relative", min(others.values())))
        rows += [Row(f"{name}: {peer}", error, "relative") for peer, error in others.items()]
    return rows


def uneven_rows() -> list[Row]:
    """The 1 Hz sine at uneven instants: 125 and 250 Hz, each up to 40 % of a period late."""
    rows: list[Row] = []
    rng = np.random.default_rng(3)
    for rate in (125.0, 250.0):
        t = (np.arange(int(7.0 * rate)) + 0.4 * rng.uniform(size=int(7.0 * rate))) / rate
        w, amplitude = 2.0 * np.pi, np.radians(10.0)
        angle = w * t[:, None] + np.arange(PHASES)
        q, ours = counted(amplitude * np.sin(angle)), Differentiator(PHASES)
        found = np.array(
            [ours.add(sample, at)[1:] for sample, at in zip(q, t.tolist(), strict=True)]
        )
        true = amplitude * np.stack([w * np.cos(angle), -w * w * np.sin(angle)], axis=1)
        late = t > SETTLE_S
        error = np.sqrt(((found - true)[late] ** 2).mean((0, 2)) / (true[late] ** 2).mean((0, 2)))
        where = f"1 Hz, 10 deg, uneven {rate:g} Hz"
        rows.append(at_most(f"velocity error, {where}", float(error[0]), "relative", BAR_VELOCITY))
        rows.append(
            at_most(f"acceleration error, {where}", float(error[1]), "relative", BAR_ACCELERATION)
        )
    return rows


def jump_rows() -> list[Row]:
    """Largest acceleration error 0.3 s after an encoder jumped in a swing, and the spike itself."""
    rows: list[Row] = []
    t = np.arange(0.0, 5.0, PERIOD_S)
    w, amplitude = np.pi, np.radians(10.0)
    true = -amplitude * w * w * np.sin(w * t)
    for jump_deg in (1.0, 3.0, 20.0, 90.0):
        q = amplitude * np.sin(w * t) + np.where(t >= 3.0, np.radians(jump_deg), 0.0)
        found = run(Ours(1), q[:, None])[:, 1, 0]
        error_deg = np.degrees(np.abs(found - true))
        name = f"acceleration error after a jump of {jump_deg:g} deg"
        rows.append(Row(f"{name}: at once", float(error_deg[t >= 2.95].max()), "deg/s2"))
        rows.append(
            at_most(f"{name}: 0.3 s later", float(error_deg[t >= 3.3].max()), "deg/s2", 150)
        )
    return rows


def costs_us(calls: Sequence[Callable[[int], object]], rounds: int) -> list[list[float]]:
    """Each call's durations, interleaved."""
    durations: list[list[float]] = [[] for _ in calls]
    for tick in range(rounds):
        for call, into in zip(calls, durations, strict=True):
            start = wall_ns()
            call(tick)
            into.append((wall_ns() - start) / 1e3)
    return durations


def cost_rows(short: bool) -> list[Row]:
    """Microseconds per tick for 32 joints, first and last third of the run."""
    ours, matched = Differentiator(JOINTS), MatchedMotion(JOINTS)
    q = counted(np.radians(20.0) * np.sin(np.arange(1000)[:, None] * 0.03 + np.arange(JOINTS)))

    def filter_matched(tick: int) -> None:
        matched.push(q[tick % 1000], tick * 0.01)
        matched.motion(tick * 0.01)

    rounds = 900 if short else 9000
    empty, live, late = costs_us(
        [lambda _: None, lambda tick: ours.add(q[tick % 1000], tick * 0.01), filter_matched], rounds
    )
    third = rounds // 3
    return [
        Row("empty call", median(empty), "us"),
        at_most("differentiator, 32 joints, one tick", median(live[third:]), "us", 200),
        Row("differentiator, last third over first", median(live[-third:]) / median(live[:third])),
        at_most("matched motion, 32 joints, one tick", median(late[third:]), "us", 200),
    ]
