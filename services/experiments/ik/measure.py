"""Contenders on the same targets in one process, turn by turn, and what their answers are worth.

The time of an answer is the best of three identical solves; percentiles go over the targets.
"""

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from services.core.clock import thread_cpu_ns, wall_ns
from services.experiments.ik.arm import TOLERANCE_M, Arm, Array
from services.experiments.ik.contenders import Answer, Contender
from services.experiments.ik.paths import Path
from services.experiments.ik.sets import Targets

REPEATS = 3
KEPT_RAD = 1e-6  # by which a limit or a row may be missed
LOOSE_M, LOOSE_RAD = 1.1e-3, 1e-5  # what stock solvers call reached and kept
ROUNDING = 1.001  # of 1 mm: the position is a condition, and is met to a thousandth of it
OPTIMAL_SHARE, OPTIMAL = 0.01, 1e-3

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Run:
    """Answers of one contender, one per target; NaN where it had none."""

    q: Array  # (k, n)
    ms: Array  # (k,)
    said: Array  # (k,): 1 reached, 0 not, NaN not said

    def ms_at(self, percent: float) -> float:
        """A percentile of the times."""
        return float(np.percentile(self.ms, percent))


def search(
    contenders: Sequence[Contender], targets: Targets, starts: Array, repeats: int = REPEATS
) -> dict[str, Run]:
    """Everybody from the same starts (k, n), target by target."""
    found: dict[str, list[tuple[Answer, float]]] = {c.name: [] for c in contenders}
    warm(contenders, targets, starts)
    with _uncollected():
        for p, R, q0 in zip(targets.position, targets.rotation, starts, strict=True):
            for c in contenders:
                found[c.name].append(_best(c.solve, (p, R, q0), c.by_wall, repeats))
    return {name: _run(answers, starts.shape[1]) for name, answers in found.items()}


def follow(
    contenders: Sequence[Contender], path: Path, repeats: int = REPEATS, start: Array | None = None
) -> dict[str, Run]:
    """Everybody along the same path, each from its own last answer, tick by tick."""
    first = path.start if start is None else start
    found: dict[str, list[tuple[Answer, float]]] = {c.name: [] for c in contenders}
    at = {c.name: first for c in contenders}
    for c in contenders:
        c.track(path.position[0], path.rotation[0], first)
    with _uncollected():
        for p, R in zip(path.position, path.rotation, strict=True):
            for c in contenders:
                q = at[c.name]
                answer, ms = _best(c.track, (p, R, q), c.by_wall, repeats)
                if answer.q is not None:
                    at[c.name] = answer.q
                found[c.name].append((Answer(at[c.name], answer.reached), ms))
    return {name: _run(answers, len(first)) for name, answers in found.items()}


def warm(contenders: Sequence[Contender], targets: Targets, starts: Array) -> None:
    """Compile and load: the first answers are nobody's time."""
    for c in contenders:
        for i in range(min(3, len(targets))):
            c.solve(targets.position[i], targets.rotation[i], starts[i])


Call = Callable[[Array, Array, Array], Answer]


def _best(
    call: Call, given: tuple[Array, Array, Array], by_wall: bool, repeats: int
) -> tuple[Answer, float]:
    clock = wall_ns if by_wall else thread_cpu_ns
    best_ns = 1 << 62
    for _ in range(repeats):
        begin_ns = clock()
        answer = call(*given)
        best_ns = min(best_ns, clock() - begin_ns)
    return answer, best_ns / 1e6


@contextmanager
def _uncollected() -> Iterator[None]:
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _run(answers: list[tuple[Answer, float]], n: int) -> Run:
    q = np.array([np.full(n, np.nan) if a.q is None else a.q for a, _ in answers])
    said = np.array([np.nan if a.reached is None else float(a.reached) for a, _ in answers])
    return Run(q, np.array([ms for _, ms in answers]), said)


@dataclass(frozen=True, eq=False)
class Worth:
    """What answers are worth by the arm's own kinematics, one number per target."""

    distance_m: Array
    angle_rad: Array
    outside_rad: Array  # of the worst limit or row; negative inside
    objective: Array

    def feasible(self) -> Flags:
        """Within 1 mm, limits and rows kept to 1e-6."""
        near = self.distance_m <= ROUNDING * TOLERANCE_M
        return np.asarray(near & (self.outside_rad <= KEPT_RAD))

    def loosely_feasible(self) -> Flags:
        """Within 1.1 mm, limits and rows kept to 1e-5: what the published figures count."""
        return np.asarray((self.distance_m <= LOOSE_M) & (self.outside_rad <= LOOSE_RAD))

    def optimal(self, best: Array) -> Flags:
        """Objective within 1 % + 1e-3 of the best one known."""
        return np.asarray(self.objective <= (1.0 + OPTIMAL_SHARE) * best + OPTIMAL)


def worth(arm: Arm, position: Array, rotation: Array, run: Run) -> Worth:
    """Check every answer; one that is missing is infinitely wrong."""
    values = []
    for q, p, R in zip(run.q, position, rotation, strict=True):
        if not np.isfinite(q).all():
            values.append((np.inf, np.inf, np.inf, np.inf))
            continue
        values.append(
            (arm.distance_m(q, p), arm.angle_rad(q, R), arm.violation(q), arm.objective(q, R))
        )
    return Worth(*np.array(values).T)


def largest_step_rad(run: Run) -> float:
    """Largest change of a joint from one answer to the next."""
    return float(np.abs(np.diff(run.q, axis=0)).max())


def percent(flags: Flags) -> float:
    """Share of those that are true."""
    return 100.0 * float(np.mean(flags))
