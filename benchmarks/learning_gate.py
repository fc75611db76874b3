"""Pushes on the recorded arm: what a gated and an ungated learner make of them.

A push is added to the forces of the recording, in a random direction, at instants spread over the
test. Its estimate is measured minus predicted along that direction, averaged over the last third of
a second of the hold; its ghost is the same 5 to 14 rows after the release. Both are given as means
over all instants, which average the learner's own error, and at the worst instant as the
difference to a learner that is frozen for the time of the push and not pushed: what was eaten.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.learning.feature_ridge import FeatureRidge, LearnerState
from dforc.learning.gate import ContactSafe, GateLimits, UpdateGate
from services.experiments.forces.arm_learning import ArmTask, kernels_of
from services.experiments.rows import Row, at_least, at_most

HOLD_ROWS, AFTER_ROWS, AVERAGED_ROWS = 282, 15, 10  # 10 s, 0.5 s, 0.36 s
FIRST_ROW, LAST_ROW, BETWEEN_ROWS = 200, 4200, 100
MEMORY_ROWS = 84  # 3 s
LIMITS = GateLimits()
EATEN_BAR_N = 0.1
RAMPS_S = (2, 5, 10)
ROWS_PER_S = 28
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """Where a run begins, when and along what it is pushed, and the learner's state at first."""

    row: int
    lead: int  # rows before the push: the memory is at any age when it comes
    direction: Vector
    state: LearnerState


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Newtons along the push: at the end of the hold and after the release, one per trial."""

    held: Vector
    ghost: Vector


def gate_rows(task: ArmTask, say: Say) -> list[Row]:
    """Steps of 5 to 1 N, ramps to 5 N, and the loss on the recording as it is.

    A step of 1 N stays below the thresholds: it is learned, and the row says so.
    """
    learner = FeatureRidge(kernels_of(task), 200, 0)
    trials, free = _trials(task, learner)
    quiet = _pushed(task, learner, trials, 0.0, 0)
    rows = _loss_rows(task, learner, free)
    for force_n, bars in ((5.0, (4.9, 0.1)), (3.0, (2.8, 0.15)), (2.0, None), (1.0, None)):
        say(f"{force_n:g} N, gated and ungated")
        for gated in (True, False):
            found = _pushed(task, learner, trials, force_n, 0, gated=gated)
            name = f"{force_n:g} N held 10 s, {'gated' if gated else 'ungated'}"
            rows += _rows(name, force_n, found, quiet, bars if gated else None)
    for ramp_s in RAMPS_S:
        say(f"ramp to 5 N in {ramp_s} s")
        found = _pushed(task, learner, trials, 5.0, ramp_s * ROWS_PER_S, gated=True)
        still = _pushed(task, learner, trials, 0.0, ramp_s * ROWS_PER_S)
        rows += _rows(f"5 N reached in {ramp_s} s and held 10 s, gated", 5.0, found, still, None)
    return rows


def _rows(
    name: str, force_n: float, found: Found, quiet: Found, bars: tuple[float, float] | None
) -> list[Row]:
    held, ghost = float(found.held.mean()), float(found.ghost.mean())
    eaten = float((force_n - found.held + quiet.held).max())
    worst = float(np.abs(found.ghost - quiet.ghost).max())
    if bars is None:
        rows = [Row(f"{name}: at its end", held, "N"), Row(f"{name}: ghost", ghost, "N")]
    else:
        rows = [
            at_least(f"{name}: at its end", held, "N", bars[0]),
            at_most(f"{name}: ghost", abs(ghost), "N", bars[1]),
        ]
    return [
        *rows,
        *(
            Row(what, value, "N") if bars is None else at_most(what, value, "N", EATEN_BAR_N)
            for what, value in (
                (f"{name}: most eaten of {len(found.held)}", eaten),
                (f"{name}: most that differs after it", worst),
            )
        ),
    ]


def _loss_rows(task: ArmTask, learner: FeatureRidge, free: Matrix) -> list[Row]:
    """What gate and memory cost where nothing touches the arm."""
    learner.fit(task.train.x, task.train.y)
    safe = ContactSafe(learner, UpdateGate(LIMITS), MEMORY_ROWS)
    errors, learned = np.empty_like(free), 0
    for i in range(len(task.test)):
        errors[i] = task.test.y[i] - safe.predict(task.test.x[i])
        learned += safe.update(task.test.x[i], task.test.y[i])
    loss = 100.0 * (task.error(errors) / task.error(free) - 1.0)
    return [
        at_most("loss by the gate without contact", loss, "%", 3.0),
        Row("rows learned meanwhile", 100.0 * learned / len(task.test), "%"),
        Row("times the gate closed", float(safe.gate.closings), ""),
    ]


def _trials(task: ArmTask, learner: FeatureRidge) -> tuple[list[Trial], Matrix]:
    """Pushes spread over the test, and the ungated learner's errors without any."""
    rng = np.random.default_rng(0)
    learner.fit(task.train.x, task.train.y)
    trials, errors = [], np.empty_like(task.test.y)
    for i in range(len(task.test)):
        if FIRST_ROW <= i < LAST_ROW and (i - FIRST_ROW) % BETWEEN_ROWS == 0:
            direction = rng.standard_normal(3)
            direction /= np.linalg.norm(direction)
            lead = int(rng.integers(2 * MEMORY_ROWS))
            trials.append(Trial(i, lead, direction, learner.state()))
        errors[i] = learner.update(task.test.x[i], task.test.y[i])
    return trials, errors


def _pushed(
    task: ArmTask,
    learner: FeatureRidge,
    trials: list[Trial],
    force_n: float,
    ramp_rows: int,
    *,
    gated: bool = True,
) -> Found:
    """The estimates of every trial; a force of zero: known to be touched, without being pushed."""
    push = np.r_[np.linspace(0, 1, ramp_rows + 1)[1:], np.ones(HOLD_ROWS), np.zeros(AFTER_ROWS)]
    held, ghosts = [], []
    for trial in trials:
        learner.restore(trial.state)
        safe = ContactSafe(learner, UpdateGate(LIMITS), MEMORY_ROWS if gated else 0)
        shape = np.r_[np.zeros(trial.lead), push]
        estimate = np.empty(len(shape))
        for i, share in enumerate(shape):
            x, y = task.test.x[trial.row + i], task.test.y[trial.row + i].copy()
            y[:3] += force_n * share * trial.direction
            estimate[i] = (y - safe.predict(x))[:3] @ trial.direction
            if gated:
                safe.update(x, y, touched=force_n == 0.0 and share > 0.0)
            else:
                learner.update(x, y)
        release = trial.lead + ramp_rows + HOLD_ROWS
        held.append(estimate[release - AVERAGED_ROWS : release].mean())
        ghosts.append(estimate[release + AFTER_ROWS - AVERAGED_ROWS :].mean())
    return Found(np.array(held), np.array(ghosts))
